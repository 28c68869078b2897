#include "aberfit/specify/psd_of_focus.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <numeric>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/fit/parameter_fit.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/method/tost.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/theory/realisation_spread.h"
#include "exact_variable.h"
#include "focal_bins.h"
#include "focus_problem.h"
#include "unknown_noise.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kFurthest = 1000, kFurthestNumber = 10;  // factors on either side of the start
constexpr double kPoorFocus = 1e-3;                       // least goodness, as kPoorFit of a PSD fit
// Least unknown noise as a fraction. For one mirror it is the accuracy of a good camera and of the theory of
// the spread; for a mean it is that of curves with four digits.
constexpr double kLeastOfOneMirror = 1e-3, kLeastOfMean = 1e-4;
// Probability of the residuals below which they count as structured. It refuses one correct curve in fifty,
// and no curve is accepted whose error shifts it by three standard deviations.
constexpr double kPoorForm = 0.02;
constexpr double kUnseen =
    // Least fraction of a systematic error's square that the unknowns leave; below, no fit can separate them.
    1e-6;

// Covariance of one mirror's energy about the mean [total 1].
Eigen::MatrixXd spread_of_one_mirror(const Task& task, const GhsPupil& pupil, const FocalBins& bins,
                                     double dz) {
  const RadialPsd psd(*task.psd);
  const GeneralisedHarveyShack mean(psd, pupil);
  std::vector<FocalDisc> discs;
  for (const double radius : bins.edges) discs.push_back({radius, dz});
  Eigen::MatrixXd edges =
      RealisationSpread::covariance({psd, pupil.mirror(), pupil.aperture(), pupil.wavelength(), mean}, discs);
  if (!bins.are_rings) return edges;
  // Converts circles to rings by differences; each pixel has its part of a ring.
  for (Eigen::Index k = edges.rows() - 1; k > 0; --k) edges.row(k) -= edges.row(k - 1).eval();
  for (Eigen::Index k = edges.cols() - 1; k > 0; --k) edges.col(k) -= edges.col(k - 1).eval();
  Eigen::ArrayXd pixels = Eigen::ArrayXd::Zero(edges.rows());
  for (Eigen::Index k = 0; k < bins.pixels.size(); ++k)
    pixels[bins.ring_of[std::size_t(k)]] += bins.pixels[k];
  Eigen::MatrixXd covariance(bins.pixels.size(), bins.pixels.size());
  for (Eigen::Index k = 0; k < covariance.rows(); ++k)
    for (Eigen::Index l = 0; l < covariance.cols(); ++l) {
      const int a = bins.ring_of[std::size_t(k)], b = bins.ring_of[std::size_t(l)];
      covariance(k, l) = edges(a, b) * bins.pixels[k] * bins.pixels[l] / (pixels[a] * pixels[b]);
    }
  return covariance;
}

// Geometry of the data: curves in metres, images about a centre that the fit improves.
class FocalGeometry {
 public:
  FocalGeometry(const MeasuredFocus& focus, const Task& task) : focus_(focus) {
    // An angle on the sky refers to the nominal focus, whatever the plane.
    const double f = task.mirror.focal_length;
    resolution_ = task.wavelength * (f + focus.dz) / (2 * aperture_radius(task.aperture));
    if (const auto* image = std::get_if<FocalImage>(&focus.data)) {
      pixel_ = focus.pixel > 0 ? focus.pixel : image->pixel * (image->is_angle ? f : 1);
      if (!(pixel_ > 0))
        throw FieldError("solve.focus.pixel", "nothing, and the file does not say it",
                         "the side of a pixel, \"5 um\" or \"0.1 arcsec\"");
      centre_ = centre_of(*image);
      return;
    }
    curve_ = std::get<EncircledCurve>(focus.data);
    if (curve_.is_angle) curve_.radius *= f;
    if (!(focus.reach > 0)) return;
    const Eigen::Index kept = (curve_.radius <= focus.reach).count();
    curve_.radius.conservativeResize(kept);
    curve_.share.conservativeResize(kept);
    if (curve_.noise.size() > 0) curve_.noise.conservativeResize(kept);
  }

