#include "clear_of.h"

#include "aberfit/core/overloaded.h"

namespace aberfit::internal {
namespace {

Aperture unobstructed(const ApertureSpec& spec, const SegmentedAperture& of_mask) {
  return std::visit(Overloaded{[&](const MaskFile& mask) -> Aperture {
                                 SegmentedAperture outlines = of_mask;
                                 outlines.margin = mask.margin;
                                 return outlines;
                               },
                               [](const auto& shape) -> Aperture { return shape; }},
                    spec.shape);
}

}  // namespace

std::optional<Aperture> clear_of(const ApertureSpec& spec, const SegmentedAperture& of_mask) {
  constexpr double kLeastClear = 1e-6;  // fraction of the area
  const Aperture shape = unobstructed(spec, of_mask);
  if (spec.spiders.empty()) return shape;
  const Aperture left = obstructed(shape, spec.spiders);
  if (!(aperture_area(left) > kLeastClear * aperture_area(shape))) return std::nullopt;
  return left;
}

}  // namespace aberfit::internal
