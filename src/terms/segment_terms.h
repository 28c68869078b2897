#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "term_operator.h"

namespace aberfit::internal {

/// Pistons and tilts of segments, at any points: each point has the terms of its own segment alone.
class SegmentTerms : public TermOperator {
 public:
  /// terms.segments must be there. Points are of the segments that the sample names, or that hold them.
  SegmentTerms(const TermSet& terms, const PupilSample& points);

  void forward(const Eigen::VectorXd& coefficients, int threads, bool add,
               SurfaceField* field) const override;
  void adjoint(const SurfaceField& weights, int threads, Eigen::VectorXd* sums) const override;
  /// Adds the sums over points of `weights` times the height of each term, to the entries of a vector of all
  /// terms that are its own.
  void add_heights(const Eigen::ArrayXd& weights, Eigen::Ref<Eigen::VectorXd> sums) const;

 private:
  // Terms at one point: their height, and their slopes along x and y.
  struct AtPoint {
    std::array<double, 3> height, slope_x, slope_y;
  };
  AtPoint at(Eigen::Index point) const;

  Eigen::Index begin_, each_;
  bool piston_;
  std::vector<Eigen::Index> first_;  // of each point's segment: its first term
  Eigen::ArrayXd u_, v_;             // from the centre of the segment, over its radius
  Eigen::ArrayXd per_radius_;        // [1/m]
};

}  // namespace aberfit::internal