  const PixelPlace& centre() const { return centre_; }
  void move_centre(double x, double y) { centre_.x += x, centre_.y += y; }
  FocalBins bins() const { return bins(0, 0); }
  /// Returns the bins of the same pixels for a spot whose centre is shifted by (x, y) pixels.
  FocalBins bins(double x, double y) const {
    const auto* image = std::get_if<FocalImage>(&focus_.data);
    if (!image) return circles_of(curve_, focus_.pixel, resolution_);
    return rings_of(*image, pixel_, resolution_, focus_.reach > 0 ? focus_.reach : kInfinity, centre_,
                    {centre_.x + x, centre_.y + y});
  }

 private:
  const MeasuredFocus& focus_;
  EncircledCurve curve_;
  double pixel_ = 0, resolution_ = 0;
  PixelPlace centre_;
};

// Returns the standard deviations of the data without the spread of one mirror. If they are not given,
// `known` becomes false, and they are those of a noise of level 1 [fraction, or of the brightest pixel].
Eigen::ArrayXd noise_of(const MeasuredFocus& focus, const FocalBins& bins, const Eigen::ArrayXd& light,
                        bool* known) {
  *known = true;
  if (const auto* image = std::get_if<FocalImage>(&focus.data)) {
    double pixel = focus.noise.value_or(noise_of_rim(*image));
    // If the rim has no noise, a fraction of the brightest pixel is used, whatever the unit of the image.
    if (!(pixel > 0) && !focus.gain) {
      *known = false;
      pixel = (bins.measured / bins.pixels).abs().maxCoeff();
    }
    Eigen::ArrayXd variance = pixel * pixel * bins.pixels;
    if (focus.gain) variance += light.max(0) / *focus.gain;
    return variance.max(1e-30 * std::max(variance.maxCoeff(), 1e-300)).sqrt();
  }
  const auto& curve = std::get<EncircledCurve>(focus.data);
  if (focus.noise) return Eigen::ArrayXd::Constant(bins.radius.size(), *focus.noise);
  if (curve.noise.size() > 0) return curve.noise.head(bins.radius.size());
  *known = false;
  return Eigen::ArrayXd::Ones(bins.radius.size());
}

// Returns the best point of a coarse grid about the values of the study; nothing if none has a prediction.
std::optional<Eigen::VectorXd> start_of(const FocusProblem& problem,
                                        const std::vector<SolveUnknown>& unknowns, int* evaluations) {
  std::vector<std::vector<double>> places = {std::vector<double>(unknowns.size(), 0.0)};
  int scaled = 0;
  for (std::size_t u = 0; u < unknowns.size() && scaled < 2; ++u) {
    if (unknowns[u].dimension == Dimension::kNumber) continue;
    ++scaled;
    const double factor = unknowns[u].pointer.ends_with("/rms") ? std::log(3.0) : std::log(10.0);
    const std::vector<std::vector<double>> so_far = places;
    for (const std::vector<double>& place : so_far)
      for (const double way : {-factor, factor}) {
        places.push_back(place);
        places.back()[u] += way;
      }
  }
  std::optional<Eigen::VectorXd> best;
  double least = kInfinity;
  for (const std::vector<double>& place : places) {
    ++*evaluations;
    const std::optional<FocusProblemStart> start = problem.start(place);
    if (!start || !(start->sum_of_squares < least)) continue;
    best = start->x;
    least = start->sum_of_squares;
  }
  return best;
}

