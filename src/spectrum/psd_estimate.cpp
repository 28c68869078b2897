#include "aberfit/spectrum/psd_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "aberfit/core/units.h"
#include "detrend_basis.h"
#include "estimator_response.h"
#include "instrument_edge.h"
#include "periodogram.h"
#include "processing.h"
#include "shape_leak.h"
#include "spectral_lines.h"
#include "window.h"
#include "window_leak.h"

namespace aberfit {
using namespace internal;

namespace {

bool same_valid(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  return a.size() == b.size() && (a.isFinite() == b.isFinite()).all();
}

// Derivatives on uneven positions, from the parabola through a point and its neighbours. Both ends use the
// parabola through the last three points, or the line through the last two.
Eigen::ArrayXd derivative_of(const Eigen::ArrayXd& x, const Eigen::ArrayXd& z, bool parabola_at_ends) {
  const Eigen::Index n = x.size();
  Eigen::ArrayXd slope(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool end = i == 0 || i == n - 1;
    if (end && !parabola_at_ends) {
      const Eigen::Index a = i == 0 ? 0 : n - 2;
      slope[i] = (z[a + 1] - z[a]) / (x[a + 1] - x[a]);
      continue;
    }
    const Eigen::Index m = std::clamp<Eigen::Index>(i, 1, n - 2);
    const double h0 = x[m] - x[m - 1], h1 = x[m + 1] - x[m];
    const double before = (z[m] - z[m - 1]) / h0, after = (z[m + 1] - z[m]) / h1;
    const double bend = (after - before) / (h0 + h1);
    slope[i] = before + bend * (h0 + 2 * (x[i] - x[m]));
  }
  return slope;
}

double rms_of_finite(const Eigen::ArrayXd& values) {
  const double count = double(values.isFinite().count());
  return count > 0 ? std::sqrt(values.isFinite().select(values.square(), 0.0).sum() / count) : 0;
}

// RMS slope of the detrended surface; slopes lose the derivative of the shape subtracted from their heights.
double slope_rms(const Profile& profile, const Profile& heights, const Profile& detrended) {
  if (profile.quantity == ProfileQuantity::kHeight)
    return rms_of_finite(derivative_of(profile.x, detrended.value, false));
  std::vector<Eigen::Index> valid;
  for (Eigen::Index i = 0; i < profile.size(); ++i)
    if (std::isfinite(heights.value[i])) valid.push_back(i);
  const Eigen::ArrayXd shape = (heights.value - detrended.value)(valid);
  return rms_of_finite(profile.value(valid) - derivative_of(profile.x(valid), shape, true));
}

// RMS slopes along x and along y; NaN if no point has both neighbours.
std::pair<double, double> slopes_rms(const HeightMap& detrended) {
  double sum[2] = {0, 0}, count[2] = {0, 0};
  const Grid& z = detrended.height;
  const auto add = [&](int axis, double before, double here, double after, double pitch) {
    const double slope = (after - before) / (2 * pitch);
    if (std::isfinite(slope) && std::isfinite(here)) sum[axis] += slope * slope, ++count[axis];
  };
  for (Eigen::Index r = 0; r < z.rows(); ++r)
    for (Eigen::Index c = 0; c < z.cols(); ++c) {
      if (c > 0 && c + 1 < z.cols()) add(0, z(r, c - 1), z(r, c), z(r, c + 1), detrended.pitch_x);
      if (r > 0 && r + 1 < z.rows()) add(1, z(r - 1, c), z(r, c), z(r + 1, c), detrended.pitch_y);
    }
  return {std::sqrt(sum[0] / count[0]), std::sqrt(sum[1] / count[1])};
}

SurfaceRms map_rms(const HeightMap& detrended) {
  const auto [x, y] = slopes_rms(detrended);
  const bool both = std::isfinite(x) && std::isfinite(y);
  return {rms(detrended), both ? std::sqrt(0.5 * (x * x + y * y)) : 0, x, y};
}

void check(const PsdEstimatorOptions& options) {
  if (options.bins_per_decade < 1) throw std::invalid_argument("bins_per_decade must be 1 or more");
  if (!(options.confidence > 0 && options.confidence < 1))
    throw std::invalid_argument("confidence must lie between 0 and 1");
  if (options.detrend.shape != DetrendShape::kNone && options.detrend.shape != DetrendShape::kEllipse &&
      options.detrend.degree < 0)
    throw std::invalid_argument("detrend.degree must be 0 or more");
}

void trust_up_to_the_edge(PsdEstimate* estimate) {
  const std::optional<InstrumentEdge> edge = instrument_edge(*estimate);
  if (!edge) return;
  estimate->trusted_to = edge->frequency;
  estimate->warnings.push_back(
      {"instrument-cut-off",
       fmt::format(
           "above {} the PSD falls as f^-{:.1f}, below as f^-{:.1f}. This is the limit of the instrument or "
           "a filter, not the surface, so higher frequencies are left out (`f_max` includes them)",
           format_quantity(edge->frequency, Dimension::kSpatialFrequency), edge->exponent_beyond,
           edge->exponent_below)});
}

// Only profiles get this warning: the holes of a map leak as well, and no window reduces that.
void warn_of_the_window(PsdEstimate* estimate) {
  const std::optional<WindowLeak> leak = window_leak(*estimate);
  if (!leak) return;
  estimate->warnings.push_back(
      {"window-leaks",
       fmt::format("from {} on, up to {} of a bin leaks through the side lobes of window \"{}\" from below "
                   "half of its frequency. There the spectrum may fall more steeply than its bins show, and "
                   "their intervals do not hold. Take \"hann\" or \"blackman-harris\", or more detrending",
                   format_quantity(leak->frequency, Dimension::kSpatialFrequency),
                   format_percent(leak->share), to_string(estimate->options.window))});
}

}  // namespace

SurfaceRms surface_rms(const Profile& profile, const DetrendOptions& options) {
  const Profile heights = heights_of(profile), detrended = detrend(heights, options);
  SurfaceRms result;
  result.height = rms(detrended);
  result.slope = slope_rms(profile, heights, detrended);
  return result;
}

SurfaceRms surface_rms(const HeightMap& map, const DetrendOptions& options) {
  return map_rms(detrend(map, options));
}

struct PsdEstimator::Plan {
  // Bins without the ordinates of lines, with their response and covariance.
  struct Binning {
    std::vector<char> left_out;
    OrdinateBins bins;
    EstimatorResponse response;
    Eigen::MatrixXd relative_covariance;
  };

