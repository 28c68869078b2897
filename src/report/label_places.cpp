#include "label_places.h"

#include <algorithm>

namespace aberfit::internal {
namespace {

constexpr double kCharacter = 7.6, kLine = 15;  // size of a letter of DejaVu Sans at 11 points [pixels]

double letters(const std::string& text) {
  return double(std::count_if(text.begin(), text.end(),
                              [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

}  // namespace

std::optional<LabelPlaces::Place> LabelPlaces::put(double x, double y, double radius,
                                                   const std::string& text) {
  const double half = 0.5 * kCharacter * letters(text), rise = 0.5 * kLine;
  const double aside = radius + half + 2, up = radius + rise + 3;
  const double dx[] = {aside, 0, 0, -aside, aside, aside, -aside, -aside};
  const double dy[] = {0, up, -up, 0, 0.8 * up, -0.8 * up, 0.8 * up, -0.8 * up};
  const auto is_free = [](const std::vector<PixelBox>& boxes, const PixelBox& box) {
    return std::none_of(boxes.begin(), boxes.end(), [&](const PixelBox& b) { return b.overlaps(box); });
  };
  for (const bool over_weak : {false, true}) {
    for (int k = 0; k < 8; ++k) {
      const Place place{x + dx[k], y + dy[k]};
      const PixelBox box{place.x - half, place.x + half, place.y - rise, place.y + rise};
      if (box.left < 0 || box.right > width_ || box.low < 0 || box.high > height_) continue;
      if (!is_free(taken_, box) || (!over_weak && !is_free(weak_, box))) continue;
      taken_.push_back(box);
      return place;
    }
  }
  return std::nullopt;
}

}  // namespace aberfit::internal
