#include "aberfit/study/field_errors.h"

#include <algorithm>

namespace aberfit {

InputError input_error(const Study& study, const FieldError& error) {
  std::string pointer = "/" + error.field();
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return InputError(study.path, pointer, error.found(), error.allowed());
}

}  // namespace aberfit
