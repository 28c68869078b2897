#pragma once
#include <memory>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

/// The segments of an aperture whose heights err: which one a point is of, and what one draw of its errors
/// can be. Outlines that go round what is clear and lie in no larger one are segments; all others, holes and
/// vanes, belong to the segment that they lie in.
class Segments {
 public:
  struct Segment {
    std::vector<Outline> clear;    ///< its outline, then holes and vanes in it
    std::array<double, 2> centre;  ///< of the area that the outline holds [m]
    double radius;                 ///< of its farthest corner from there [m]
  };
  explicit Segments(const SegmentedAperture& aperture);

  const std::vector<Segment>& all() const { return all_; }
  double piston() const { return piston_; }      ///< standard deviation [m]
  double tip_tilt() const { return tip_tilt_; }  ///< of each of the two slopes
  /// Variance of the height of a segment at (x, y) [m^2].
  double variance(std::size_t segment, double x, double y) const;
  /// The segment that holds (x, y) [m], or the nearest one: cells that an edge cuts have their middle in a
  /// gap.
  std::size_t at(double x, double y) const;

 private:
  std::vector<Segment> all_;
  double piston_ = 0, tip_tilt_ = 0;
};

/// Whether the segments of an aperture err at all.
bool has_segment_errors(const Aperture& aperture);
/// The segments of an aperture, if they err; else null.
std::shared_ptr<const Segments> erring_segments(const Aperture& aperture);
/// The same aperture with segments in their places.
Aperture without_segment_errors(Aperture aperture);

}  // namespace aberfit