ParameterFitProblem fit_problem(const FocusProblem& problem, const std::vector<SolveUnknown>& unknowns) {
  ParameterFitProblem fit;
  fit.residuals = [&problem](const Eigen::VectorXd& x, Eigen::VectorXd* residuals,
                             Eigen::MatrixXd* jacobian) { return problem.residuals(x, residuals, jacobian); };
  fit.lower.setConstant(Eigen::Index(problem.parameters()), -kInfinity);
  fit.upper.setConstant(Eigen::Index(problem.parameters()), kInfinity);
  for (std::size_t u = 0; u < unknowns.size(); ++u) {
    const double reach = std::log(unknowns[u].dimension == Dimension::kNumber ? kFurthestNumber : kFurthest);
    fit.lower[Eigen::Index(u)] = -reach;
    fit.upper[Eigen::Index(u)] = reach;
  }
  return fit;
}

void require(const Task& own, const std::vector<SolveUnknown>& unknowns, const FocalBins& bins,
             std::size_t parameters) {
  const RadialPsd psd(*own.psd);
  const PhysicsChoice use = choose_physics(own, requested_physics(own), &psd);
  if (use.theory != Theory::kGhs)
    throw FieldError("target.theory", to_string(use.theory),
                     "\"auto\" or \"ghs\", because a measured focus follows wave optics");
  for (const SolveUnknown& unknown : unknowns)
    if (!(unknown.start > 0))
      throw FieldError("solve.for",
                       fmt::format("{}, which is {} in the study", unknown.pointer, unknown.start),
                       "a number above zero as start, because the search goes in factors");
  if (std::size_t(bins.radius.size()) <= parameters)
    throw FieldError("solve.focus.file",
                     fmt::format("{} {} for {} unknowns", bins.radius.size(),
                                 bins.are_rings ? "rings of pixels" : "circles", parameters),
                     "more data than unknowns");
}

bool is_poor(const PsdOfFocus& result) {
  return result.goodness < (result.is_noise_known ? kPoorFocus : kPoorForm);
}

// Widens the standard deviations of a mean for the worst systematic error that residuals of an unknown noise
// may hide. The deviations of one mirror are larger and known.
Eigen::ArrayXd widening(const FocusProblem& problem, const ParameterFit& fit,
                        const Eigen::MatrixXd& covariance, const std::vector<Departure>& departures) {
  Eigen::ArrayXd most = Eigen::ArrayXd::Zero(covariance.rows());
  for (std::size_t k = 0; k + 1 < departures.size(); ++k) {  // the last one stands for no specific error
    const Eigen::VectorXd column = problem.whitened_columns(departures[k].of_light);
    const Eigen::VectorXd shift = fit.jacobian.colPivHouseholderQr().solve(column);
    const double left = (column - fit.jacobian * shift).squaredNorm();
    if (left > kUnseen * column.squaredNorm()) most = most.max(shift.array().square() / left);
  }
  return (1 + most / covariance.diagonal().array()).sqrt();
}

// Stores the goodness of the fit and the parameters with their intervals.
void describe_fit(const std::vector<SolveUnknown>& unknowns, const FocusProblem& problem,
                  const ParameterFit& fit, const std::vector<Departure>& departures, PsdOfFocus* result) {
  result->chi_squared = fit.sum_of_squares;
  const double freedom = result->degrees_of_freedom;
  const double deviations =
      student_quantile(0.5 * (1 + result->confidence), result->is_noise_known ? kInfinity : freedom);
  result->noise_factor = std::sqrt(fit.sum_of_squares / freedom);
  result->total = problem.total(fit.x);
  result->background = problem.background(fit.x);
  const Eigen::MatrixXd covariance = parameter_covariance(fit.jacobian);
  const Eigen::ArrayXd wider = result->is_noise_known || result->is_one_mirror
                                   ? Eigen::ArrayXd::Ones(covariance.rows())
                                   : widening(problem, fit, covariance, departures);
  const ParameterFitProblem to_solve = fit_problem(problem, unknowns);
  const auto count = Eigen::Index(unknowns.size());
  result->correlation.resize(count, count);
  for (Eigen::Index u = 0; u < count; ++u) {
    for (Eigen::Index v = 0; v < count; ++v)
      result->correlation(u, v) = covariance(u, v) / std::sqrt(covariance(u, u) * covariance(v, v));
    const SolveUnknown& unknown = unknowns[std::size_t(u)];
    // If the model does not describe the data, a profile is meaningless.
    const double std = wider[u] * std::sqrt(covariance(u, u)), half = deviations * std;
    const ProfileInterval interval =
        is_poor(*result) ? ProfileInterval{fit.x[u] - half, fit.x[u] + half, true, true}
                         : profile_interval(to_solve, fit, int(u), std::pow(deviations * wider[u], 2),
                                            &result->evaluations);
    result->numbers.push_back(
        {unknown, unknown.start * std::exp(fit.x[u]), std, unknown.start * std::exp(interval.lower),
         unknown.start * std::exp(interval.upper), interval.lower_found, interval.upper_found});
  }
}

