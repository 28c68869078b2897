#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/scene_facts.h"
#include "aberfit/method/tost.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/trace/ray_bundle.h"

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
  /// Surfaces drawn for the ensemble means, rounded up to a multiple of law::kGroups; absent: as many as
  /// the margin needs, see ensemble_draws.
  std::optional<int> draws;
  std::optional<PhaseSynthesis> published_phase;
  std::optional<IndependentTerms> independent_terms;
};

/// Named numbers of a verify run [SI], keys like "theory.ee90_radius_m", "harvey_shack.scatter_mean_rad",
/// "scene.paper_ratio_r".
using Quantities = std::map<std::string, double>;

/// A number printed elsewhere beside ours, both in the printed unit.
struct PublishedComparison {
  std::string id, section;  ///< stable key and place there; may be empty
  std::string label;
  std::string printed_text;  ///< as printed, digit for digit, or what is said instead of a number
  double printed = 0;        ///< the same as a number; NaN: it is none
  bool derived = false;      ///< the source does not print the number: it follows from what it does print
  double ours = 0;           ///< NaN: there is none of ours
  std::string unit;          ///< of both
  std::string from;          ///< what ours comes from: quantity, formula, expression; empty: none
  double within = 0;         ///< |ours - printed| that still holds, in the unit; NaN: not compared so
  std::string verdict;       ///< a word: "holds", "fails", "reading", "input", ...
  std::string reading;       ///< what holds and what does not, in a sentence
  std::string picture;       ///< of verify's pictures, the one that shows it; empty: none
};

/// How rays differ in direction from their nominal rays: unit vector less unit vector [1, rad where small].
struct Deflections {
  Eigen::ArrayXd x, y, z, magnitude;
  Eigen::ArrayXd weight;                            ///< shares of the light, summing to 1
  double rms_x = 0, rms_y = 0, rms_z = 0, rms = 0;  ///< of the components and the magnitude
  double mean_x = 0, mean_y = 0, mean_z = 0, mean = 0;
};
Deflections deflections_of(const RayBundle& rays, const RayBundle& nominal);

inline constexpr double kIdealRing = 10e-6;  ///< the ring that the paper lays around the ideal focus [m]

/// The rays and modes behind a report, for its pictures.
struct VerifyRays {
  PupilSample pupil;
  RayBundle nominal, harvey_shack, terms;
  SurfaceField field;                        ///< surface error behind `terms` at the pupil points
  GivenSurface surface;                      ///< its terms
  std::vector<FourierMode> published_modes;  ///< of the published phase; empty: not asked for
};

/// Draws of an ensemble: as many as put 4.6 standard errors, with a spread that is
/// known to a factor 1.5 6.9 predicted ones, of the worst statistic's mean into its margin, so
/// that equal means are `equivalent` in a dozen statistics at once: 1.75 for the interval (Student's t, 95 %,
/// 15 degrees of freedom), 2.87 for the difference (normal, 5 % over 12, two-sided). spread: of single
/// mirrors in the worst statistic, one standard deviation over the margin. A multiple of law::kGroups from
/// twice to law::kMostGroupDraws times that: low-frequency roughness scatters so much that no number of draws
/// to be waited for will do, and the verdict is then undecided.
int ensemble_draws(double spread);

/// Harvey-Shack and aberration-term branch of one roughness side by side, by rays and in light.
struct VerifyReport {
  std::string title;  ///< of the task, for people
  Convention convention = Convention::kPhysical;
  /// Of the theory that the task names: of `metrics` for theory `geometric` and convention `paper`, else of
  /// `light`. Where light was not computed, that of rays in a scene that needs no more, else undecided.
  Verdict verdict = Verdict::kUndecided;
  bool rays_decide = false;                ///< which of the two that is
  SceneFacts scene;                        ///< its model is "rays", whatever the scene needs
  Eigen::Index rays = 0;                   ///< of the pupil on which one draw is shown
  int draws = 0;                           ///< behind every ensemble mean; 0: a given surface
  double margin = 0;                       ///< of the test, relative
  std::vector<double> theory;              ///< geometric, in closed form, parallel to `metrics` [SI]
  std::vector<EquivalenceMetric> metrics;  ///< target: Harvey-Shack branch; model: aberration terms
  /// In light. target: generalised Harvey-Shack (of half the heights in convention `paper`); model: waves.
  /// Judged in shares of the light: relative_difference and margin are as in share_metric.
  std::vector<EquivalenceMetric> light;
  Verdict rays_verdict = Verdict::kUndecided, light_verdict = Verdict::kUndecided;
  int light_draws = 0;         ///< as `draws`; fewer where the grid of waves is fine
  std::string light_obstacle;  ///< why `light` is empty, a clause; empty: it is not
  std::vector<PublishedComparison> published;
  Quantities quantities;
  std::shared_ptr<const VerifyRays> shown;  ///< for pictures
  Warnings warnings;
};

/// An EE radius judged in light (PHYSICS 7). radius: theory's, holding `fraction`; slope: dE/dr there [1/m];
/// share: of the light inside it in truth. relative_difference = (fraction - share)/max(r dE/dr, 0.35), the
/// sign of the radius that would hold the fraction; `model` is that radius to first order, NaN where
/// it is more than a quarter away. error: of share.
EquivalenceMetric share_metric(const std::string& name, double fraction, double radius, double slope,
                               double share, double error, double margin, double confidence);

/// Both branches, by rays and in light. The task has a roughness.
///
/// Rays: perturbed ones against the term surface. Light: generalised Harvey-Shack against the diffraction of
/// the term surface. A roughness is an ensemble and one draw of it scatters, so what is compared is the
/// *mean light* of `draws` surfaces of the task's prior: the statistic of all their rays together, the mean
/// of their shares of light - not the mean of their radii, which theory does not predict. Standard error
/// from law::kGroups groups of draws, Student's t with one degree less; the verdict is TOST on the means.
/// A given surface is judged on its own statistics instead. `published` stays empty: its formulas belong to
/// the task.
VerifyReport verify(const Task& task, const VerifyAside& aside, const std::optional<GivenSurface>& given,
                    int threads);

}  // namespace aberfit
