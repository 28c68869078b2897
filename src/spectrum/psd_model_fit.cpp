#include "aberfit/spectrum/psd_model_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cassert>
#include <cmath>
#include <map>

#include "aberfit/core/constants.h"
#include "psd_shape_fit.h"

namespace aberfit {
using namespace internal;

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Largest standard deviation of the logarithm of a determined parameter: a factor e either way.
constexpr double kLargestLogStd = 1.0;
// A richer family must improve the criterion by this much.
constexpr double kWorthwhile = 2.0;
// If no family describes the data, one with undetermined parameters must be better by this much ("strong"
// evidence, Kass and Raftery 1995).
constexpr double kMuchBetter = 6.0;
constexpr Index kCurvePoints = 257;

const PsdFamily kFamilies[] = {PsdFamily::kUniform,
                               PsdFamily::kPowerLaw,
                               PsdFamily::kKCorrelation,
                               PsdFamily::kPowerLawAndFloor,
                               PsdFamily::kKCorrelationAndFloor,
                               PsdFamily::kTwoKCorrelations};

double chi_squared_quantile(double probability, double freedom) {
  return boost::math::quantile(boost::math::chi_squared(freedom), probability);
}

// The limit of a family, and the parameters that are undetermined if the limit does as well.
struct Limit {
  PsdFamily family;
  int freedom;  // parameters that lose their meaning there
  std::string reason;
  struct Unknown {
    std::string name, unit;
    int internal;   // index in theta
    int direction;  // side on which the data still bound it; 0: neither
  };
  std::vector<Unknown> unknown;
};

std::vector<Limit> limits_of(PsdFamily family) {
  // Indices in theta: k-correlation level, log B, log exponent; power law level, exponent; then the floor.
  switch (family) {
    case PsdFamily::kKCorrelation:
      return {{PsdFamily::kUniform,
               2,
               "a uniform PSD fits equally well; if there is a knee, it lies above the band",
               {{"B", "m", 1, +1}, {"exponent", "1", 2, 0}}},
              {PsdFamily::kPowerLaw,
               1,
               "a power law fits equally well; the knee lies below the band",
               {{"B", "m", 1, -1}}}};
    case PsdFamily::kPowerLawAndFloor:
      return {
          {PsdFamily::kPowerLaw, 1, "the floor cannot be distinguished from zero", {{"floor", "m", 2, +1}}}};
    case PsdFamily::kKCorrelationAndFloor:
      return {{PsdFamily::kKCorrelation,
               1,
               "the floor cannot be distinguished from zero",
               {{"floor", "m", 3, +1}}},
              {PsdFamily::kPowerLawAndFloor,
               1,
               "a power law and a floor fit equally well; the knee lies below the band",
               {{"B", "m", 1, -1}}}};
    case PsdFamily::kTwoKCorrelations:
      return {{PsdFamily::kKCorrelation,
               3,
               "one k-correlation fits as well as two",
               {{"rms_2", "m", 3, 0}, {"B_2", "m", 4, 0}, {"exponent_2", "1", 5, 0}}},
              {PsdFamily::kKCorrelationAndFloor,
               2,
               "a floor fits as well as the second k-correlation",
               {{"B_2", "m", 4, 0}, {"exponent_2", "1", 5, 0}}}};
    default:
      return {};
  }
}

class Fitter {
 public:
  // with_model_error: for data that no family describes.
  Fitter(const PsdEstimate& estimate, const PsdBand& band, const PsdFitOptions& options,
         bool with_model_error)
      : estimate_(estimate), band_(band), options_(options), with_model_error_(with_model_error) {}

  const PsdShapeFit& fit(PsdFamily family) {
    const auto found = fits_.find(family);
    if (found != fits_.end()) return found->second;
    return fits_
        .emplace(family, with_model_error_
                             ? fit_shape_with_model_error(band_, family, options_.max_iterations)
                             : fit_shape(band_, family, options_.max_iterations))
        .first->second;
  }

  // Repeats the fits from the results of another fitter. Least squares of the logarithms finds minima that
  // the likelihood misses, because thousands of degrees of freedom make it steep.
  void retry(Fitter& from) {
    for (auto& [family, fit] : fits_) {
      const VectorXd& start = from.fit(family).theta;
      if (start.size() == 0) continue;
      const PsdShapeFit again = fit_shape(band_, family, options_.max_iterations, {start});
      if (again.theta.size() > 0 && (fit.theta.size() == 0 || again.log_likelihood > fit.log_likelihood))
        fit = again;
    }
  }

  bool eligible(PsdFamily family) const {
    return count(family) + 1 <= int(band_.bins.size()) && count(family) + 1 < band_.effective_bins;
  }

  int count(PsdFamily family) const {
    return parameter_count(PsdShape{family, band_.kind, band_.f_min, band_.f_max});
  }

