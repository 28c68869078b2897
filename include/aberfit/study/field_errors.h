#pragma once
#include "aberfit/core/errors.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// What the method says of a field, with the file and the JSON pointer that it has in the study.
InputError input_error(const Study& study, const FieldError& error);

/// Runs `work` on what `study` asks for; a FieldError leaves as an InputError of the study's file.
template <typename Work>
auto with_fields_of(const Study& study, const Work& work) {
  try {
    return work();
  } catch (const FieldError& error) {
    throw input_error(study, error);
  }
}

}  // namespace aberfit
