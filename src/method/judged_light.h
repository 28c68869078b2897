#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/theory/realisation_spread.h"

namespace aberfit::internal {

/// The light that is judged, each statistic by a disc about the axis whose light moves it to first order.
struct JudgedLight {
  std::vector<FocalDisc> discs;
  std::vector<std::string> names;
  std::vector<double> units;    ///< light in the disc that a relative difference of 1 is worth
  std::vector<double> margins;  ///< that each is judged by, relative

  Eigen::ArrayXd unit() const {
    return Eigen::Map<const Eigen::ArrayXd>(units.data(), Eigen::Index(units.size()));
  }
  /// Light that the margin is worth.
  Eigen::ArrayXd tolerance() const {
    return unit() * Eigen::Map<const Eigen::ArrayXd>(margins.data(), Eigen::Index(margins.size()));
  }
};

/// The light of all mirrors of a task, and how single ones differ from it.
struct LightOfMirrors {
  std::shared_ptr<const GeneralisedHarveyShack> mean;
  JudgedLight judged;
  RealisationSpread spread;

  MirrorSpread of_whole_band(const Task& task, const TargetSets& targets) const;
};

/// For a task with roughness and a theory of light; in convention `paper` of half the heights, as its light
/// is judged.
LightOfMirrors light_of_mirrors(const Task& task, const Groundwork& ground, const TargetSets& targets,
                                int threads);

}  // namespace aberfit::internal
