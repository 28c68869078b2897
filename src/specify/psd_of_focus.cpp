#include "aberfit/specify/psd_of_focus.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <chrono>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/fit/parameter_fit.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/method/tost.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/theory/realisation_spread.h"
#include "exact_variable.h"
#include "focal_bins.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kFurthest = 1000, kFurthestNumber = 10;  // factors either way of the start
constexpr double kNoiseOfOneMirror = 1e-3;  // of a share, where nothing is said: what a good camera reaches
constexpr double kPoorFocus = 1e-3;         // goodness, as kNotDescribed of a PSD

// Light in circles or rings as a function of the unknowns' logarithms, of 1 in all.
class MeanLight {
 public:
  MeanLight(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns, const FocalBins& bins,
            double dz, const GhsPupil& pupil, int threads)
      : task_at_(task_at), unknowns_(unknowns), bins_(bins), pupil_(pupil), threads_(threads) {
    for (std::size_t u = 0; u < unknowns.size(); ++u)
      variables_.push_back(exact_variable(task_at, unknowns, u));
    for (const double radius : bins.nodes) statistics_.push_back(RingThrough{radius, dz});
  }

  Task task(const std::vector<double>& logs) const { return task_at_(values_at(unknowns_, logs)); }

  /// False where the values are not allowed or have no prediction.
  bool at(const std::vector<double>& logs, Eigen::VectorXd* light, Eigen::MatrixXd* slopes) const {
    try {
      if (slopes)
        with_slopes(logs, light, slopes);
      else
        *light = bins_.weights * energies(logs);
      return light->allFinite() && (!slopes || slopes->allFinite());
    } catch (const InputError&) {
    } catch (const ComputationError&) {
    }
    return false;
  }

 private:
  Eigen::VectorXd energies(const std::vector<double>& logs) const {
    return GeneralisedHarveyShack(RadialPsd(*task(logs).psd), pupil_).predict(statistics_, threads_);
  }
  void with_slopes(const std::vector<double>& logs, Eigen::VectorXd* light, Eigen::MatrixXd* slopes) const {
    std::vector<PsdVariable> exact;
    for (const std::optional<PsdVariable>& variable : variables_)
      if (variable) exact.push_back(*variable);
    const PsdJacobian found = psd_jacobian(*task(logs).psd, exact, statistics_, pupil_, threads_);
    *light = bins_.weights * found.values;
    slopes->resize(light->size(), Eigen::Index(logs.size()));
    Eigen::Index known = 0;
    for (std::size_t u = 0; u < logs.size(); ++u) {
      const auto column = Eigen::Index(u);
      if (variables_[u]) {
        slopes->col(column) = bins_.weights * found.derivatives.col(known) * found.parameter_values[known];
        ++known;
        continue;
      }
      std::vector<double> above = logs, below = logs;
      above[u] += kDifference, below[u] -= kDifference;
      slopes->col(column) = bins_.weights * (energies(above) - energies(below)) / (2 * kDifference);
    }
  }

  const TaskAt& task_at_;
  const std::vector<SolveUnknown>& unknowns_;
  const FocalBins& bins_;
  const GhsPupil& pupil_;
  int threads_;
  std::vector<std::optional<PsdVariable>> variables_;
  std::vector<Statistic> statistics_;
};

std::vector<double> logs_of(const Eigen::VectorXd& x, std::size_t count) {
  return {x.data(), x.data() + count};
}

struct ProblemStart {
  Eigen::VectorXd x;
  double sum_of_squares = 0;
};

// The whole problem: logarithms of the unknowns, then the factor of all light and the background, where they
// are unknown. Whitened by the covariance of the data.
class Problem {
 public:
  Problem(const MeanLight& model, const FocalBins& bins, const MeasuredFocus& focus, std::size_t unknowns)
      : model_(model), bins_(bins), unknowns_(unknowns) {
    has_total_ = bins.are_rings || !focus.is_total_known;
    has_background_ = bins.are_rings && focus.has_background;
  }

  void set_covariance(const Eigen::MatrixXd& covariance) { whitening_ = covariance.llt(); }

  std::size_t parameters() const {
    return unknowns_ + std::size_t(has_total_) + std::size_t(has_background_);
  }
  double total(const Eigen::VectorXd& x) const { return has_total_ ? x[Eigen::Index(unknowns_)] : 1; }
  double background(const Eigen::VectorXd& x) const { return has_background_ ? x[x.size() - 1] : 0; }

