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

/// The light that is judged, each statistic by a disc about the axis whose light moves it to first order.
struct JudgedLight {
  struct Member {
    std::string name;
    double unit;       ///< light in the disc that a relative difference of 1 is worth
    double margin;     ///< that it is judged by, relative
    std::size_t disc;  ///< several may share one
  };
  std::vector<FocalDisc> discs;
  std::vector<Member> members;

  /// Light that the closest margin of each disc is worth.
  Eigen::ArrayXd limits() const {
    Eigen::ArrayXd limit = Eigen::ArrayXd::Constant(Eigen::Index(discs.size()), HUGE_VAL);
    for (const Member& one : members)
      limit[Eigen::Index(one.disc)] = std::min(limit[Eigen::Index(one.disc)], one.unit * one.margin);
    return limit;
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
