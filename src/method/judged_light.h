#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/theory/realisation_spread.h"

namespace aberfit::internal {

/// The judged energies. The energy in a disc about the axis determines each statistic to first order.
struct JudgedLight {
  struct Member {
    std::string name;
    double unit;       ///< energy in the disc for a relative difference of 1
    double margin;     ///< of the statistic, relative
    std::size_t disc;  ///< index; several members may share a disc
  };
  std::vector<FocalDisc> discs;
  std::vector<Member> members;

  /// Energy in each disc that corresponds to its closest margin.
  Eigen::ArrayXd limits() const {
    Eigen::ArrayXd limit = Eigen::ArrayXd::Constant(Eigen::Index(discs.size()), HUGE_VAL);
    for (const Member& one : members)
      limit[Eigen::Index(one.disc)] = std::min(limit[Eigen::Index(one.disc)], one.unit * one.margin);
    return limit;
  }
};

/// The mean irradiance of the mirrors of a task, and the spread of single mirrors around it.
struct LightOfMirrors {
  std::shared_ptr<const GeneralisedHarveyShack> mean;
  JudgedLight judged;
  RealisationSpread spread;

  MirrorSpread of_whole_band(const Task& task, const TargetSets& targets) const;
};

/// The task has roughness and a wave theory; convention `paper` uses half the heights.
LightOfMirrors light_of_mirrors(const Task& task, const Groundwork& ground, const TargetSets& targets,
                                int threads);

}  // namespace aberfit::internal
