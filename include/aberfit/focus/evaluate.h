#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

enum class Centre {
  kNominal,   ///< the focus of the unperturbed mirror: x = y = 0 for light along the axis
  kCentroid,  ///< weighted mean of the crossings of the plane in question
};

/// What the statistics are functions of.
struct FocusInput {
  const RayBundle& rays;
  const RayBundle& nominal;  ///< the same pupil on the mirror without surface error: reference of the scatter
                             ///< angle. Only its tx and ty are read, and only for ScatterRms and ScatterMean.
  const Eigen::ArrayXd&
      height;  ///< surface error h at the pupil points [m]; may be empty when RmsHeight is not asked for
  Centre centre = Centre::kNominal;
  /// RMS height [m] of roughness that turns the rays but is not among the heights: added in squares.
  double unseen_height = 0;
};

/// Memory that evaluations reuse, so that a second one of the same size allocates nothing. One per caller:
/// not to be shared between evaluations that run at the same time.
class FocusWorkspace {
 public:
  FocusWorkspace();
  ~FocusWorkspace();
  FocusWorkspace(FocusWorkspace&&) noexcept;
  FocusWorkspace& operator=(FocusWorkspace&&) noexcept;
  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

/// Exact values (order statistics, counts, moments) in the order asked. NaN where a statistic does not exist
/// (no light, ring never half full inside the search range, ...), each with a warning when `warnings` is
/// given.
Eigen::VectorXd evaluate_exact(const FocusInput& input, const std::vector<Statistic>& statistics, int threads,
                               Warnings* warnings = nullptr);

/// Gradient of one smooth statistic: over rays (moments and angles: all of them), and over the heights of the
/// pupil points (RmsHeight only; else empty).
struct StatisticGradient {
  RayGradient rays;
  Eigen::ArrayXd d_height;
};

/// Smooth twins: indicator functions of radius are replaced by the integral of a compact kernel of half-width
/// `width` [m], which moves EE radii by O(width^2) relative to the spot, at ties by up to the width (PHYSICS
/// 8 says why: order statistics have no usable derivative). Moments are exact. `gradients`, when given, gets
/// one entry per statistic. False when a statistic or its derivative does not exist (degenerate focus).
bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, Eigen::VectorXd* values, std::vector<StatisticGradient>* gradients);

/// The same with memory that is reused: that of `workspace`, and that of the vectors in `gradients`.
bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, FocusWorkspace* workspace, Eigen::VectorXd* values,
                     std::vector<StatisticGradient>* gradients);

}  // namespace aberfit
