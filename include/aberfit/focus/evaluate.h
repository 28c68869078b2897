#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

enum class Centre {
  kNominal,   ///< focus of the unperturbed mirror: x = y = 0 for rays along the axis
  kCentroid,  ///< weighted mean of the crossings of each plane
};

/// Input of the focal statistics.
struct FocusInput {
  const RayBundle& rays;
  const RayBundle& nominal;      ///< rays of the same pupil without surface error: reference of the scatter
                                 ///< angle. Only tx and ty are used, only for ScatterRms and ScatterMean.
  const Eigen::ArrayXd& height;  ///< surface error h at the pupil points [m]; may be empty without RmsHeight
  Centre centre = Centre::kNominal;
  /// RMS height [m] of roughness that deflects the rays but is not part of `height`. It is added in squares.
  double unseen_height = 0;
};

/// Memory that evaluations reuse: a second evaluation of the same size allocates nothing. Simultaneous
/// evaluations need one workspace each.
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

/// Exact values (order statistics, counts, moments) of the statistics, in their order. A statistic that does
/// not exist (no energy, ring never half full inside the search range, ...) is NaN, and `warnings`, when
/// given, says why.
Eigen::VectorXd evaluate_exact(const FocusInput& input, const std::vector<Statistic>& statistics, int threads,
                               Warnings* warnings = nullptr);

/// Gradient of one smooth statistic over the rays, and over the heights of the pupil points (RmsHeight only;
/// else empty). Moments and angles depend on all rays.
struct StatisticGradient {
  RayGradient rays;
  Eigen::ArrayXd d_height;
};

/// Smooth versions of the statistics, with gradients. The integral of a compact kernel of half-width `width`
/// [m] replaces each step function of radius, because order statistics have no usable derivative (PHYSICS 8).
/// This moves encircled-energy radii by O(width^2) relative to the spot, and by up to the width at ties.
/// Moments are exact. `gradients`, when given, gets one entry per statistic. Returns false when a statistic
/// or its derivative does not exist (degenerate focus).
bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, Eigen::VectorXd* values, std::vector<StatisticGradient>* gradients);

/// The same, but it reuses the memory of `workspace` and of the vectors in `gradients`.
bool evaluate_smooth(const FocusInput& input, const std::vector<Statistic>& statistics, double width,
                     int threads, FocusWorkspace* workspace, Eigen::VectorXd* values,
                     std::vector<StatisticGradient>* gradients);

}  // namespace aberfit