  bool residuals(const Eigen::VectorXd& x, Eigen::VectorXd* residuals, Eigen::MatrixXd* jacobian) const {
    Eigen::VectorXd light;
    Eigen::MatrixXd slopes;
    if (!model_.at(logs_of(x, unknowns_), &light, jacobian ? &slopes : nullptr)) return false;
    *residuals = whitened(x, light);
    if (!jacobian) return true;
    Eigen::MatrixXd plain(light.size(), Eigen::Index(parameters()));
    plain.leftCols(slopes.cols()) = total(x) * slopes;
    if (has_total_) plain.col(Eigen::Index(unknowns_)) = light;
    if (has_background_) plain.col(plain.cols() - 1) = bins_.pixels.matrix();
    *jacobian = whitening_.matrixL().solve(plain);
    return true;
  }

  /// x at these unknowns with the best of the others; nothing where there is no prediction.
  std::optional<ProblemStart> start(const std::vector<double>& logs) const {
    Eigen::VectorXd light;
    if (!model_.at(logs, &light, nullptr)) return std::nullopt;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(Eigen::Index(parameters()));
    for (std::size_t u = 0; u < unknowns_; ++u) x[Eigen::Index(u)] = logs[u];
    if (has_total_) {
      Eigen::MatrixXd design(light.size(), has_background_ ? 2 : 1);
      design.col(0) = light;
      if (has_background_) design.col(1) = bins_.pixels.matrix();
      const Eigen::MatrixXd white = whitening_.matrixL().solve(design);
      const Eigen::VectorXd wanted = whitening_.matrixL().solve(bins_.measured.matrix());
      x.tail(design.cols()) = white.colPivHouseholderQr().solve(wanted);
    }
    return ProblemStart{x, whitened(x, light).squaredNorm()};
  }

 private:
  Eigen::VectorXd whitened(const Eigen::VectorXd& x, const Eigen::VectorXd& light) const {
    return whitening_.matrixL().solve(
        (total(x) * light.array() + background(x) * bins_.pixels - bins_.measured).matrix());
  }

  const MeanLight& model_;
  const FocalBins& bins_;
  std::size_t unknowns_;
  bool has_total_ = false, has_background_ = false;
  Eigen::LLT<Eigen::MatrixXd> whitening_;
};

// Covariance of one mirror's light in circles of these radii about the mean, of 1 in all.
Eigen::MatrixXd spread_of_one_mirror(const Task& task, const GhsPupil& pupil, const FocalBins& bins,
                                     double dz, int threads) {
  const RadialPsd psd(*task.psd);
  const GeneralisedHarveyShack mean(psd, pupil);
  std::vector<FocalDisc> discs;
  for (const double radius : bins.radius) discs.push_back({radius, dz});
  const RealisationSpread spread({psd, pupil.mirror(), pupil.aperture(), pupil.wavelength(), mean}, discs,
                                 threads);
  const Eigen::ArrayXd sigma = spread.light(spread.lowest());
  Eigen::MatrixXd circles(sigma.size(), sigma.size());
  for (Eigen::Index k = 0; k < sigma.size(); ++k)
    for (Eigen::Index l = 0; l < sigma.size(); ++l)
      circles(k, l) = sigma[k] * sigma[l] *
                      std::exp(-std::abs(std::log(bins.radius[k] / bins.radius[l])) / kSpreadLength);
  if (!bins.are_rings) return circles;
  Eigen::MatrixXd rings = circles;  // what a circle has more than the one before
  for (Eigen::Index k = rings.rows() - 1; k > 0; --k) rings.row(k) -= rings.row(k - 1);
  for (Eigen::Index k = rings.cols() - 1; k > 0; --k) rings.col(k) -= rings.col(k - 1);
  return rings;
}

FocalBins bins_of(const MeasuredFocus& focus, const Task& task) {
  const double resolution =
      task.wavelength * (task.mirror.focal_length + focus.dz) / (2 * aperture_radius(task.aperture));
  // On the sky the plane's own distance scales an angle as f does: plate scale of the nominal focus.
  const double f = task.mirror.focal_length;
  if (const auto* image = std::get_if<FocalImage>(&focus.data)) {
    const double own = image->pixel * (image->is_angle ? f : 1);
    const double pixel = focus.pixel > 0 ? focus.pixel : own;
    if (!(pixel > 0))
      throw FieldError("solve.focus.pixel", "nothing, and the file does not say it",
                       "the side of a pixel, \"5 um\" or \"0.1 arcsec\"");
    if (!image->light.isFinite().any())
      throw FieldError("solve.focus.file", "an image without a valid pixel", "an image of the focus");
    return rings_of(*image, pixel, resolution, focus.reach > 0 ? focus.reach : kInfinity);
  }
  EncircledCurve curve = std::get<EncircledCurve>(focus.data);
  if (curve.is_angle) curve.radius *= f;
  if (focus.reach > 0) {
    const Eigen::Index kept = (curve.radius <= focus.reach).count();
    curve.radius.conservativeResize(kept);
    curve.share.conservativeResize(kept);
    if (curve.noise.size() > 0) curve.noise.conservativeResize(kept);
  }
  return circles_of(curve, focus.pixel, resolution);
}

