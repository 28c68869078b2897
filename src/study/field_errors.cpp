#include "aberfit/study/field_errors.h"

#include <algorithm>

#include "study_changes.h"

namespace aberfit {
using namespace internal;

InputError input_error(const Study& study, const FieldError& error) {
  std::string pointer = "/" + error.field();
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return InputError(file_with_changes(study.path, study.changes, pointer), pointer, error.found(),
                    error.allowed());
}

}  // namespace aberfit