  // AICc with independent bins as sample size and Takeuchi's form of the penalty, because correlated bins
  // inflate likelihood ratios (`overdispersion`). With a model error, that inflation would come from the
  // misfit of each family and favour simple families. It is then omitted, and tau counts as a parameter.
  PsdCandidate candidate(PsdFamily family) {
    const PsdShapeFit& shape = fit(family);
    PsdCandidate candidate{family, count(family), shape.log_likelihood, kInfinity};
    const double k = candidate.parameters + (with_model_error_ ? 1 : 0), room = band_.effective_bins - k - 1;
    const double inflation = with_model_error_ ? 1 : std::max(1.0, shape.overdispersion);
    if (shape.theta.size() > 0 && room > 0)
      candidate.criterion = -2 * shape.log_likelihood + inflation * 2 * k * (1 + (k + 1) / room);
    return candidate;
  }

  // Chooses the simplest family within kWorthwhile of the best with determined parameters, or any family if
  // only it describes the data. With a model error, the best of all is chosen if it is much better.
  PsdFamily choose(PsdModelFit* result) {
    std::vector<PsdCandidate> known, all;
    for (const PsdFamily family : kFamilies) {
      if (!eligible(family)) continue;
      const PsdCandidate made = candidate(family);
      result->candidates.push_back(made);
      if (fit(family).theta.size() == 0) continue;
      all.push_back(made);
      if (all_determined(fit(family))) known.push_back(made);
    }
    if (all.empty()) return PsdFamily::kUniform;
    const PsdFamily any = simplest(all), certain = known.empty() ? any : simplest(known);
    if (with_model_error_)
      return criterion_of(all, any) + kMuchBetter < criterion_of(known, certain) ? any : certain;
    const bool better =
        goodness_of_fit(band_, fit(certain)) < kPoorFit && goodness_of_fit(band_, fit(any)) >= kPoorFit;
    return better ? any : certain;
  }

  // Replaces a family by its limit where that does as well, and records what is thereby undetermined.
  PsdFamily reduce(PsdFamily family, PsdModelFit* result) {
    for (const Limit& limit : limits_of(family)) {
      const PsdShapeFit &full = fit(family), &less = fit(limit.family);
      if (level_profile(less)) continue;
      const double inflation = std::max(1.0, full.overdispersion);
      const double gain =
          2 * (full.log_likelihood - less.log_likelihood) / (with_model_error_ ? 1 : inflation);
      if (gain > chi_squared_quantile(options_.confidence, limit.freedom)) continue;
      std::string names;
      for (const Limit::Unknown& unknown : limit.unknown) {
        result->parameters.push_back(bounded(full, unknown, inflation));
        names += (names.empty() ? "" : " and ") + unknown.name;
      }
      result->warnings.push_back(
          {"not-identified", fmt::format("the data do not determine {}: {}", names, limit.reason)});
      return reduce(limit.family, result);
    }
    return family;
  }

  void report(PsdFamily family, PsdModelFit* result) {
    const PsdShapeFit& shape = fit(family);
    result->family = family;
    result->f_min = band_.f_min;
    result->f_max = band_.f_max;
    result->message = shape.message;
    if (shape.theta.size() == 0) {
      result->status = PsdFitStatus::kFailed;
      return;
    }
    result->status = shape.converged ? PsdFitStatus::kConverged : PsdFitStatus::kNotConverged;
    result->covariance = shape.covariance;
    result->log_likelihood = shape.log_likelihood;
    result->criterion = candidate(family).criterion;
    result->goodness = goodness_of_fit(band_, shape);
    result->model_error = shape.model_error;
    result->model = surface_model(shape.shape, shape.theta);
    add_expected(shape, result);
    add_parameters(shape, result);
    if (result->goodness < kPoorFit)
      result->warnings.push_back(
          {"poor-fit", shape.model_error > 0
                           ? fmt::format("the model differs from the bins by a typical factor of {:.2f}, "
                                         "more than chance allows (p = {:.1e}); the intervals include it",
                                         std::exp(shape.model_error), result->goodness)
                           : fmt::format("the bins scatter about the model more than chance allows (p = "
                                         "{:.1e}); the intervals assume that the model is right",
                                         result->goodness)});
    if (band_.kind == PsdTableKind::k1dOneSided &&
        (family == PsdFamily::kPowerLawAndFloor || family == PsdFamily::kKCorrelationAndFloor))
      result->warnings.push_back(
          {"floor-left-out", "the floor is taken as noise of the instrument and left out of the model"});
  }

  bool describes(PsdFamily family) {
    return fit(family).theta.size() == 0 || goodness_of_fit(band_, fit(family)) >= kPoorFit;
  }

