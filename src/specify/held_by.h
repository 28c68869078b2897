#pragma once
#include <Eigen/Core>
#include <vector>

#include "aberfit/specify/budget.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit::internal {

/// The mirrors of one specification.
struct ManyMirrors {
  const RadialPsd& psd;
  const GhsPupil& pupil;
  const GeneralisedHarveyShack& mean;  ///< their mean irradiance
  const std::vector<Budget>& budgets;
};

/// Returns statistics than which a fraction `confidence` of the mirrors are not worse, from those of the mean
/// [SI units]. Encircled energy is assumed normal with the standard deviation of `RealisationSpread`, RMS
/// height and slope with that of their samples.
Eigen::VectorXd held_by(double confidence, const ManyMirrors& mirrors, const Eigen::VectorXd& of_mean);

}  // namespace aberfit::internal
