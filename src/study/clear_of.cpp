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

Aperture clear_of(const ApertureSpec& spec, const SegmentedAperture& of_mask) {
  const Aperture shape = unobstructed(spec, of_mask);
  return spec.spiders.empty() ? shape : Aperture(obstructed(shape, spec.spiders));
}

bool leaves_something(const ApertureSpec& spec, const SegmentedAperture& of_mask) {
  constexpr double kLeastClear = 1e-6;
  return aperture_area(clear_of(spec, of_mask)) > kLeastClear * aperture_area(unobstructed(spec, of_mask));
}

}  // namespace aberfit::internal
