#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "term_operator.h"

namespace aberfit::internal {

/// Pistons and tilts of segments at any points. Each point has only the terms of its own segment.
class SegmentTerms : public TermOperator {
 public:
  /// terms.segments must exist. A point's segment is named by the sample; otherwise it is the one that holds
  /// it.
  SegmentTerms(const TermSet& terms, const PupilSample& points);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;
  /// Adds to the segments' entries of a vector of all terms the sums over points of `weights` times the
  /// heights.
  void add_heights(const Eigen::ArrayXd& weights, Eigen::Ref<Eigen::VectorXd> sums) const;

 private:
  // Terms at one point: their height, and their slopes along x and y.
  struct AtPoint {
    std::array<double, 3> height, slope_x, slope_y;
  };
  AtPoint at(Eigen::Index point) const;

  Eigen::Index begin_, each_;
  bool piston_;
  std::vector<Eigen::Index> first_;  // first term of each point's segment
  Eigen::ArrayXd u_, v_;             // position from the centre of the segment, over its radius
  Eigen::ArrayXd per_radius_;        // [1/m]
};

}  // namespace aberfit::internal
