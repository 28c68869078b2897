#pragma once
#include <memory>
#include <vector>

#include "aberfit/scene/aperture.h"

namespace aberfit {

/// The segments of an aperture with height errors: which segment holds a point, and how large its errors are.
/// A segment is an outline around a clear area that lies in no larger segment. Holes and vanes belong to the
/// segment around them.
class Segments {
 public:
  struct Segment {
    std::vector<Outline> clear;    ///< its outline, then holes and vanes in it
    std::array<double, 2> centre;  ///< centroid of the area inside the outline [m]
    double radius;                 ///< distance of its farthest corner from the centre [m]
  };
  explicit Segments(const SegmentedAperture& aperture);

  const std::vector<Segment>& all() const { return all_; }
  double piston() const { return piston_; }      ///< standard deviation [m]
  double tip_tilt() const { return tip_tilt_; }  ///< standard deviation of each of the two slopes
  /// Variance of the height of a segment at (x, y) [m^2].
  double variance(std::size_t segment, double x, double y) const;
  /// The segment that holds (x, y) [m], or else the nearest one: the centre of a cut grid cell may be in a
  /// gap.
  std::size_t at(double x, double y) const;

 private:
  std::vector<Segment> all_;
  double piston_ = 0, tip_tilt_ = 0;
};

/// Returns whether the segments of an aperture have height errors.
bool has_segment_errors(const Aperture& aperture);
/// The segments of an aperture if they have height errors; else null.
std::shared_ptr<const Segments> erring_segments(const Aperture& aperture);
/// The same aperture with zero piston, tip and tilt errors.
Aperture without_segment_errors(Aperture aperture);

}  // namespace aberfit