// Standard deviations of the data, without the mirror's own spread; `known`: whether they were given.
Eigen::ArrayXd noise_of(const MeasuredFocus& focus, const FocalBins& bins, const Eigen::ArrayXd& light,
                        bool* known) {
  *known = true;
  if (const auto* image = std::get_if<FocalImage>(&focus.data)) {
    double pixel = focus.noise.value_or(noise_of_rim(*image));
    if (!(pixel > 0) && !focus.gain) *known = false, pixel = 1;
    Eigen::ArrayXd variance = pixel * pixel * bins.pixels;
    if (focus.gain) variance += light.max(0) / *focus.gain;
    return variance.max(1e-30 * std::max(variance.maxCoeff(), 1e-300)).sqrt();
  }
  const auto& curve = std::get<EncircledCurve>(focus.data);
  if (focus.noise) return Eigen::ArrayXd::Constant(bins.radius.size(), *focus.noise);
  if (curve.noise.size() > 0) return curve.noise.head(bins.radius.size());
  if (focus.is_one_mirror) return Eigen::ArrayXd::Constant(bins.radius.size(), kNoiseOfOneMirror);
  *known = false;
  return Eigen::ArrayXd::Ones(bins.radius.size());
}

// The best of a coarse net about the study's own values; nothing where none of it has a prediction.
std::optional<Eigen::VectorXd> start_of(const Problem& problem, const std::vector<SolveUnknown>& unknowns,
                                        int* evaluations) {
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
    const std::optional<ProblemStart> start = problem.start(place);
    if (!start || !(start->sum_of_squares < least)) continue;
    best = start->x;
    least = start->sum_of_squares;
  }
  return best;
}

ParameterFitProblem fit_problem(const Problem& problem, const std::vector<SolveUnknown>& unknowns) {
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
    throw FieldError("target.theory", to_string(use.theory), "\"auto\" or \"ghs\": the light was measured");
  for (const SolveUnknown& unknown : unknowns)
    if (!(unknown.start > 0))
      throw FieldError("solve.for",
                       fmt::format("{}, which is {} in the study", unknown.pointer, unknown.start),
                       "a number above zero as start: the search goes in factors");
  if (std::size_t(bins.radius.size()) <= parameters)
    throw FieldError("solve.focus.file",
                     fmt::format("{} {} for {} unknowns", bins.radius.size(),
                                 bins.are_rings ? "rings of pixels" : "circles", parameters),
                     "more data than unknowns");
}

void describe_numbers(const std::vector<SolveUnknown>& unknowns, const ParameterFitProblem& problem,
                      const ParameterFit& fit, double rise, double variance_factor, PsdOfFocus* result) {
  const Eigen::MatrixXd covariance = variance_factor * parameter_covariance(fit.jacobian);
  const auto count = Eigen::Index(unknowns.size());
  result->correlation.resize(count, count);
  for (Eigen::Index u = 0; u < count; ++u) {
    for (Eigen::Index v = 0; v < count; ++v)
      result->correlation(u, v) = covariance(u, v) / std::sqrt(covariance(u, u) * covariance(v, v));
    const SolveUnknown& unknown = unknowns[std::size_t(u)];
    const ProfileInterval interval = profile_interval(problem, fit, int(u), rise, &result->evaluations);
    result->numbers.push_back({unknown, unknown.start * std::exp(fit.x[u]), std::sqrt(covariance(u, u)),
                               unknown.start * std::exp(interval.lower),
                               unknown.start * std::exp(interval.upper), interval.lower_found,
                               interval.upper_found});
  }
}