 private:
  static double criterion_of(const std::vector<PsdCandidate>& candidates, PsdFamily family) {
    for (const PsdCandidate& c : candidates)
      if (c.family == family) return c.criterion;
    return kInfinity;
  }

  static PsdFamily simplest(const std::vector<PsdCandidate>& candidates) {
    double best = kInfinity;
    for (const PsdCandidate& c : candidates) best = std::min(best, c.criterion);
    const PsdCandidate* chosen = &candidates.front();
    bool found = false;
    for (const PsdCandidate& c : candidates) {
      if (c.criterion > best + kWorthwhile) continue;
      if (!found || c.parameters < chosen->parameters ||
          (c.parameters == chosen->parameters && c.criterion < chosen->criterion))
        chosen = &c, found = true;
    }
    return chosen->family;
  }

  // A profile of constant S1 is no limit of low knees: the surface would have exponent 1 and no level.
  bool level_profile(const PsdShapeFit& fit) const {
    const bool power =
        fit.shape.family == PsdFamily::kPowerLaw || fit.shape.family == PsdFamily::kPowerLawAndFloor;
    return power && band_.kind == PsdTableKind::k1dOneSided &&
           !(fit.theta[1] - 1 > 2 * std::sqrt(fit.covariance(1, 1)));
  }

  PsdParameter bounded(const PsdShapeFit& full, const Limit::Unknown& unknown, double inflation) const {
    PsdParameter row{unknown.name, unknown.unit, kNaN, kNaN, unknown.name == "exponent" ? -kInfinity : 0,
                     kInfinity,    false};
    if (unknown.direction == 0) return row;
    // The one-sided bound is an end of the two-sided interval with confidence 2 confidence - 1.
    const double drop = 0.5 * inflation * chi_squared_quantile(2 * options_.confidence - 1, 1);
    const double at =
        profile_bound(band_, full, unknown.internal, unknown.direction, drop, options_.max_iterations);
    if (!std::isfinite(at)) return row;
    VectorXd theta = full.theta;
    theta[unknown.internal] = at;
    for (const PsdShapeParameter& parameter : shape_parameters(full.shape, theta))
      if (parameter.name == unknown.name)
        (unknown.direction > 0 ? row.upper : row.lower) = parameter.natural(parameter.coordinate);
    return row;
  }

  void add_expected(const PsdShapeFit& shape, PsdModelFit* result) const {
    std::vector<Index> nodes;
    for (Index n = 0; n < estimate_.node_frequency.size(); ++n)
      if (estimate_.node_frequency[n] > 0) nodes.push_back(n);
    result->expected = estimate_.response(Eigen::all, nodes) *
                       shape_values(shape.shape, shape.theta, band_.node).value.matrix();
    result->spectrum = shape_values(shape.shape, shape.theta, estimate_.frequency).value;
    // The points are denser towards the ends, where the profile of a uniform surface falls to zero.
    const double middle = 0.5 * std::log(band_.f_min * band_.f_max),
                 half = 0.5 * std::log(band_.f_max / band_.f_min);
    const Eigen::ArrayXd f = (middle - half * Eigen::ArrayXd::LinSpaced(kCurvePoints, 0, kPi).cos()).exp();
    const Eigen::ArrayXd curve = shape_values(shape.shape, shape.theta, f).value;
    for (Index i = 0; i < f.size(); ++i)
      if (curve[i] > 0) {
        result->curve.frequency.push_back(f[i]);
        result->curve.psd.push_back(curve[i]);
      }
  }

  // Standard deviation of a coordinate; a parameter at the end of its range is known for others, not itself.
  static double deviation(const PsdShapeParameter& parameter, const Eigen::MatrixXd& covariance) {
    if (parameter.internal >= 0 && std::isinf(covariance(parameter.internal, parameter.internal)))
      return kInfinity;
    double variance = 0;
    for (Index i = 0; i < parameter.gradient.size(); ++i)
      for (Index j = 0; j < parameter.gradient.size(); ++j)
        if (std::isfinite(covariance(i, j)))
          variance += parameter.gradient[i] * parameter.gradient[j] * covariance(i, j);
    return std::sqrt(variance);
  }

  // An amplitude extrapolated over decades is uncertain by large factors but still determined.
  static bool determined(const PsdShapeParameter& parameter, double std) {
    return parameter.name == "amplitude" ? std::isfinite(std) : std <= kLargestLogStd;
  }

  bool all_determined(const PsdShapeFit& shape) const {
    for (const PsdShapeParameter& parameter : shape_parameters(shape.shape, shape.theta))
      if (!determined(parameter, deviation(parameter, shape.covariance))) return false;
    return true;
  }

