#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/specify/budget.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit::internal {

/// Mirrors of one specification.
struct ManyMirrors {
  const RadialPsd& psd;
  const GhsPupil& pupil;
  const GeneralisedHarveyShack& mean;  ///< their mean light
  const std::vector<Budget>& budgets;
};

/// The statistics of the budgets that a share `confidence` of the mirrors are no worse than, of those of the
/// mean light [their SI units]: light inside a radius is taken as normal about its mean with the standard
/// deviation of `RealisationSpread`, RMS height and slope with that of their samples.
Eigen::VectorXd held_by(double confidence, const ManyMirrors& mirrors, const Eigen::VectorXd& of_mean);

}  // namespace aberfit::internal