  PsdEstimatorOptions options;
  int threads = 1;
  std::unique_ptr<ProfileProcessing> profile_processing;
  std::unique_ptr<MapProcessing> map_processing;
  Profile profile;  // the geometry
  HeightMap map;
  Eigen::ArrayXd correlation_x, correlation_y;
  Binning whole;

  const SurfaceProcessing& processing() const {
    return profile_processing ? static_cast<const SurfaceProcessing&>(*profile_processing) : *map_processing;
  }

  void prepare() {
    correlation_x = ordinate_covariance(processing().window_x);
    correlation_y = profile_processing ? Eigen::ArrayXd(Eigen::ArrayXd::Ones(1))
                                       : ordinate_covariance(processing().window_y);
    whole = binning({});
  }

  Binning binning(const std::vector<char>& left_out) const {
    Binning made;
    made.left_out = left_out;
    made.bins = logarithmic_bins(processing().grid, options.bins_per_decade, left_out);
    made.response = estimator_response(processing(), made.bins, options.window, threads);
    made.relative_covariance =
        bin_covariance(processing().grid, made.bins, correlation_x, correlation_y, made.response.low);
    return made;
  }

  // Surfaces from one machine have their lines at the same frequencies, so the last few results are kept.
  static constexpr std::size_t kKept = 8;
  mutable std::mutex kept_mutex;
  mutable std::deque<std::shared_ptr<const Binning>> kept;

  mutable std::shared_ptr<const PsdEstimator> further;  // estimator with more detrending; null until needed

  template <class Measured>
  std::shared_ptr<const PsdEstimator> further_than(const Measured& geometry,
                                                   const PsdEstimatorOptions& more) const {
    {
      const std::lock_guard lock(kept_mutex);
      if (further) return further;
    }
    auto made = std::make_shared<const PsdEstimator>(geometry, more, threads);
    const std::lock_guard lock(kept_mutex);
    if (!further) further = std::move(made);
    return further;
  }

