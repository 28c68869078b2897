#include "smallest_radius.h"

#include <fmt/format.h>

#include "aberfit/core/units.h"

namespace aberfit {
namespace {

constexpr double kNarrower = 0.02;
}  // namespace

std::string below_diffraction(const Target& target, double perfect) {
  if (!(target.value + target.tolerance < (1 - kNarrower) * perfect)) return {};
  return fmt::format(
      "the target {} = {} lies below the {} of a perfect mirror: the aperture's diffraction allows no less",
      statistic_name(target.statistic), format_quantity(target.value, Dimension::kLength),
      format_quantity(perfect, Dimension::kLength));
}

}  // namespace aberfit
