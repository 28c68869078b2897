#include "aberfit/spectrum/height_differences.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/roughness/psd_integrals.h"
#include "processing.h"

namespace aberfit {
using namespace internal;

namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr int kPerDecade = 12;
constexpr double kOnGrid = 0.01;     // fraction of the pitch; smaller deviations count as even positions
constexpr double kNeighbours = 1.5;  // pitches; a wider gap means a missing sample
constexpr double kWithin = 0.1;      // fraction of a separation, limited by kHalfPitch
constexpr double kHalfPitch = 0.5;

// Returns whole numbers from 1 to `most`, evenly spaced in the logarithm.
std::vector<Index> spread_steps(Index most) {
  std::vector<Index> steps;
  for (int j = 0;; ++j) {
    const Index step = Index(std::lround(std::pow(10.0, double(j) / kPerDecade)));
    if (step > most) return steps;
    if (steps.empty() || step > steps.back()) steps.push_back(step);
  }
}

// Returns heights at even steps; NaN where nothing was measured.
ArrayXd on_even_steps(const Profile& heights, double* step) {
  std::vector<Index> valid;
  for (Index i = 0; i < heights.size(); ++i)
    if (std::isfinite(heights.value[i])) valid.push_back(i);
  if (valid.size() < 2) return {};
  const ArrayXd x = heights.x(valid) - heights.x[valid.front()], h = heights.value(valid);
  const double pitch = median_pitch(heights);
  const Index n = even_samples(x, pitch);
  *step = x[x.size() - 1] / double(n - 1);
  const ArrayXd place = x / *step;
  ArrayXd even = ArrayXd::Constant(n, std::numeric_limits<double>::quiet_NaN());
  if (((place - place.round()).abs() <= kOnGrid).all()) {
    for (Index i = 0; i < x.size(); ++i) even[Index(std::lround(place[i]))] = h[i];
    return even;
  }
  for (Index i = 0, left = 0; i < n; ++i) {
    while (left + 2 < x.size() && place[left + 1] <= double(i)) ++left;
    const double width = place[left + 1] - place[left], share = (double(i) - place[left]) / width;
    if (width <= kNeighbours) even[i] = (1 - share) * h[left] + share * h[left + 1];
  }
  return even;
}

// Returns the next length from n on that is a product of 2, 3, 5, 7.
int smooth_length(Index n) {
  for (;; ++n) {
    Index rest = n;
    for (const Index prime : {2, 3, 5, 7})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return int(n);
  }
}

// Returns for every lag the sum of squared differences (real part) and the number of pairs (imaginary part).
// The correlation is cyclic; zeros beyond the map separate lags up to (reach_x, reach_y).
ComplexGrid pair_sums(const Grid& heights, Index reach_x, Index reach_y) {
  const int rows = smooth_length(heights.rows() + reach_y), columns = smooth_length(heights.cols() + reach_x);
  ComplexGrid field = ComplexGrid::Zero(rows, columns), squares = field;
  for (Index r = 0; r < heights.rows(); ++r)
    for (Index c = 0; c < heights.cols(); ++c)
      if (const double h = heights(r, c); std::isfinite(h)) {
        field(r, c) = {h, 1};
        squares(r, c) = h * h;
      }
  const FourierTransform transform(rows, columns);
  transform(field.data());
  transform(squares.data());
  // `field` is heights + i mask; their transforms are H = (F + F'*)/2, M = (F - F'*)/2i, with F' at -f.
  ComplexGrid& sums = squares;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const std::complex<double> there = std::conj(field((rows - r) % rows, (columns - c) % columns));
      const std::complex<double> h = 0.5 * (field(r, c) + there);
      const std::complex<double> m = std::complex<double>(0, -0.5) * (field(r, c) - there);
      sums(r, c) = {2 * (std::real(std::conj(squares(r, c)) * m) - std::norm(h)), std::norm(m)};
    }
  transform(sums.data());
  return sums / double(rows) / double(columns);
}

}  // namespace

