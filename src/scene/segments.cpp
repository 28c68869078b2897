#include "aberfit/scene/segments.h"

#include <algorithm>
#include <cmath>

#include "polygon.h"

namespace aberfit {

Segments::Segments(const SegmentedAperture& aperture)
    : piston_(aperture.piston), tip_tilt_(aperture.tip_tilt) {
  const double sense = internal::area_of(aperture.outlines).twice_area;
  struct Measured {
    const Outline* outline;
    internal::PolygonArea area;
  };
  std::vector<Measured> outlines;
  for (const Outline& outline : aperture.outlines)
    outlines.push_back({&outline, internal::polygon_area(outline)});
  const auto is_clear = [&](const Measured& one) { return sense * one.area.twice_area > 0; };
  std::stable_partition(outlines.begin(), outlines.end(), is_clear);
  const auto holder = [&](const Measured& one) -> Segment* {
    const auto [x, y] = one.area.centroid;
    for (Segment& segment : all_)
      if (internal::is_inside({segment.clear.data(), 1}, x, y, 0)) return &segment;
    return nullptr;
  };
  // Where two vanes cross, both subtract their common area, and an extra outline adds it back. That outline
  // comes after its segment in the list.
  for (const Measured& one : outlines) {
    if (Segment* const segment = holder(one)) {
      segment->clear.push_back(*one.outline);
    } else if (is_clear(one)) {
      Segment& found = all_.emplace_back(Segment{{*one.outline}, one.area.centroid, 0});
      for (const auto& [x, y] : *one.outline)
        found.radius = std::max(found.radius, std::hypot(x - found.centre[0], y - found.centre[1]));
    }
  }
}

double Segments::variance(std::size_t segment, double x, double y) const {
  const auto& centre = all_[segment].centre;
  return piston_ * piston_ +
         tip_tilt_ * tip_tilt_ * (std::pow(x - centre[0], 2) + std::pow(y - centre[1], 2));
}

std::size_t Segments::at(double x, double y) const {
  const auto from_centre2 = [&](const Segment& segment) {
    return std::pow(x - segment.centre[0], 2) + std::pow(y - segment.centre[1], 2);
  };
  for (std::size_t k = 0; k < all_.size(); ++k)
    if (from_centre2(all_[k]) <= all_[k].radius * all_[k].radius &&
        internal::is_inside({all_[k].clear.data(), 1}, x, y, 0))
      return k;
  std::size_t nearest = 0;
  double least = HUGE_VAL;
  for (std::size_t k = 0; k < all_.size(); ++k) {
    if (std::sqrt(from_centre2(all_[k])) - all_[k].radius >= least) continue;
    const double distance = internal::distance_to_outline(all_[k].clear.front(), x, y);
    if (distance < least) least = distance, nearest = k;
  }
  return nearest;
}

bool has_segment_errors(const Aperture& aperture) {
  const auto* segmented = std::get_if<SegmentedAperture>(&aperture);
  return segmented && (segmented->piston > 0 || segmented->tip_tilt > 0);
}

std::shared_ptr<const Segments> erring_segments(const Aperture& aperture) {
  if (!has_segment_errors(aperture)) return nullptr;
  return std::make_shared<const Segments>(std::get<SegmentedAperture>(aperture));
}

Aperture without_segment_errors(Aperture aperture) {
  if (auto* segmented = std::get_if<SegmentedAperture>(&aperture))
    segmented->piston = segmented->tip_tilt = 0;
  return aperture;
}

}  // namespace aberfit
