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
#include "aberfit/method/plan.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/tost.h"
#include "aberfit/terms/term_set.h"
#include "aberfit/theory/abg_fit.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// Numbers of the fitted surface itself, not of the specification.
struct EquivalentSurface {
  double rms_height = 0;  ///< [m]
  double rms_slope_per_axis = 0;
  double g = 0, kappa = 0;
  std::string needed;              ///< "rays" or "waves", from the surface's own height; empty without PSD
  double prior_height_factor = 1;  ///< 0.5 when the prior was scaled for convention `paper`
  double captured_fraction =
      0;  ///< fraction of the specification's height variance that the term set can carry; 0 without PSD
};

/// A PSD bin that was fitted together with the statistics.
struct SpectrumBin {
  double low = 0, high = 0;       ///< edges [cycles/m]
  double target = 0, fitted = 0;  ///< [m^4]
  double tolerance = 0;           ///< of log PSD
};

/// Judgement by wave optics: diffraction of the fitted surface against GHS or given values.
struct LightJudgement {
  bool decides = false;  ///< this is the verdict of the result
  std::string theory;    ///< "ghs"; "given" where the targets are values
  std::string obstacle;  ///< why it could not be computed, a clause; empty: it was
  bool no_grid = false;  ///< no grid holds the pupil's phase; rays then judge, with the difference of
                         ///< geometric and generalised Harvey-Shack as their model error
  Verdict verdict = Verdict::kUndecided;
  std::vector<EquivalenceMetric> metrics;
};

/// Result of the perfect mirror. It shows whether the margin can detect the roughness at all.
struct PerfectMirror {
  double mismatch = 0;    ///< largest difference by wave optics, in tolerances; of the focus alone if >= 1
  std::string statistic;  ///< the statistic with that difference
};

/// The part of a split roughness above the terms, in the formats of other programs.
struct ScatterOfRest {
  ScatterTable table;
  std::vector<AbgFit> abg;       ///< a fit with B as in OpticStudio; if it is poor, also one with a free B
  std::optional<PsdModel> rest;  ///< its PSD
};

/// Values for terms and rays that the task left open, and how they were found.
struct FitChoices {
  ChosenByFit values;
  std::optional<Frontier> frontier;  ///< the sets that were tried; absent: terms were given
  std::optional<RayChoice> rays;
};

/// The terms that were fitted and what they give. Statistic vectors run parallel to `targets`.
struct FittedTerms {
  std::vector<Target> targets;
  TermSet terms;
  FitResult fit;
  Eigen::Index rays = 0;
  double radius = 0;  ///< normalisation radius [m]
  EquivalentSurface surface;
  Eigen::VectorXd start, values, validated;
  Eigen::VectorXd posterior_std;      ///< standard deviation of `values`, from the linearised problem
  std::vector<SpectrumBin> spectrum;  ///< empty without PSD bins in the study
};

/// Division of the roughness into terms and scatter.
struct BandOutcome {
  std::optional<BandUse> use;            ///< absent without roughness
  std::optional<BandShares> shares;      ///< absent where the roughness is not split
  std::optional<ScatterOfRest> scatter;  ///< absent where the roughness is not split
};

/// The fit of a measured map; all is absent where the targets are statistics.
struct FittedMap {
  std::optional<MapFitResult> fit;
  std::optional<MapPanels> panels;  ///< measured, fitted and residual heights
  std::optional<MapLight> light;
};

/// Judgement of whether the surface is equivalent to its specification.
struct Judgement {
  Verdict verdict = Verdict::kUndecided;   ///< the verdict of `light` where it decides
  std::vector<EquivalenceMetric> metrics;  ///< by the model of the fit
  double confidence = 0;                   ///< level of the intervals; 0: unknown
  bool light_decides = true;  ///< wave optics gives the verdict; else the theory that the study names
  std::optional<LightJudgement> light;   ///< absent where `metrics` come from wave optics, and without a fit
  std::optional<PerfectMirror> perfect;  ///< absent where the scene has no GHS
  /// Character of the surface; absent without roughness, and where the run was stopped.
  std::optional<Character> character;
};

/// The outcome of a task: the fit, the surface, and its verdict.
struct FitOutcome {
  FitChoices choices;
  bool has_roughness = false;
  SceneFacts scene;  ///< facts of the specification; numbers, light and spread are empty without roughness
  FittedTerms fitted;
  BandOutcome band;
  FittedMap map;
  Judgement judgement;
  bool interrupted = false;  ///< the run was stopped; the best fit so far
  std::string stopped_by;    ///< what stopped it, in words; empty: it was not stopped
  Warnings warnings;
};

}  // namespace aberfit