void describe_light(const FocusModelLight& model, const FocalBins& bins, const Eigen::ArrayXd& noise,
                    const Eigen::MatrixXd& spread, const std::vector<double>& logs, PsdOfFocus* result) {
  Eigen::VectorXd light;
  model.at(logs, &light, nullptr);
  const Eigen::ArrayXd per = bins.are_rings ? bins.pixels : Eigen::ArrayXd::Ones(bins.measured.size()).eval();
  std::vector<Eigen::Index> order(std::size_t(bins.radius.size()));
  std::iota(order.begin(), order.end(), Eigen::Index(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return bins.radius[a] < bins.radius[b]; });
  const auto sorted = [&](const Eigen::ArrayXd& values) { return Eigen::ArrayXd(values(order)); };
  result->radius = sorted(bins.radius);
  result->measured = sorted(bins.measured / per);
  result->fitted = sorted((result->total * light.array() + result->background * bins.pixels) / per);
  result->noise = sorted(noise / per);
  result->spread = sorted(spread.diagonal().array().max(0).sqrt() / per);
}

// Sets the status and, for a poor result, the message with the remedy.
void conclude(const std::string& remedy, bool converged, PsdOfFocus* result) {
  std::string open;
  for (const NumberOfFocus& number : result->numbers)
    if (!number.identified()) open += (open.empty() ? "" : ", ") + number.unknown.pointer;
  using enum PsdOfFocusStatus;
  if (!open.empty()) {
    result->message = fmt::format(
        "the measurement does not determine {}: with the other unknowns free the fit is equally good over "
        "decades. Take fewer unknowns, or measure further out (fine roughness) or further in (long "
        "roughness)",
        open);
    result->warnings.push_back({"not-identified", result->message});
  }
  if (is_poor(*result)) {
    std::string poor = fmt::format(
        "no such roughness fits the measurement: it differs by {:.2g} times its noise (p-value {:.1e}). "
        "Possible causes: {}, {}",
        std::sqrt(result->chi_squared / std::max(result->degrees_of_freedom, 1)), result->goodness, remedy,
        result->is_image
            ? "saturated or hot pixels, or `noise` is too small (shot noise is included only with `gain`)"
            : "or `noise` is too small");
    if (!result->is_noise_known)
      poor = fmt::format(
          "the residuals, up to {:.2g} {}, have a shape that noise does not have (p-value {:.1e}). Possible "
          "cause: {}",
          (result->measured - result->fitted).abs().maxCoeff(),
          result->is_image ? "of a pixel" : "of the energy", result->goodness, remedy);
    if (result->message.empty()) result->message = poor;
    result->warnings.push_back({"poor-fit", poor});
  }
  result->status = !converged         ? kNotConverged
                   : !open.empty()    ? kNotIdentified
                   : is_poor(*result) ? kNotDescribed
                                      : kFitted;
  if (!converged)
    result->message = "the iterations found no minimum, or no centre of the image to a twentieth of a pixel";
}

}  // namespace