  std::shared_ptr<const Binning> without(const std::vector<char>& left_out) const {
    {
      const std::lock_guard lock(kept_mutex);
      for (const auto& known : kept)
        if (known->left_out == left_out) return known;
    }
    auto made = std::make_shared<const Binning>(binning(left_out));
    const std::lock_guard lock(kept_mutex);
    kept.push_front(made);
    if (kept.size() > kKept) kept.pop_back();
    return made;
  }

  // Periodogram of detrended heights, one-sided [m^3].
  Eigen::ArrayXd ordinates(const Profile& detrended) const {
    const double pitch = 1 / (processing().grid.cols * processing().grid.step_x);
    return 2 * pitch / processing().window_power() *
           processing().power(profile_processing->windowed(detrended));
  }
  // Periodogram of the region of a map after subtraction of `shape`, two-sided [m^4].
  Eigen::ArrayXd ordinates(const HeightMap& measured, const DetrendOptions& shape) const {
    return measured.pitch_x * measured.pitch_y / processing().window_power() *
           processing().power(map_processing->windowed(detrend(map_processing->region(measured), shape)));
  }
  Eigen::ArrayXd ordinates(const Profile& measured, const DetrendOptions& shape) const {
    return ordinates(detrend(heights_of(measured), shape));
  }

  // left_out: ordinates of lines, which are in no bin.
  PsdEstimate estimate(const Eigen::ArrayXd& ordinate, std::vector<char>* left_out) const {
    if (!options.find_lines) return binned(ordinate, whole);
    const double correlation = 2 * correlation_x.sum() - correlation_x[0];
    const LineSearch search = find_lines(processing().grid, ordinate, main_lobe(options.window), correlation,
                                         whole.response.node_frequency, whole.response.transfer);
    if (search.lines.empty()) return binned(ordinate, whole);
    PsdEstimate result = binned(ordinate, *without(search.left_out));
    result.lines = search.lines;
    *left_out = search.left_out;
    return result;
  }