// What the result is worth, and what to do where it is little.
void conclude(PsdOfFocus* result, bool converged) {
  std::string open;
  for (const NumberOfFocus& number : result->numbers)
    if (!number.identified()) open += (open.empty() ? "" : ", ") + number.unknown.pointer;
  using enum PsdOfFocusStatus;
  if (!open.empty()) {
    result->message = fmt::format(
        "the light does not determine {}: with the others free it is the same over decades. Take fewer "
        "unknowns, or light from further out (fine roughness) or further in (long roughness)",
        open);
    result->warnings.push_back({"not-identified", result->message});
  }
  if (result->goodness < kPoorFocus) {
    const std::string poor = fmt::format(
        "the light departs from that of any such roughness by {:.2g} times its noise (chance {:.1e}): "
        "another "
        "model of the PSD, an aberration that is not in the study, or a noise that is given too small",
        std::sqrt(result->chi_squared / std::max(result->degrees_of_freedom, 1)), result->goodness);
    if (result->message.empty()) result->message = poor;
    result->warnings.push_back({"poor-fit", poor});
  }
  result->status = !converged                      ? kNotConverged
                   : !open.empty()                 ? kNotIdentified
                   : result->goodness < kPoorFocus ? kNotDescribed
                                                   : kFitted;
  if (!converged) result->message = "the solver found no minimum within its iterations";
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

PsdOfFocus fit_psd_to_focus(const TaskAt& task_at, const std::vector<SolveUnknown>& unknowns,
                            const MeasuredFocus& focus, const RunContext& context) {
  const auto begun = std::chrono::steady_clock::now();
  PsdOfFocus result;
  const Task own = task_at(values_at(unknowns, std::vector<double>(unknowns.size(), 0.0)));
  const FocalBins bins = bins_of(focus, own);
  const GhsPupil pupil(own.mirror, own.aperture, own.wavelength);
  const MeanLight model(task_at, unknowns, bins, focus.dz, pupil, context.threads);
  Problem problem(model, bins, focus, unknowns.size());
  require(own, unknowns, bins, problem.parameters());

  result.confidence = focus.confidence;
  result.is_image = bins.are_rings;
  result.is_one_mirror = focus.is_one_mirror;
  result.dz = focus.dz;
  result.centre_x = bins.centre_x, result.centre_y = bins.centre_y;
  result.radius = bins.radius;
  Eigen::ArrayXd noise = noise_of(focus, bins, bins.measured, &result.is_noise_known);
  problem.set_covariance(noise.square().matrix().asDiagonal().toDenseMatrix());
  const ParameterFitProblem to_solve = fit_problem(problem, unknowns);
  context.say("looking for a start");
  const std::optional<Eigen::VectorXd> start = start_of(problem, unknowns, &result.evaluations);
  if (!start) throw ComputationError("no value of the unknowns near those of the study has a prediction");
  ParameterFit fit = fit_parameters(to_solve, *start);
  result.evaluations += fit.evaluations;
  const Eigen::Index count = bins.radius.size();
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(count, count);
  // What depends on the roughness itself, noise of photons and the mirror's own departure, from the fit
  // before.
  const bool again = focus.is_one_mirror || (bins.are_rings && focus.gain);
  for (int pass = 0; again && pass < 2 && fit.status != ParameterFitStatus::kFailed; ++pass) {
    context.say(fmt::format("pass {}", pass + 2));
    const double total = problem.total(fit.x);
    const std::vector<double> logs = logs_of(fit.x, unknowns.size());
    Eigen::VectorXd light;
    model.at(logs, &light, nullptr);
    bool known = true;
    noise = noise_of(focus, bins, total * light.array() + problem.background(fit.x) * bins.pixels, &known);
    if (focus.is_one_mirror)
      spread = total * total * spread_of_one_mirror(model.task(logs), pupil, bins, focus.dz, context.threads);
    Eigen::MatrixXd covariance = spread;
    covariance.diagonal() += noise.square().matrix();
    problem.set_covariance(covariance);
    fit = fit_parameters(to_solve, Eigen::VectorXd(fit.x));
    result.evaluations += fit.evaluations;
  }
  if (fit.status == ParameterFitStatus::kFailed)
    throw ComputationError("the light has no derivative there: " + fit.message);

  result.chi_squared = fit.sum_of_squares;
  result.degrees_of_freedom = int(count) - int(problem.parameters());
  const double freedom = result.degrees_of_freedom;
  const double factor = result.is_noise_known ? 1 : fit.sum_of_squares / freedom;
  const double deviations =
      student_quantile(0.5 * (1 + focus.confidence), result.is_noise_known ? kInfinity : freedom);
  result.goodness =
      result.is_noise_known ? boost::math::gamma_q(0.5 * freedom, 0.5 * fit.sum_of_squares) : kNaN;
  result.noise_factor = std::sqrt(fit.sum_of_squares / freedom);
  context.say("intervals");
  describe_numbers(unknowns, to_solve, fit, deviations * deviations * factor, factor, &result);
  result.total = problem.total(fit.x);
  result.background = problem.background(fit.x);
  Eigen::VectorXd light;
  model.at(logs_of(fit.x, unknowns.size()), &light, nullptr);
  const Eigen::ArrayXd per = bins.are_rings ? bins.pixels : Eigen::ArrayXd::Ones(count);
  result.measured = bins.measured / per;
  result.fitted = (result.total * light.array() + result.background * bins.pixels) / per;
  result.noise = noise * std::sqrt(factor) / per;
  result.spread = spread.diagonal().array().sqrt() / per;
  conclude(&result, fit.status == ParameterFitStatus::kConverged);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

}  // namespace aberfit
