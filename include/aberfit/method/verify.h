#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/run_context.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/tost.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

/// Difference of ray directions from their nominal rays: unit vector minus unit vector [1, rad where small].
struct Deflections {
  Eigen::ArrayXd x, y, z, magnitude;
  Eigen::ArrayXd weight;                            ///< energy fractions, summing to 1
  double rms_x = 0, rms_y = 0, rms_z = 0, rms = 0;  ///< RMS of the components and the magnitude
  double mean_x = 0, mean_y = 0, mean_z = 0, mean = 0;
};
Deflections deflections_of(const RayBundle& rays, const RayBundle& nominal);

inline constexpr double kIdealRing = 10e-6;  ///< the ring that the paper lays around the ideal focus [m]

/// The rays and terms behind a report, for its pictures.
struct VerifyRays {
  PupilSample pupil;
  RayBundle nominal, harvey_shack, terms;
  SurfaceField field;    ///< surface error behind `terms` at the pupil points
  GivenSurface surface;  ///< its terms
};

/// Number of realisations of an ensemble, for the verdict `equivalent` for equal means in a dozen statistics.
/// The margin must hold 4.6 standard errors of the worst statistic's mean: 1.75 for the interval (Student's
/// t, 95 %, 15 degrees of freedom) and 2.87 for the difference (normal, 5 % over 12, two-sided). The spread
/// is known to a factor of 1.5, so 6.9 predicted ones are used. spread: of single mirrors in the worst
/// statistic, one standard deviation over the margin. Returns law::kGroups times a number from 2 to
/// law::kMostGroupDraws. Low-frequency roughness may need more; the verdict is then undecided.
int ensemble_draws(double spread);

/// Harvey-Shack and the aberration terms of one roughness side by side, by rays and by wave optics.
struct VerifyReport {
  std::string title;  ///< title of the task, for people
  Convention convention = Convention::kPhysical;
  /// Verdict by the theory of the task: of `metrics` for theory `geometric` and convention `paper`, else of
  /// `light`. Without a wave-optics result, that of rays in a scene where rays are enough, else undecided.
  Verdict verdict = Verdict::kUndecided;
  bool rays_decide = false;                ///< `verdict` is that of rays
  SceneFacts scene;                        ///< its model is "rays", whatever the scene needs
  Eigen::Index rays = 0;                   ///< number of rays in the pupil of the shown realisation
  int draws = 0;                           ///< behind every ensemble mean; 0: a given surface
  double margin = 0;                       ///< of the test, relative
  std::vector<double> theory;              ///< geometric, in closed form, parallel to `metrics` [SI]
  std::vector<EquivalenceMetric> metrics;  ///< target: Harvey-Shack rays; model: aberration terms
  /// Results by wave optics. target: generalised Harvey-Shack (of half the heights in convention `paper`);
  /// model: waves. EE radii are judged as energy fractions, see judge_target; their model value is the radius
  /// that holds the fraction, to first order.
  std::vector<EquivalenceMetric> light;
  Verdict rays_verdict = Verdict::kUndecided, light_verdict = Verdict::kUndecided;
  int light_draws = 0;         ///< number of realisations by waves; fewer than `draws` where the grid is fine
  std::string light_obstacle;  ///< why `light` is empty, a clause; empty: it is not
  std::shared_ptr<const VerifyRays> shown;  ///< for pictures
  Warnings warnings;
};

/// Compares Harvey-Shack with the aberration terms, by rays and by wave optics. The task has a roughness.
///
/// Rays: perturbed rays against the term surface. Wave optics: generalised Harvey-Shack against the
/// diffraction of the term surface. A roughness is an ensemble, and single realisations scatter. The test
/// therefore compares the *mean irradiance* of `draws` surfaces of the task's prior: the statistic of all
/// their rays together, or the mean of their energy fractions. The mean of their radii is not used, because
/// theory does not predict it. The standard error comes from law::kGroups groups of realisations, with
/// Student's t and one degree of freedom less each; the verdict is TOST on the means. A given surface is
/// judged on its own statistics instead. draws: size of the ensemble, rounded up to a multiple of
/// law::kGroups; absent: see ensemble_draws. Throws Interrupted if the context asks to stop.
VerifyReport verify(const Task& task, std::optional<int> draws, const std::optional<GivenSurface>& given,
                    const RunContext& context);

}  // namespace aberfit
