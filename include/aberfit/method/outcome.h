#pragma once
#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/fit/calibrate.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/method/character.h"
#include "aberfit/method/frontier.h"
#include "aberfit/method/map_light.h"
#include "aberfit/method/mirror_spread.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/specified_light.h"
#include "aberfit/method/tost.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/theory/abg_fit.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/theory/regime.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// The fitted surface by the numbers of a scene (its own, not the specification's).
struct EquivalentSurface {
  double rms_height = 0;  ///< [m]
  double rms_slope_per_axis = 0;
  double g = 0, kappa = 0;
  std::string needed;              ///< "rays" or "waves": by its own height; empty without PSD
  double prior_height_factor = 1;  ///< 0.5 when the prior was scaled for convention `paper`
  double captured_fraction =
      0;  ///< share of the specification's height variance that the term set can carry; 0 without PSD
};

/// A PSD bin that was fitted along.
struct SpectrumBin {
  double low = 0, high = 0;       ///< [cycles/m]
  double target = 0, fitted = 0;  ///< [m^4]
  double tolerance = 0;           ///< of log PSD
};

/// Light's answer: the fitted surface by diffraction against generalised Harvey-Shack, or against given
/// values.
struct LightJudgement {
  bool decides = false;  ///< the verdict of the result is this one
  std::string theory;    ///< "ghs"; "given" where the targets are values
  std::string obstacle;  ///< why it could not be computed, a clause; empty: it was
  bool no_grid = false;  ///< because no grid holds the pupil's phase: the verdict is then that of rays, with
                         ///< the difference of geometric and generalised Harvey-Shack as their model error
  Verdict verdict = Verdict::kUndecided;
  std::vector<EquivalenceMetric> metrics;
};

/// What the perfect mirror would have said: whether a margin can see the roughness at all.
struct PerfectMirror {
  double mismatch = 0;    ///< largest of its differences in light, in tolerances of the verdict; of the focus
                          ///< alone where that is 1 or more
  std::string statistic;  ///< whose
};

/// The part of a split roughness that no term carries, as other programs take it.
struct ScatterOfRest {
  ScatterTable table;
  std::vector<AbgFit> abg;       ///< with B as OpticStudio takes it, and where that is poor, with a free one
  std::optional<PsdModel> rest;  ///< its PSD
};

/// What came of a task: the fit, the surface, the verdict on it. Statistic vectors run parallel to `targets`.
struct FitOutcome {
  ChosenByFit chosen;     ///< where the task left terms and rays open
  double confidence = 0;  ///< of the intervals of a verdict; 0: unknown
  bool has_roughness = false;
  SceneNumbers scene;                 ///< of the specification
  std::string theory;                 ///< "geometric", "rays", "ghs": what made the targets; "given", "map"
  std::string model = "rays";         ///< "rays", "waves": what turned the surface into statistics
  std::string needed;                 ///< the same words: what the scene needs; empty without roughness
  bool light_decides = true;          ///< the verdict is light's; else that of the theory the study names
  std::string model_reason;           ///< why it is needed, one sentence
  std::optional<ModelErrors> errors;  ///< of rays against GHS; absent without roughness
  SpecifiedLight mean_light;          ///< of the specification; empty without roughness and before `conclude`
  MirrorSpread spread;                ///< of the specification; empty before `conclude`
  std::vector<Target> targets;
  FitResult fit;
  TermSet terms;
  Eigen::Index rays = 0;
  double radius = 0;  ///< normalisation radius [m]
  EquivalentSurface surface;
  Eigen::VectorXd start, fitted, validated;
  Eigen::VectorXd posterior_std;      ///< of `fitted`, by the linearised problem
  std::vector<SpectrumBin> spectrum;  ///< empty where no PSD bins were asked for
  std::optional<Frontier> frontier;   ///< the sets that were tried; absent: terms were given
  std::optional<RayChoice> ray_choice;
  std::optional<BandUse> band;           ///< absent without roughness
  std::optional<BandShares> shares;      ///< absent where the roughness is not split
  std::optional<ScatterOfRest> scatter;  ///< likewise
  std::optional<MapFitResult> map;      ///< least-squares fit of a measured map; without roughness statistics
                                        ///< then have no target
  std::optional<MapPanels> map_panels;  ///< measured, fitted and left, where a map was fitted
  std::optional<MapLight> map_light;    ///< likewise
  Verdict verdict = Verdict::kUndecided;   ///< that of `light` where it decides
  std::vector<EquivalenceMetric> metrics;  ///< on the model of the fit
  std::optional<LightJudgement> light;     ///< absent where `metrics` are light's own, and without a fit
  std::optional<PerfectMirror> perfect;    ///< absent where the scene has no GHS
  bool interrupted = false;                ///< asked to stop: the best so far
  std::string stopped_by;                  ///< what asked, in words; empty where nothing did
  /// Of the surface beside the roughness its terms stand for; absent without one, and where the run was
  /// asked to stop.
  std::optional<Character> character;
  Warnings warnings;
};

}  // namespace aberfit
