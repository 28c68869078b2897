#include "aberfit/study/field_errors.h"

#include <fmt/format.h>

#include <algorithm>

#include "aberfit/study/unusual.h"
#include "study_changes.h"

namespace aberfit {
using namespace internal;

namespace {

InputError error_of(const Study& study, const UnusualNumber& number, const std::string& failure) {
  return {file_with_changes(study.path, study.changes, number.pointer), number.pointer,
          fmt::format("{}; a wrong unit? It is {}, and nothing can be computed: {}", number.value,
                      number.quantity, failure),
          fmt::format("{}. {}", number.ordinary, number.meant)};
}

// These blocks hold the numbers of a scene. An error about one of them may be due to any other.
bool is_of_scene(const std::string& field) {
  const std::string block = field.substr(0, field.find('.'));
  return block == "mirror" || block == "aperture" || block == "light" || block == "roughness";
}

}  // namespace

InputError input_error(const Study& study, const FieldError& error) {
  const std::vector<UnusualNumber> unusual = unusual_numbers(study);
  if (!unusual.empty() && is_of_scene(error.field())) return error_of(study, unusual.front(), error.found());
  std::string pointer = "/" + error.field();
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return InputError(file_with_changes(study.path, study.changes, pointer), pointer, error.found(),
                    error.allowed());
}

// Other parts in the path of the light and a very smooth mirror do not make a computation fail.
void blame_unusual_number(const Study& study, const std::string& failure) {
  for (const UnusualNumber& number : unusual_numbers(study)) {
    const bool of_path = number.pointer.starts_with("/solve/with");
    const bool smooth = number.too_small && number.pointer.starts_with("/roughness");
    if (!of_path && !smooth) throw error_of(study, number, failure);
  }
}

}  // namespace aberfit