std::string to_string(PsdOfFocusStatus status) {
  switch (status) {
    case PsdOfFocusStatus::kFitted:
      return "fitted";
    case PsdOfFocusStatus::kNotIdentified:
      return "not-identified";
    case PsdOfFocusStatus::kNotDescribed:
      return "poor-fit";
    case PsdOfFocusStatus::kNotConverged:
      return "not-converged";
  }
  return "";
}

namespace {

constexpr int kMostPasses = 8, kPassesOfNoise = 2;
constexpr double kCentreFound = 0.001, kCentreNear = 0.05;  // pixels
constexpr double kUncentred = 0.03;         // fraction of a datum's energy that a wrong centre adds
constexpr double kCentreDifference = 0.05;  // pixels
constexpr double kCentreStep = 0.5;         // pixels, at most

// One fit with a given covariance and centre; each pass improves both.
struct FocusPass {
  FocalBins bins;
  FocusModelLight model;
  FocusProblem problem;
  Eigen::ArrayXd noise;
  Eigen::MatrixXd spread;

  FocusPass(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns, const MeasuredFocus& focus,
            FocalBins of, const GhsPupil& pupil, int threads)
      : bins(std::move(of)),
        model(task_at, unknowns, bins, focus.dz, pupil, threads),
        problem(model, bins, focus, unknowns.size()) {}
  FocusPass(const FocusPass&) = delete;
  FocusPass& operator=(const FocusPass&) = delete;
};

// Gauss-Newton step of the centre of the spot [pixels]; by symmetry it is independent of the other unknowns.
Eigen::Vector2d centre_step(const FocusPass& pass, const FocalGeometry& geometry, const TaskAt& task_at,
                            const std::vector<SolveUnknown>& unknowns, const MeasuredFocus& focus,
                            const GhsPupil& pupil, const Eigen::VectorXd& x, int threads) {
  const std::vector<double> logs = logs_of(x, unknowns.size());
  Eigen::MatrixXd slopes(pass.bins.measured.size(), 2);
  for (int axis : {0, 1}) {
    std::array<Eigen::VectorXd, 2> light;
    for (int way : {0, 1}) {
      const double step = way == 0 ? -kCentreDifference : kCentreDifference;
      const FocalBins moved = axis == 0 ? geometry.bins(step, 0) : geometry.bins(0, step);
      if (!FocusModelLight(task_at, unknowns, moved, focus.dz, pupil, threads)
               .at(logs, &light[std::size_t(way)], nullptr))
        return Eigen::Vector2d::Zero();
    }
    slopes.col(axis) = pass.problem.total(x) * (light[1] - light[0]) / (2 * kCentreDifference);
  }
  Eigen::VectorXd residuals;
  if (!pass.problem.residuals(x, &residuals, nullptr)) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d step = pass.problem.whitened_columns(slopes).colPivHouseholderQr().solve(-residuals);
  return step.norm() > kCentreStep ? Eigen::Vector2d(step * (kCentreStep / step.norm())) : step;
}

UnknownNoiseResiduals residuals_of(const FocusPass& pass, const MeasuredFocus& focus, const ParameterFit& fit,
                                   const Eigen::ArrayXd& shape) {
  return {pass.problem.plain(fit.residuals), pass.problem.plain(fit.jacobian), pass.spread, shape,
          focus.is_one_mirror ? kLeastOfOneMirror : kLeastOfMean};
}

// Returns possible errors of a measurement, each with its effect on the fitted energy.
std::vector<Departure> departures_of(const FocusPass& pass, const MeasuredFocus& focus, const Task& task,
                                     const GhsPupil& pupil, const Eigen::ArrayXd& shape) {
  const GeneralisedHarveyShack mean(RadialPsd(*task.psd), pupil);
  const Eigen::ArrayXd& r = pass.bins.nodes;
  const auto light = [&](const std::function<double(double)>& energy) {
    return Eigen::VectorXd(pass.bins.weights * r.unaryExpr(energy).matrix());
  };
  const MeanSpot spot = mean.at_plane(focus.dz);
  std::vector<Departure> result;
  if (!pass.bins.are_rings && focus.is_total_known)
    result.push_back(
        {"the fractions are not of the total energy, as in an image that was cropped and normalised (set "
         "`\"total\": \"free\"`)",
         light([&](double radius) { return spot.encircled_energy(radius); })});
  const double f = task.mirror.focal_length, cone = f / (2 * aperture_radius(task.aperture));
  const double depth = 2 * task.wavelength * cone * cone;  // a quarter of a wave at the rim
  for (const double step : {depth, -depth}) {
    if (step < 0 && focus.dz == 0 && is_parabola(task.mirror)) continue;  // by symmetry the same irradiance
    const MeanSpot moved = mean.at_plane(focus.dz + step);
    result.push_back(
        {"it was measured in another plane than the study's (set `plane`, or a Zernike defocus of the "
         "mirror)",
         light(
             [&](double radius) { return moved.encircled_energy(radius) - spot.encircled_energy(radius); })});
  }
  // A circle shifted sideways, to second order. For images the fit moves the centre.
  if (!pass.bins.are_rings)
    result.push_back(
        {"the circles are not centred on the image (take the centroid, or give the image; then the centre is "
         "found)",
         light([&](double radius) { return radius * spot.irradiance_slope(radius); })});
  result.push_back(
      {"the radii have another scale: other pixels or focal length, or diameters (check `pixel` and the unit "
       "of the radii)",
       light([&](double radius) { return radius * spot.encircled_energy_slope(radius); })});
  result.push_back({"another model of the PSD, or an aberration that is not in the study",
                    shape.matrix().asDiagonal() * smooth_columns(shape.size())});
  return result;
}

// Judges the last pass and returns a remedy for a poor one. task: as fitted; shape: of the noise.
std::string judge(const std::vector<SolveUnknown>& unknowns, const FocusPass& pass,
                  const MeasuredFocus& focus, const Task& task, const GhsPupil& pupil,
                  const ParameterFit& fit, const Eigen::ArrayXd& shape, PsdOfFocus* result) {
  result->degrees_of_freedom = int(pass.bins.measured.size()) - int(pass.problem.parameters());
  if (result->is_noise_known)
    result->goodness = boost::math::gamma_q(0.5 * result->degrees_of_freedom, 0.5 * fit.sum_of_squares);
  std::vector<Departure> departures;
  if (!result->is_noise_known || is_poor(*result))
    departures = departures_of(pass, focus, task, pupil, shape);
  const ResidualVerdict verdict = verdict_of(
      residuals_of(pass, focus, fit, result->is_noise_known ? pass.noise : shape), departures, kPoorForm);
  if (!result->is_noise_known) result->goodness = verdict.chance;
  const std::string remedy =
      verdict.datum
          ? fmt::format("only the value at {} lies off the curve of the others (check it or leave it out)",
                        format_quantity(pass.bins.radius[*verdict.datum], Dimension::kLength))
          : verdict.remedy;
  describe_fit(unknowns, pass.problem, fit, departures, result);
  describe_light(pass.model, pass.bins, pass.noise, pass.spread, logs_of(fit.x, unknowns.size()), result);
  return remedy;
}

}  // namespace

PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                            const MeasuredFocus& focus, const RunContext& context) {
  return fit_psd_to_focus(task_at, task_at, unknowns, focus, context);
}

PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const TaskAt& mirrors_at,
                            const std::vector<SolveUnknown>& unknowns, const MeasuredFocus& focus,
                            const RunContext& context) {
  const auto begun = std::chrono::steady_clock::now();
  PsdOfFocus result;
  const Task own = task_at(values_at(unknowns, std::vector<double>(unknowns.size(), 0.0)));
  const GhsPupil pupil(own.mirror, own.aperture, own.wavelength);
  FocalGeometry geometry(focus, own);
  std::optional<FocusPass> pass;
  ParameterFit fit;
  Eigen::ArrayXd shape;  // of the noise
  double level = focus.is_one_mirror ? kLeastOfOneMirror : 1;
  bool centred = std::holds_alternative<EncircledCurve>(focus.data);
  const bool noise_of_fit = focus.is_one_mirror || focus.gain;
  for (int number = 0; number < kMostPasses; ++number) {
    context.say(number == 0 ? "searching for a start" : fmt::format("pass {}", number + 1));
    pass.emplace(task_at, unknowns, focus, geometry.bins(), pupil, context.threads);
    const Eigen::Index count = pass->bins.measured.size();
    if (number == 0) require(own, unknowns, pass->bins, pass->problem.parameters());
    Eigen::ArrayXd light = pass->bins.measured;
    pass->spread = Eigen::MatrixXd::Zero(count, count);
    if (number > 0 && noise_of_fit) {
      Eigen::VectorXd mean;
      const std::vector<double> logs = logs_of(fit.x, unknowns.size());
      const double total = pass->problem.total(fit.x);
      pass->model.at(logs, &mean, nullptr);
      light = total * mean.array() + pass->problem.background(fit.x) * pass->bins.pixels;
      if (focus.is_one_mirror)
        pass->spread =
            total * total *
            spread_of_one_mirror(mirrors_at(values_at(unknowns, logs)), pupil, pass->bins, focus.dz);
    }
    shape = noise_of(focus, pass->bins, light, &result.is_noise_known);
    pass->noise = result.is_noise_known ? shape : (level * shape).eval();
    if (!centred) pass->noise = (pass->noise.square() + (kUncentred * light).square()).sqrt();
    Eigen::MatrixXd covariance = pass->spread;
    covariance.diagonal() += pass->noise.square().matrix();
    pass->problem.set_covariance(covariance);
    const std::optional<Eigen::VectorXd> start =
        number == 0 ? start_of(pass->problem, unknowns, &result.evaluations) : std::optional(fit.x);
    if (!start) throw ComputationError("no values of the unknowns near those of the study give a prediction");
    fit = fit_parameters(fit_problem(pass->problem, unknowns), *start);
    result.evaluations += fit.evaluations;
    if (fit.status == ParameterFitStatus::kFailed)
      throw ComputationError("the prediction has no derivative there: " + fit.message);
    const Eigen::Vector2d step = pass->bins.are_rings ? centre_step(*pass, geometry, task_at, unknowns, focus,
                                                                    pupil, fit.x, context.threads)
                                                      : Eigen::Vector2d(0, 0);
    const bool near = step.norm() < kCentreFound;
    if (!result.is_noise_known) level = residuals_of(*pass, focus, fit, shape).level();
    if (near && centred && number >= (noise_of_fit ? kPassesOfNoise : result.is_noise_known ? 0 : 1)) break;
    if (!near && number + 1 < kMostPasses) geometry.move_centre(step[0], step[1]);
    centred = centred || step.norm() < kCentreNear;
  }
  result.confidence = focus.confidence;
  result.is_image = pass->bins.are_rings;
  result.is_one_mirror = focus.is_one_mirror;
  result.dz = focus.dz;
  result.centre_x = geometry.centre().x, result.centre_y = geometry.centre().y;
  context.say("intervals");
  const std::string remedy =
      judge(unknowns, *pass, focus, task_at(values_at(unknowns, logs_of(fit.x, unknowns.size()))), pupil, fit,
            shape, &result);
  conclude(remedy, centred && fit.status == ParameterFitStatus::kConverged, &result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

}  // namespace aberfit
