#pragma once
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// What the method says of a field, with the file and the JSON pointer that it has in the study.
InputError input_error(const Study& study, const FieldError& error);

/// Throws the InputError of the first number of `study` that is unusual (study/unusual.h) and may be the
/// reason of `failure`, in words; returns where there is none.
void blame_unusual_number(const Study& study, const std::string& failure);

/// Runs `work` on what `study` asks for. A FieldError leaves as an InputError of the study's file, and so
/// does a ComputationError of a study with a number that can hardly be meant: the number is what its author
/// has to look at, not what became of it.
template <typename Work>
auto with_fields_of(const Study& study, const Work& work) {
  try {
    return work();
  } catch (const FieldError& error) {
    throw input_error(study, error);
  } catch (const InputError&) {
    throw;
  } catch (const Interrupted&) {
    throw;
  } catch (const ComputationError& error) {
    blame_unusual_number(study, error.what());
    throw;
  }
}

}  // namespace aberfit
