#pragma once
#include <optional>
#include <string>
#include <vector>

namespace aberfit::internal {

/// A rectangle of a picture [pixels].
struct PixelBox {
  double left = 0, right = 0, low = 0, high = 0;
  bool overlaps(const PixelBox& other) const {
    return left < other.right && other.left < right && low < other.high && other.low < high;
  }
};

/// Places labels beside their points so that none covers another, a point or the frame. Each label takes the
/// first free one of eight places around its point, so important labels must come first; nullopt if none is
/// free.
class LabelPlaces {
 public:
  LabelPlaces(double width, double height) : width_(width), height_(height) {}
  /// Keeps labels off a box, or off a `weak` one if there is another place.
  void block(const PixelBox& box, bool weak = false) { (weak ? weak_ : taken_).push_back(box); }
  /// Centre of the label of `text` (UTF-8) beside a point; `radius`: half the size of the point's mark.
  struct Place {
    double x = 0, y = 0;
  };
  std::optional<Place> put(double x, double y, double radius, const std::string& text);

 private:
  double width_, height_;
  std::vector<PixelBox> taken_, weak_;
};

}  // namespace aberfit::internal