HeightDifferences height_differences(const Profile& measured, const DetrendOptions& options) {
  double step = 0;
  const ArrayXd h = on_even_steps(detrend(heights_of(measured), options), &step);
  std::vector<double> separation, mean_square, pairs;
  // For a few dozen separations the direct sum is as fast as an FFT and has no rounding error.
  for (const Index lag : spread_steps(h.size() / 2)) {
    const ArrayXd square = (h.tail(h.size() - lag) - h.head(h.size() - lag)).square();
    const double count = double(square.isFinite().count());
    if (count == 0) continue;
    separation.push_back(double(lag) * step);
    mean_square.push_back(square.isFinite().select(square, 0.0).sum() / count);
    pairs.push_back(count);
  }
  const auto array = [](const std::vector<double>& values) {
    return ArrayXd(Eigen::Map<const ArrayXd>(values.data(), Index(values.size())));
  };
  return {array(separation), array(mean_square), array(pairs)};
}

HeightDifferences height_differences(const HeightMap& measured, const DetrendOptions& options) {
  if (!(measured.pitch_x > 0 && measured.pitch_y > 0))
    throw std::invalid_argument("structure function: the pitch of the map is unknown");
  const HeightMap map = detrend(measured, options);
  // Heights scaled to the size of the mask have the same rounding error.
  const double scale = rms(map) > 0 ? rms(map) : 1;
  const double pitch = std::max(map.pitch_x, map.pitch_y);
  const double side = std::min(map.pitch_x * double(map.columns()), map.pitch_y * double(map.rows()));
  const std::vector<Index> steps = spread_steps(Index(0.5 * side / pitch));
  const Index n = Index(steps.size());
  if (n == 0) return {};
  const double farthest = (double(steps.back()) + kHalfPitch) * pitch;
  const Index reach_x = Index(farthest / map.pitch_x), reach_y = Index(farthest / map.pitch_y);
  const ComplexGrid sums = pair_sums(map.height / scale, reach_x, reach_y);
  ArrayXd distance = ArrayXd::Zero(n), square = distance, pairs = distance;
  // Half of all lags are enough; the others are the same pairs.
  for (Index y = 0; y <= reach_y; ++y)
    for (Index x = y == 0 ? 1 : -reach_x; x <= reach_x; ++x) {
      const double s = std::hypot(double(x) * map.pitch_x, double(y) * map.pitch_y), at = s / pitch;
      const auto above = std::lower_bound(steps.begin(), steps.end(), at);
      const std::complex<double> sum = sums(y, (x + sums.cols()) % sums.cols());
      const double count = std::round(sum.imag());
      for (auto step = above == steps.begin() ? above : above - 1; step != steps.end() && step <= above;
           ++step) {
        if (std::abs(at - double(*step)) > std::min(kHalfPitch, kWithin * double(*step))) continue;
        const Index k = step - steps.begin();
        distance[k] += count * s, square[k] += std::max(0.0, sum.real()), pairs[k] += count;
      }
    }
  std::vector<Index> there;
  for (Index k = 0; k < n; ++k)
    if (pairs[k] > 0) there.push_back(k);
  return {(distance / pairs)(there), scale * scale * (square / pairs)(there), pairs(there)};
}

ArrayXd model_height_differences(const PsdModelFit& fit, PsdTableKind kind, const ArrayXd& separation) {
  if (kind == PsdTableKind::k2dTwoSided)
    // The function structure_function returns C(0) - C(s).
    return 2 * structure_function(RadialPsd(fit.model), separation);
  // Largest phase [rad] across a panel for which its 24 nodes integrate the cosine to rounding.
  constexpr double kSlow = 8;
  ArrayXd result = ArrayXd::Zero(separation.size());
  const TablePsd& curve = fit.curve;
  if (curve.frequency.size() < 2) return result;
  const std::vector<PsdPanel> panels =
      resolved_panels(RadialPsd(curve), curve.frequency.front(), curve.frequency.back());
  for (Index i = 0; i < separation.size(); ++i) {
    const double omega = 2 * kPi * separation[i];
    for (const PsdPanel& panel : panels) {
      if (omega * (panel.b - panel.a) < kSlow) {
        result[i] += 4 * (panel.weight * panel.psd * (0.5 * omega * panel.f).sin().square()).sum();
      } else {
        const PanelArray cosine = oscillatory_weights(panel.a, panel.b, omega).real();
        result[i] += 2 * (panel.psd * (panel.weight - cosine)).sum();
      }
    }
  }
  return result;
}

}  // namespace aberfit
