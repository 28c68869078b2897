#include "aberfit/method/conclude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "aberfit/core/constants.h"
#include "aberfit/core/units.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/forward/term_moments.h"
#include "aberfit/method/band_use.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fresh_verdict.h"
#include "aberfit/method/judge.h"
#include "shared_conclusions.h"

namespace aberfit {
using namespace internal;

namespace {

void warn_of_surface_regime(const Groundwork& ground, const SceneNumbers& surface, Warnings* warnings) {
  const FocusModel specified = regime(ground.numbers), own = regime(surface);
  if (own == specified) return;
  warnings->push_back(
      {"surface-regime",
       fmt::format("the fitted surface (RMS {:.4g} nm, kappa {:.2f}) needs {}, but the specification (RMS "
                   "{:.4g} nm, kappa {:.2f}) needs {}",
                   1e9 * surface.rms_height, surface.kappa, to_string(own), 1e9 * ground.numbers.rms_height,
                   ground.numbers.kappa, to_string(specified))});
}

// A surface can meet the focus without being a realisation of the specification: with height in frequencies
// that no statistic depends on, or in a single lump.
void warn_of_absurd_height(double rms_height, double specified, Warnings* warnings) {
  if (rms_height <= law::kAbsurdRatio * specified) return;
  warnings->push_back(
      {"absurd-surface",
       fmt::format("the fitted surface has an RMS height of {}, {:.3g} times the {} that its terms should "
                   "have. It is no such mirror, even if the focus agrees. Use more targets (such as "
                   "`rms_height`), a prior (`fit.prior`) or other terms",
                   format_quantity(rms_height, Dimension::kLength), rms_height / specified,
                   format_quantity(specified, Dimension::kLength))});
}

void describe_surface(const FitCase& of, Attempt* attempt) {
  const Task& task = of.task;
  const Groundwork& ground = of.ground;
  FitOutcome& result = attempt->result;
  EquivalentSurface& surface = result.fitted.surface;
  surface.prior_height_factor = ground.prior_height_factor;
  surface.captured_fraction = attempt->terms->captured;
  std::optional<TermMoments> exact =
      term_moments(task.aperture, result.fitted.terms, result.fitted.fit.coefficients, of.context.threads);
  Eigen::VectorXd smooth = result.fitted.fit.coefficients;
  smooth.tail(smooth.size() - result.fitted.terms.segments_begin()).setZero();
  const TermMoments moments =
      exact ? *exact : moments_of(attempt->bench->field(smooth), attempt->bench->pupil.weight);
  surface.rms_height = moments.rms_height;
  surface.rms_slope_per_axis = moments.rms_slope_per_axis;
  surface.g = 4 * kPi * surface.rms_height / task.wavelength;
  surface.kappa = std::nan("");  // unknown without a spectrum
  if (ground.term_psd) {
    // The spectrum keeps its shape and takes the height of the fitted surface.
    const double specified = psd_moments(*ground.term_psd).rms_height(),
                 factor = surface.rms_height / specified;
    warn_of_absurd_height(surface.rms_height, specified, &result.warnings);
    const SceneNumbers own =
        scene_numbers(ground.term_psd->scaled(factor), task.mirror, task.aperture, task.wavelength);
    surface.kappa = own.kappa;
    surface.needed = to_string(regime(own));
    warn_of_surface_regime(ground, own, &result.warnings);
  }
}

// Error of geometric rays against wave optics over all planes; choose_model may have stopped at the first.
double ray_error(const Task& task, const Groundwork& ground) {
  return choose_model(*ground.psd, task.mirror, task.aperture, task.wavelength, HUGE_VAL).ray_error;
}

void bear_model_error(double model_error, FitOutcome* result) {
  for (EquivalenceMetric& metric : result->judgement.metrics) metric = with_model_error(metric, model_error);
  result->judgement.verdict = overall(result->judgement.metrics);
}

// The ray model's error uses part of the margin, so less of it is left for the sampling error.
void judge_on_more_rays(const FitCase& of, double model_error, Attempt* attempt) {
  if (!attempt->bench) return;
  FitOutcome* result = &attempt->result;
  std::int64_t rays = attempt->fresh.rays;
  while (rays > 0 && rays < kMostFreshRays && result->judgement.verdict == Verdict::kUndecided &&
         std::any_of(result->judgement.metrics.begin(), result->judgement.metrics.end(),
                     more_samples_could_decide) &&
         !of.context.stopped()) {
    rays = std::min(4 * rays, kMostFreshRays);
    judge_on_fresh_rays(of, attempt, rays);
    bear_model_error(model_error, result);
  }
}

// Wave optics gives the verdict unless the study names another theory. Where it cannot be computed, agreement
// by a simpler model decides nothing.
void ask_light(const FitCase& of, Attempt* attempt) {
  FitOutcome* result = &attempt->result;
  if (of.ground.use.in_light(of.targets.theory == "given")) return;
  of.context.say("judging by wave optics");
  result->judgement.light =
      judge_in_light(of, result->fitted.terms, result->fitted.fit.coefficients, &result->warnings);
  const LightJudgement& light = *result->judgement.light;
  if (!light.decides) return;
  if (light.no_grid && of.ground.use.choice) {
    const double model_error = ray_error(of.task, of.ground);
    bear_model_error(model_error, result);
    judge_on_more_rays(of, model_error, attempt);
    return;
  }
  const bool unknown = light.metrics.empty();
  if (!(unknown && result->judgement.verdict == Verdict::kDifferent))
    result->judgement.verdict = light.verdict;
}

void warn_of_result(const FitCase& of, const FreshStatistics& fresh, FitOutcome* result) {
  Warnings& warnings = result->warnings;
  warn_of_spread("the fitted surface, not for a single real mirror", result);
  if (result->fitted.fit.status == FitStatus::kNotConverged)
    warnings.push_back(
        {"not-converged", "the fit ended before it met every target, which is no verdict on its surface: " +
                              result->fitted.fit.message});
  if (fresh.lost > 0)
    warnings.push_back(
        {"lost-rays", fmt::format("{} of {} fresh rays miss the focal region", fresh.lost, fresh.rays)});
  if (of.ground.use.model != FocusModel::kWaves &&
      result->fitted.rays < law::kRaysPerTerm * result->fitted.terms.size() &&
      result->fitted.targets.size() > 10)
    warnings.push_back(
        {"few-rays", fmt::format("with {} rays for {} terms, the terms can follow single rays; use more rays",
                                 result->fitted.rays, result->fitted.terms.size())});
}

}  // namespace

void conclude(const FitCase& of, Attempt* attempt) {
  FitOutcome& result = attempt->result;
  if (of.ground.psd) result.scene.mean_light = specified_light(of.ground);
  ask_light(of, attempt);
  tell_spread(of, &result);
  const Warnings& of_points = attempt->fresh.rays > 0 ? attempt->fresh_warnings : attempt->own_warnings;
  result.warnings.insert(result.warnings.end(), of_points.begin(), of_points.end());
  // An interrupted run describes the surface and leaves out further comparisons.
  if (!of.context.stopped()) ask_perfect_mirror(of, &result);
  tell_scatter_of_rest(of, &result);
  if (attempt->result.fitted.terms.size() == 0) return warn_of_result(of, attempt->fresh, &result);
  describe_surface(of, attempt);
  if (of.ground.psd && !(result.fitted.terms.zernike.empty() && result.fitted.terms.fourier.empty()) &&
      result.fitted.surface.rms_slope_per_axis > 0 && !of.context.stopped()) {
    of.context.say("comparing PSD and shape with realisations");
    result.judgement.character =
        character_of(of.task, of.ground, result.fitted.terms, result.fitted.fit.coefficients, of.context);
  }
  if (of.ground.psd) result.band.use = band_use(of.task, of.ground, result.fitted.terms, result.fitted.rays);
  warn_of_result(of, attempt->fresh, &result);
}

}  // namespace aberfit