  static std::string known_of(const PsdParameter& row, const double (&ends)[2]) {
    const std::string unit = row.unit == "1" ? "" : fmt::format(" {}", row.unit);
    if (std::isfinite(ends[0]) && std::isfinite(ends[1]))
      return fmt::format("it lies between {:.3g} and {:.3g}{}", row.lower, row.upper, unit);
    if (std::isfinite(ends[0])) return fmt::format("it is at least {:.3g}{}", row.lower, unit);
    if (std::isfinite(ends[1])) return fmt::format("it is at most {:.3g}{}", row.upper, unit);
    return "nothing is known about it";
  }

  // Wald intervals in the coordinate (mostly the logarithm), where the likelihood is closest to a parabola.
  // The profile likelihood is used where it is not parabolic.
  void add_parameters(const PsdShapeFit& shape, PsdModelFit* result) const {
    const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * options_.confidence);
    std::vector<PsdParameter> rows;
    for (const PsdShapeParameter& parameter : shape_parameters(shape.shape, shape.theta)) {
      const double std = deviation(parameter, shape.covariance), at = parameter.coordinate;
      PsdParameter row{parameter.name, parameter.unit};
      row.value = parameter.natural(at);
      row.std = parameter.logarithmic ? std * std::exp(at) : std;
      row.lower = parameter.natural(at - z * std);
      row.upper = parameter.natural(at + z * std);
      row.identified = determined(parameter, std);
      if (!row.identified) {
        row.value = row.std = kNaN;
        double ends[2] = {-kInfinity, kInfinity};
        if (parameter.internal >= 0)
          for (const int direction : {-1, 1})
            ends[direction > 0] = profile_bound(
                band_, shape, parameter.internal, direction,
                0.5 * std::max(1.0, shape.overdispersion) * chi_squared_quantile(options_.confidence, 1),
                options_.max_iterations);
        row.lower = parameter.natural(ends[0]);
        row.upper = parameter.natural(ends[1]);
        result->warnings.push_back({"not-identified", fmt::format("the data do not determine {}: {}",
                                                                  row.name, known_of(row, ends))});
      }
      rows.push_back(row);
    }
    result->parameters.insert(result->parameters.begin(), rows.begin(), rows.end());
  }

  const PsdEstimate& estimate_;
  const PsdBand& band_;
  const PsdFitOptions& options_;
  const bool with_model_error_;
  std::map<PsdFamily, PsdShapeFit> fits_;
};

}  // namespace

std::string to_string(PsdFamily family) {
  // The order is that of the enum.
  static constexpr const char* kNames[] = {"auto",
                                           "power-law",
                                           "k-correlation",
                                           "uniform",
                                           "power-law-and-floor",
                                           "k-correlation-and-floor",
                                           "two-k-correlations"};
  return kNames[std::size_t(family)];
}

std::string to_string(PsdFitStatus status) {
  // The order is that of the enum.
  static constexpr const char* kNames[] = {"not run", "converged", "not converged", "failed"};
  return kNames[std::size_t(status)];
}

PsdModelFit fit_psd_model(const PsdEstimate& estimate, const PsdFitOptions& options) {
  assert(options.confidence > 0.5 && options.confidence < 1 && options.max_iterations > 0);
  PsdModelFit result;
  const PsdBand band = usable_band(estimate, options.f_min, options.f_max);
  Fitter fitter(estimate, band, options, false);
  const PsdFamily least = options.family == PsdFamily::kAuto ? PsdFamily::kUniform : options.family;
  if (int(band.bins.size()) < fitter.count(least) + 1) {
    result.status = PsdFitStatus::kFailed;
    result.message = fmt::format("{} usable bins in the band are too few for the {} parameters of {}",
                                 band.bins.size(), fitter.count(least), to_string(least));
    result.expected = Eigen::ArrayXd::Constant(estimate.psd.size(), kNaN);
    return result;
  }
  const auto chosen = [&](Fitter& by, PsdModelFit* into) {
    if (options.family == PsdFamily::kAuto) return by.choose(into);
    into->candidates.push_back(by.candidate(options.family));
    return options.family;
  };
  const auto finish = [&](Fitter& by, PsdFamily family, PsdModelFit* into) {
    if (by.fit(family).theta.size() > 0) family = by.reduce(family, into);
    by.report(family, into);
    return family;
  };
  PsdFamily family = chosen(fitter, &result);
  if (fitter.describes(family) && fitter.describes(finish(fitter, family, &result))) return result;

  Fitter allowing(estimate, band, options, true);
  fitter.retry(allowing);
  result = {};
  family = chosen(fitter, &result);
  finish(fitter, family, &result);
  if (fitter.describes(result.family)) return result;

  // Sampling errors do not explain the residuals; bins with most ordinates would dominate without a model
  // error.
  PsdModelFit allowed;
  family = chosen(allowing, &allowed);
  if (allowing.fit(family).theta.size() == 0) return result;
  finish(allowing, family, &allowed);
  return allowed.model_error > 0 ? allowed : result;
}

}  // namespace aberfit
