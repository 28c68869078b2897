#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/scene_facts.h"
#include "aberfit/method/tost.h"
#include "aberfit/method/trace_surface.h"

namespace aberfit {

/// The paper's published phase synthesis: Phi = sum sqrt(P0 dA_k) cos(2 pi f_k.x + phi_k) [rad] over modes
/// log-uniform in f, with dA_k taken with log10 and no factor 4 pi/lambda (PHYSICS 9). Kept to show what
/// those formulas give.
struct PhaseSynthesis {
  double psd_level = 1e-20;  ///< P0 as printed
  int modes = 10000;
  double f_min = 2.5;  ///< [cycles/m]
  double f_max = 1e6;  ///< [cycles/m]
};

/// Zernikes n = 2..n_max drawn independently with equal variance and a total RMS height: a candidate reading
/// of the paper's aberration branch.
struct IndependentTerms {
  int n_max = 8;
  double rms = 100e-9;  ///< [m]
  int draws = 200;
};

/// What a verify run computes beside its two branches.
struct VerifyAside {
  std::optional<PhaseSynthesis> published_phase;
  std::optional<IndependentTerms> independent_terms;
};

/// Named numbers of a verify run [SI], keys like "theory.ee90_radius_m", "harvey_shack.scatter_mean_rad",
/// "scene.paper_ratio_r".
using Quantities = std::map<std::string, double>;

/// A number printed elsewhere beside ours, both in the printed unit.
struct PublishedComparison {
  std::string label;
  double printed = 0, ours = 0;  ///< NaN: there is none of ours
  std::string unit;              ///< of both
  std::string from;              ///< quantity or formula that ours comes from; empty: a reading only
  std::string reading;           ///< what holds and what does not, in a sentence
};

/// Harvey-Shack and aberration-term branch of one roughness side by side.
struct VerifyReport {
  std::string title;  ///< of the task, for people
  Convention convention = Convention::kPhysical;
  Verdict verdict = Verdict::kUndecided;  ///< over `metrics`; undecided where rays are no model of the scene
  SceneFacts scene;                       ///< its model is "rays", whatever the scene needs
  Eigen::Index rays = 0;                  ///< of each branch
  double spread = 0;           ///< relative scatter between draws that entered the test; 0: a given surface
  double margin = 0;           ///< of the test, relative
  std::vector<double> theory;  ///< in closed form, parallel to `metrics` [SI]
  std::vector<EquivalenceMetric> metrics;  ///< target: Harvey-Shack branch; model: aberration terms
  std::vector<PublishedComparison> published;
  Quantities quantities;
  Warnings warnings;
};

/// Both branches by rays: perturbed ones, and those of the given surface or of the draw of the task's seed.
/// The task has a roughness. A draw is one realisation, so the scatter between draws enters the test; a
/// given surface is judged on its own statistics. `published` stays empty: its formulas belong to the task.
VerifyReport verify(const Task& task, const VerifyAside& aside, const std::optional<GivenSurface>& given,
                    int threads);

}  // namespace aberfit
