#pragma once
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/study/study.h"

namespace aberfit {

/// The method's error about a field as an InputError, with the field's file and JSON pointer in the study.
InputError input_error(const Study& study, const FieldError& error);

/// Throws an InputError about the first unusual number of `study` (study/unusual.h) that may have caused
/// `failure`, a text. Returns if there is none.
void blame_unusual_number(const Study& study, const std::string& failure);

/// Runs `work` on `study`. A FieldError becomes an InputError about the study's file. A ComputationError does
/// so, too, if the study has a number that can hardly be meant: the author has to look at that number, not at
/// its consequence.
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