  PsdEstimate binned(const Eigen::ArrayXd& ordinate, const Binning& in) const {
    PsdEstimate result;
    result.kind = profile_processing ? PsdTableKind::k1dOneSided : PsdTableKind::k2dTwoSided;
    result.options = options;
    result.resolution = processing().grid.resolution();
    result.nyquist = processing().grid.nyquist();
    result.frequency = in.bins.frequency, result.low = in.bins.low, result.high = in.bins.high,
    result.count = in.bins.count;
    result.psd = in.bins.mean(ordinate);
    result.node_frequency = in.response.node_frequency;
    result.response = in.response.matrix;
    result.relative_covariance = in.relative_covariance;
    result.dof = 2 / result.relative_covariance.diagonal().array();
    result.lower.resize(in.bins.size()), result.upper.resize(in.bins.size());
    for (Eigen::Index b = 0; b < in.bins.size(); ++b) {
      const boost::math::chi_squared distribution(result.dof[b]);
      const double tail = 0.5 * (1 - options.confidence), level = result.psd[b] * result.dof[b];
      result.lower[b] = level / quantile(complement(distribution, tail));
      result.upper[b] = level / quantile(distribution, tail);
    }
    trust_up_to_the_edge(&result);
    return result;
  }
};

PsdEstimator::PsdEstimator(const Profile& geometry, const PsdEstimatorOptions& options, int threads) {
  check(options);
  auto plan = std::make_unique<Plan>();
  plan->options = options, plan->threads = threads, plan->profile = geometry;
  plan->profile_processing = std::make_unique<ProfileProcessing>(geometry, options);
  plan->prepare();
  plan_ = std::move(plan);
}

PsdEstimator::PsdEstimator(const HeightMap& geometry, const PsdEstimatorOptions& options, int threads) {
  check(options);
  auto plan = std::make_unique<Plan>();
  plan->options = options, plan->threads = threads, plan->map = geometry;
  plan->map_processing = std::make_unique<MapProcessing>(geometry, options);
  plan->prepare();
  plan_ = std::move(plan);
}

PsdEstimator::~PsdEstimator() = default;
PsdEstimator::PsdEstimator(PsdEstimator&&) noexcept = default;
PsdEstimator& PsdEstimator::operator=(PsdEstimator&&) noexcept = default;

template <class Measured>
void PsdEstimator::trust_from_the_shape(const Measured& measured, const std::vector<char>& left_out,
                                        PsdEstimate* result) const {
  PsdEstimatorOptions more = plan_->options;
  more.detrend = detrended_further(more.detrend, plan_->profile_processing != nullptr);
  const Eigen::ArrayXd ordinate = plan_->ordinates(measured, more.detrend);
  const auto bins = [&](const Plan& plan) {
    return left_out.empty() ? plan.binned(ordinate, plan.whole)
                            : plan.binned(ordinate, *plan.without(left_out));
  };
  // The response with further degrees is computed only if it can change the result.
  if (!may_leak(*result, bins(*plan_).psd)) return;
  const std::optional<ShapeLeak> leak =
      shape_leak(*result, bins(*plan_->further_than(measured, more)->plan_));
  if (!leak) return;
  if (!leak->everywhere) result->trusted_from = leak->frequency;
  result->warnings.push_back(
      {"shape-leaks",
       fmt::format("a shape that detrending left behind leaks into the bins below {}: with four more degrees "
                   "removed they fall by up to a factor {:.2g}. {} Remove the shape (detrend, degree)",
                   format_quantity(leak->frequency, Dimension::kSpatialFrequency), leak->excess,
                   leak->everywhere
                       ? "Too few bins above remain for a fit, so the model describes this shape."
                       : "They are left out of the fit (`f_min` includes them).")});
}

PsdEstimate PsdEstimator::operator()(const Profile& profile) const {
  const Plan& plan = *plan_;
  if (!plan.profile_processing || profile.quantity != plan.profile.quantity ||
      profile.size() != plan.profile.size() || (profile.x != plan.profile.x).any() ||
      !same_valid(profile.value, plan.profile.value))
    throw std::invalid_argument("the profile does not have the geometry this estimator was made for");
  const Profile heights = heights_of(profile);
  if (plan.options.detrend.shape == DetrendShape::kEllipse && !fit_ellipse(heights).converged) {
    PsdEstimatorOptions parabola = plan.options;
    parabola.detrend = {DetrendShape::kPolynomial, 2};
    PsdEstimate result = PsdEstimator(profile, parabola, plan.threads)(profile);
    result.warnings.push_back(
        {"ellipse-fit-failed", "no mirror ellipse fits the profile; a parabola was removed instead"});
    return result;
  }
  const Profile detrended = detrend(heights, plan.options.detrend);
  std::vector<char> left_out;
  PsdEstimate result = plan.estimate(plan.ordinates(detrended), &left_out);
  trust_from_the_shape(profile, left_out, &result);
  warn_of_the_window(&result);
  result.rms_height = rms(detrended);
  result.rms_slope = slope_rms(profile, heights, detrended);
  if (profile.quantity == ProfileQuantity::kSlope)
    result.rms_slope_as_slopes = rms(detrend(profile, plan.options.detrend));
  return result;
}

PsdEstimate PsdEstimator::operator()(const HeightMap& map) const {
  const Plan& plan = *plan_;
  if (!plan.map_processing || map.pitch_x != plan.map.pitch_x || map.pitch_y != plan.map.pitch_y ||
      map.rows() != plan.map.rows() || map.columns() != plan.map.columns() ||
      !same_valid(map.height.reshaped(), plan.map.height.reshaped()))
    throw std::invalid_argument("the map does not have the geometry this estimator was made for");
  const HeightMap detrended = detrend(map, plan.options.detrend);
  std::vector<char> left_out;
  PsdEstimate result = plan.estimate(plan.ordinates(map, plan.options.detrend), &left_out);
  trust_from_the_shape(map, left_out, &result);
  const SurfaceRms whole = map_rms(detrended);
  result.rms_height = whole.height;
  result.rms_slope = whole.slope, result.rms_slope_x = whole.slope_x, result.rms_slope_y = whole.slope_y;
  return result;
}

PsdEstimate estimate_psd(const Profile& profile, const PsdEstimatorOptions& options, int threads) {
  return PsdEstimator(profile, options, threads)(profile);
}
PsdEstimate estimate_psd(const HeightMap& map, const PsdEstimatorOptions& options, int threads) {
  return PsdEstimator(map, options, threads)(map);
}

}  // namespace aberfit
