#include "aberfit/method/measured_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/forward/term_moments.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judge.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"
#include "shared_conclusions.h"

namespace aberfit {
using namespace internal;

namespace {

std::string frequency(double f) { return format_quantity(f, Dimension::kSpatialFrequency); }
std::string length(double x) { return format_quantity(x, Dimension::kLength); }

void require_light(const Task& task) {
  if (task.target.theory && *task.target.theory != Theory::kGhs)
    throw FieldError("target.theory",
                     '"' + to_string(*task.target.theory) + "\" for a map beside a roughness",
                     "\"auto\" or \"ghs\", because a measured part is judged by wave optics");
  if (task.target.convention == Convention::kPaper)
    throw FieldError("target.convention", "\"paper\", a rule for rays, for a map beside a roughness",
                     "\"physical\", because a measured part is judged by wave optics");
  if (task.trace.model && *task.trace.model != FocusModel::kWaves)
    throw FieldError("trace.model", '"' + to_string(*task.trace.model) + "\" for a map beside a roughness",
                     "\"auto\" or \"waves\", because a measured part is judged by wave optics");
  const RadialPsd psd(*task.psd);
  const PhysicsChoice use = choose_physics(task, {task.target.theory, {}}, &psd);
  if (!use.obstacle.empty())
    throw FieldError(
        "roughness", "a roughness beside a map that cannot be judged by wave optics: " + use.obstacle,
        "no roughness (the terms are then fitted without a verdict), or one that wave optics can describe");
}

int degree_of(const TermSet& terms) {
  int degree = 0;
  for (const ZernikeMode& mode : terms.zernike) degree = std::max(degree, mode.n);
  for (const int power : terms.spherical) degree = std::max(degree, power);
  return degree;
}

// carried: fraction of the height variance in all Zernikes up to the degree.
double end_of(const RadialPsd& psd, int degree, double radius, double carried) {
  const double first = zernike_cutoff(degree, radius);
  if (!(first < psd.f_max())) return first;
  const double left = (1 - carried) * psd_moments(psd).height_variance;
  double low = std::max(psd.f_min(), 1e-3 * first), high = std::min(psd.f_max(), 10 * first);
  for (int i = 0; i < 50; ++i) {  // to 1e-14
    const double middle = std::sqrt(low * high);
    (psd_moments(psd.band(middle, kInfinity)).height_variance > left ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

// Residual RMS height of the specification after least squares by these terms on the map's points.
double specified_residual(const RadialPsd& psd, const TermSet& terms, double nyquist) {
  if (terms.zernike.empty() || !(psd.f_min() < nyquist)) return std::nan("");
  const RadialPsd seen = psd.band(0, nyquist);
  const int first = terms.zernike.front().n, last = terms.zernike.back().n;
  double carried = captured_fraction(seen, terms.radius, 0, std::min(last, 1));  // piston, tilt: fitted
  if (last >= 2) carried += captured_fraction(seen, terms.radius, std::max(first, 2), last);
  return psd_moments(seen).rms_height() * std::sqrt(std::max(0.0, 1 - carried));
}

std::string terms_words(const TermSet& terms, const PartBand& band) {
  const std::string cycles =
      fmt::format("{} ({:.3g} cycles across)", frequency(band.cut), 2 * terms.radius * band.cut);
  if (band.named) return fmt::format("the terms represent frequencies up to {}, as requested", cycles);
  if (band.cut < band.terms)
    return fmt::format("the terms represent frequencies up to {}, the limit of the map's points", cycles);
  return fmt::format("the terms end at {}, the map at {}", cycles, frequency(band.nyquist));
}

std::string part_reason(const RadialPsd& psd, const TermSet& terms, const PartBand& band,
                        const BandShares& shares) {
  const std::string text = "A measured part: " + terms_words(terms, band) + "; ";
  if (!(shares.rest_rms > 0))
    return text + fmt::format("the specification ends below that, at {}, so nothing is left to scatter.",
                              frequency(psd.f_max()));
  return text + fmt::format(
                    "the specification from {} to {} is scatter (RMS {}, TIS {}); parts with the same terms "
                    "differ by {:.2g} tolerances ({}, one standard deviation).",
                    frequency(std::max(band.cut, psd.f_min())), frequency(psd.f_max()),
                    length(shares.rest_rms), format_percent(shares.tis), shares.spread,
                    shares.spread_of.empty() ? "nothing is judged" : name_without_unit(shares.spread_of));
}

void warn_of_band(const PartBand& band, const BandShares& shares, Warnings* warnings) {
  if (band.named && std::abs(band.cut / band.terms - 1) > law::kGrowth - 1)
    warnings->push_back(
        {"cut-off-the-terms",
         fmt::format("the terms end at {}, but the cut is at {}. The roughness between {}. Leave out "
                     "`terms.band` or the order of the terms",
                     frequency(band.terms), frequency(band.cut),
                     band.cut < band.terms ? "counts twice" : "is in neither terms nor scatter")});
  const double ratio = shares.map_residual / shares.specified_residual;
  if (ratio > law::kNoticedRatio || ratio < 1 / law::kNoticedRatio)
    warnings->push_back(
        {"rest-not-as-specified",
         fmt::format("the terms leave {} RMS of the map and would leave {} of its specification. Beyond the "
                     "terms this part is {}, but the scatter is that of the specification",
                     length(shares.map_residual), length(shares.specified_residual),
                     ratio > 1 ? "rougher" : "smoother (or the map does not resolve it)")});
}

// Radius [m] that holds all but law::kUnseenLight of the energy of the terms, by rays.
double reach_of(const FitCase& of, const FitOutcome& result) {
  const std::optional<PupilSample> pupil = moment_pupil(of.task.aperture, result.fitted.terms);
  if (!pupil) return 0;
  SurfaceField field;
  SurfaceOperator(result.fitted.terms, *pupil, focus_operator(FocusModel::kRays, of.context.threads))
      .apply(result.fitted.fit.coefficients, &field);
  const Eigen::ArrayXd slope = (field.slope_x.square() + field.slope_y.square()).sqrt();
  std::vector<Eigen::Index> steepest(std::size_t(slope.size()));
  std::iota(steepest.begin(), steepest.end(), Eigen::Index(0));
  std::sort(steepest.begin(), steepest.end(),
            [&](Eigen::Index a, Eigen::Index b) { return slope[a] > slope[b]; });
  double beyond = 0;
  for (const Eigen::Index at : steepest)
    if ((beyond += pupil->weight[at]) > law::kUnseenLight) return 2 * of.task.mirror.focal_length * slope[at];
  return 0;
}

void describe_part_surface(const FitCase& of, FitOutcome* result) {
  EquivalentSurface& surface = result->fitted.surface;
  const TermMoments exact = term_moments(of.task.aperture, result->fitted.terms,
                                         result->fitted.fit.coefficients, of.context.threads)
                                .value_or(TermMoments{kNaN, kNaN});
  surface.rms_height = exact.rms_height;
  surface.rms_slope_per_axis = exact.rms_slope_per_axis;
  surface.g = 4 * kPi * surface.rms_height / of.task.wavelength;
  surface.kappa = kNaN;
}

}  // namespace

double terms_end(const RadialPsd& psd, int degree, double radius) {
  return end_of(psd, degree, radius, captured_fraction(psd, radius, 0, degree));
}

int degree_below(const RadialPsd& psd, double cut, double radius, int most) {
  double carried = captured_fraction(psd, radius, 0, 2);
  for (int degree = 3; degree <= most + 1; ++degree) {
    carried += captured_fraction(psd, radius, degree, degree);
    if (end_of(psd, degree, radius, carried) > cut) return degree - 1;
  }
  return most + 1;
}

PartBand part_band(const Task& task, const TermSet& terms, const HeightMap& map) {
  PartBand band;
  band.terms = terms_end(RadialPsd(*task.psd), degree_of(terms), terms.radius);
  band.nyquist = 0.5 / std::max(map.pitch_x, map.pitch_y);
  band.named = task.terms.band.rule == BandRule::kCut;
  band.cut = band.named ? task.terms.band.cut : std::min(band.terms, band.nyquist);
  return band;
}

Layout lay_out_part(const Task& task, const TermSet& terms, const PartBand& band, int threads) {
  require_light(task);
  Layout layout = lay_out_at(task, band.cut, threads);
  if (!layout.ground.shares) {
    const PsdMoments whole = psd_moments(*layout.ground.psd);
    layout.ground.shares.emplace();
    layout.ground.shares->low_rms = whole.rms_height();
    layout.ground.shares->low_slope = whole.rms_slope_per_axis();
  }
  BandShares& shares = *layout.ground.shares;
  shares.cut = band.cut;
  shares.automatic = !band.named;
  shares.specified_residual = specified_residual(*layout.ground.psd, terms, band.nyquist);
  shares.reason = part_reason(*layout.ground.psd, terms, band, shares);
  return layout;
}

double part_pitch(const FitCase& of, const FitOutcome& result) {
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  const double finest = 2 * of.ground.radius / law::kMostCells;
  try {
    return std::max(finest, wave_pitch(of.task, result.fitted.terms, judged.targets(), of.ground.split.get(),
                                       1, reach_of(of, result)));
  } catch (const ComputationError&) {  // no grid is fine enough; the judgement reports it
    return finest;
  }
}

void judge_part(const FitCase& of, const PartBand& band, FitOutcome* result) {
  describe_scene(of, 1, result);
  describe_part_surface(of, result);
  result->band.shares->map_residual = result->map.fit->rms_residual;
  warn_of_band(band, *result->band.shares, &result->warnings);
  tell_spread(of, result);
  warn_of_spread("this part, not for others of the same specification", result);
  ask_perfect_mirror(of, result);
  tell_scatter_of_rest(of, result);
  if (result->fitted.fit.status != FitStatus::kConverged) return;
  of.context.say("judging by wave optics");
  const LightJudgement light = judge_in_light(of, result->fitted.terms, result->fitted.fit.coefficients,
                                              &result->warnings, reach_of(of, *result));
  result->fitted.rays = focus_pupil(of.task, FocusModel::kWaves, {}, part_pitch(of, *result)).size();
  result->judgement.verdict = light.verdict;
  result->judgement.metrics = light.metrics;
  result->scene.spread.tell(&result->judgement.metrics);
  if (light.metrics.empty()) {
    result->judgement.light = light;  // it holds the reason for the missing result
    return;
  }
  result->fitted.values.resize(Eigen::Index(result->fitted.targets.size()));
  for (Eigen::Index k = 0; k < result->fitted.values.size(); ++k)
    result->fitted.values[k] = result->judgement.metrics[std::size_t(k)].model;
}

}  // namespace aberfit
