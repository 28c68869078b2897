#include "spectral_lines.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "aberfit/core/constants.h"
#include "processing.h"

namespace aberfit::internal {
namespace {

using std::numbers::ln2;

// False alarms per spectrum [probability], ten times below the documented rate for an approximate continuum.
constexpr double kFalseAlarm = 1e-4;
constexpr int kFirst = 8;  // ordinate

// P(peak > x continuum) for an exponential ordinate over a continuum that is the median of n_effective
// others. The relative variance of that median is 2.08/n, hence F(2, nu) with nu = 0.96 n degrees of freedom.
double exceedance(double x, double n_effective) {
  const double half = std::max(0.48 * n_effective, 1.0);
  return std::pow(1 + x / half, -half);
}
double anywhere(double p, double looks) { return -std::expm1(looks * std::log1p(-std::min(p, 1 - 1e-16))); }

// Fraction of the total power below which a peak is rounding or leakage: 1e-6 of the RMS height.
constexpr double kNegligible = 1e-12;

// Log level as a piecewise linear function of log f.
struct Trend {
  std::vector<double> log_f, log_level;
  // Adds the continuum of some ordinates about f: their median over ln 2.
  void add(double f, std::vector<double>* values) {
    log_f.push_back(std::log(f));
    log_level.push_back(std::log(std::max(median_of(values) / ln2, std::numeric_limits<double>::min())));
  }
  double operator()(double f) const {
    if (log_f.empty()) return 1;
    if (log_f.size() == 1) return std::exp(log_level[0]);
    const double x = std::log(f);
    std::size_t i = std::size_t(std::upper_bound(log_f.begin(), log_f.end(), x) - log_f.begin());
    i = std::clamp<std::size_t>(i, 1, log_f.size() - 1);
    const double t = (x - log_f[i - 1]) / (log_f[i] - log_f[i - 1]);
    return std::exp(log_level[i - 1] + t * (log_level[i] - log_level[i - 1]));
  }
};

double passed(double f, const Eigen::ArrayXd& nodes, const Eigen::ArrayXd& transfer) {
  const Eigen::Index n = std::upper_bound(nodes.begin(), nodes.end(), f) - nodes.begin();
  return std::max(transfer[std::clamp<Eigen::Index>(n, 0, transfer.size() - 1)], 1e-6);
}

struct Peak {
  int at;
  double continuum, strength, chance;
};
void strongest_first(std::vector<Peak>* peaks) {
  std::sort(peaks->begin(), peaks->end(),
            [](const Peak& a, const Peak& b) { return a.strength > b.strength; });
}

LineSearch profile_lines(const OrdinateGrid& grid, const Eigen::ArrayXd& p, int half, double correlation,
                         const Eigen::ArrayXd& nodes, const Eigen::ArrayXd& transfer) {
  LineSearch search;
  const int last = (grid.cols - 1) / 2;
  Trend trend;
  for (int from = 1; from <= last;) {
    const int to = std::min(last + 1, std::max(from + 9, int(from * 1.5)));
    std::vector<double> values(p.begin() + from, p.begin() + to);
    if (values.size() < 5 && !trend.log_f.empty()) break;
    trend.add(0.5 * (from + to - 1), &values);
    from = to;
  }
  Eigen::ArrayXd chance = Eigen::ArrayXd::Ones(last + 1);
  std::vector<Peak> peaks;
  const double negligible = kNegligible * p.sum();
  for (int k = kFirst; k <= last; ++k) {
    const int reach = std::clamp(int(0.3 * k), 16, 100);
    std::vector<double> around;
    for (int i = std::max(1, k - reach); i <= std::min(last, k + reach); ++i)
      if (std::abs(i - k) > half + 1) around.push_back(p[i] / trend(i));
    if (around.size() < 8) continue;
    const double n = double(around.size()) / correlation;
    const double continuum = trend(k) * median_of(&around) / ln2;
    chance[k] = anywhere(exceedance(p[k] / continuum, n), last);
    if (chance[k] < kFalseAlarm && p[k] > negligible)
      peaks.push_back({k, continuum, p[k] / continuum, chance[k]});
  }
  strongest_first(&peaks);
  for (const auto& [k, continuum, strength, chance_here] : peaks) {
    if (!search.left_out.empty() && search.left_out[std::size_t(k)]) continue;
    search.left_out.resize(std::size_t(grid.size()), 0);
    int low = std::max(1, k - half), high = std::min(last, k + half);
    // The skirts of a strong line also exceed the limit and belong to it.
    while (low > kFirst && chance[low - 1] < kFalseAlarm && p[low - 1] < p[low]) --low;
    while (high < last && chance[high + 1] < kFalseAlarm && p[high + 1] < p[high]) ++high;
    double power = 0, weighted = 0, weight = 0;
    for (int i = low; i <= high; ++i) {
      const double over = p[i] - continuum * trend(i) / trend(k);
      power += over;
      if (std::abs(i - k) <= half) weight += std::max(over, 0.0), weighted += std::max(over, 0.0) * i;
      search.left_out[std::size_t(i)] = search.left_out[std::size_t(grid.conjugate(i))] = 1;
    }
    const double f = weighted / weight * grid.step_x;
    const double rms = std::sqrt(std::max(power, 0.0) * grid.step_x / passed(f, nodes, transfer));
    search.lines.push_back({f, kNaN, rms, strength, chance_here});
  }
  return search;
}

int ring_of(const OrdinateGrid& grid, int i) {
  return int(std::lround(grid.frequency(i) / grid.coarse_step()));
}

void plane_waves(const OrdinateGrid& grid, const Eigen::ArrayXd& p, int half, double correlation,
                 const Eigen::ArrayXd& nodes, const Eigen::ArrayXd& transfer, LineSearch* search) {
  const double nyquist = grid.nyquist() * (1 - 1e-9);
  const int rings = int(nyquist / grid.coarse_step()) + 1;
  std::vector<std::vector<double>> in_ring(std::size_t(rings) + 1);
  for (int i = 0; i < grid.size(); ++i) {
    const double f = grid.frequency(i);
    if (f > 0 && f < nyquist) in_ring[std::size_t(ring_of(grid, i))].push_back(p[i]);
  }
  Trend trend;
  for (int r = 1; r <= rings; ++r)
    if (in_ring[std::size_t(r)].size() >= 8) trend.add(r * grid.coarse_step(), &in_ring[std::size_t(r)]);
  std::vector<Peak> peaks;
  const double negligible = kNegligible * p.sum();
  const double looks = 0.4 * grid.size();
  for (int i = 0; i < grid.size(); ++i) {
    const double f = grid.frequency(i);
    const int k = grid.k(i), l = grid.l(i);
    if (f >= nyquist || f < kFirst * grid.coarse_step() || l < 0 || (l == 0 && k < 0)) continue;
    const double level = trend(f);
    if (p[i] < 15 * level || p[i] < negligible) continue;
    std::vector<double> around;
    for (int dl = -half - 3; dl <= half + 3; ++dl)
      for (int dk = -half - 3; dk <= half + 3; ++dk)
        if (std::abs(dl) > half || std::abs(dk) > half) {
          const int other = grid.index(k + dk, l + dl);
          if (grid.frequency(other) > 0) around.push_back(p[other] * level / trend(grid.frequency(other)));
        }
    const double n = double(around.size()) / (correlation * correlation);
    const double continuum =
        std::max(level, median_of(&around) / ln2);  // for anisotropic surfaces the higher of the two
    const double chance = anywhere(exceedance(p[i] / continuum, n), looks);
    if (chance < kFalseAlarm) peaks.push_back({i, continuum, p[i] / continuum, chance});
  }
  strongest_first(&peaks);
  for (const Peak& peak : peaks) {
    if (!search->left_out.empty() && search->left_out[std::size_t(peak.at)]) continue;
    search->left_out.resize(std::size_t(grid.size()), 0);
    const int k0 = grid.k(peak.at), l0 = grid.l(peak.at);
    double power = 0, weight = 0, x = 0, y = 0;
    for (int l = l0 - half; l <= l0 + half; ++l)
      for (int k = k0 - half; k <= k0 + half; ++k) {
        const int at = grid.index(k, l);
        const double over = p[at] - peak.continuum;
        power += over;
        weight += std::max(over, 0.0), x += std::max(over, 0.0) * k, y += std::max(over, 0.0) * l;
        search->left_out[std::size_t(at)] = search->left_out[std::size_t(grid.conjugate(at))] = 1;
      }
    const double fx = x / weight * grid.step_x, fy = y / weight * grid.step_y, f = std::hypot(fx, fy);
    double angle = std::atan2(fy, fx);
    if (angle < 0) angle += kPi;
    if (angle >= kPi) angle -= kPi;
    const double rms =
        std::sqrt(2 * std::max(power, 0.0) * grid.step_x * grid.step_y / passed(f, nodes, transfer));
    search->lines.push_back({f, angle, rms, peak.strength, peak.chance});
  }
}

// Finds rings: means over annuli one coarse step wide, compared with a log-log line through their neighbours.
void rings(const OrdinateGrid& grid, const Eigen::ArrayXd& p, int half, double correlation,
           const Eigen::ArrayXd& nodes, const Eigen::ArrayXd& transfer, LineSearch* search) {
  const double nyquist = grid.nyquist() * (1 - 1e-9);
  const int last = int(nyquist / grid.coarse_step() - 0.5);
  std::vector<double> sum(std::size_t(std::max(last, 0)) + 2, 0), count = sum;
  const std::vector<char> lines = search->left_out;
  for (int i = 0; i < grid.size(); ++i) {
    const int ring = ring_of(grid, i);
    if (ring == 0 || ring > last || (!lines.empty() && lines[std::size_t(i)])) continue;
    sum[std::size_t(ring)] += p[i], count[std::size_t(ring)] += 0.5;
  }
  std::vector<Peak> peaks;
  const double negligible = kNegligible * p.sum();
  for (int r = kFirst; r <= last; ++r) {
    const std::size_t here = std::size_t(r);
    if (count[here] < kFirst || sum[here] < negligible) continue;
    std::vector<double> x, y, rest;
    for (int j = std::max(3, r - 12); j <= std::min(last, r + 12); ++j)
      if (std::abs(j - r) > half + 1 && count[std::size_t(j)] > 4)
        x.push_back(std::log(double(j) / r)),
            y.push_back(std::log(0.5 * sum[std::size_t(j)] / count[std::size_t(j)]));
    if (x.size() < 8) continue;
    std::vector<double> slopes;  // Theil-Sen, which is robust against another ring nearby
    for (std::size_t a = 0; a < x.size(); ++a)
      for (std::size_t b = a + 1; b < x.size(); ++b) slopes.push_back((y[b] - y[a]) / (x[b] - x[a]));
    const double slope = median_of(&slopes);
    for (std::size_t a = 0; a < x.size(); ++a) rest.push_back(y[a] - slope * x[a]);
    const double level = median_of(&rest);
    for (double& value : rest) value = std::abs(value - level);
    const double theory = correlation / std::sqrt(count[here]), seen = 1.4826 * median_of(&rest);
    const double mean = 0.5 * sum[here] / count[here], sigma = 1.3 * std::max(theory, seen);
    const double z = (std::log(mean) - level) / sigma;
    if (!(z > 3)) continue;
    const boost::math::students_t distribution(double(x.size()) - 2);
    const double chance = anywhere(cdf(complement(distribution, z)), last);
    if (chance < kFalseAlarm) peaks.push_back({r, std::exp(level), mean / std::exp(level), chance});
  }
  strongest_first(&peaks);
  std::vector<char> taken(sum.size(), 0);
  for (const Peak& peak : peaks) {
    if (taken[std::size_t(peak.at)]) continue;
    search->left_out.resize(std::size_t(grid.size()), 0);
    double power = 0, weight = 0, weighted = 0;
    for (int r = std::max(1, peak.at - half); r <= std::min(last, peak.at + half); ++r)
      taken[std::size_t(r)] = 1;
    for (int i = 0; i < grid.size(); ++i) {
      const int r = ring_of(grid, i);
      if (std::abs(r - peak.at) > half || (!lines.empty() && lines[std::size_t(i)])) continue;
      const double over = p[i] - peak.continuum;
      power += over;
      weight += over, weighted += over * grid.frequency(i);
      search->left_out[std::size_t(i)] = 1;
    }
    const double f = weight > 0 ? weighted / weight : peak.at * grid.coarse_step();
    const double rms =
        std::sqrt(std::max(power, 0.0) * grid.step_x * grid.step_y / passed(f, nodes, transfer));
    search->lines.push_back({f, kNaN, rms, peak.strength, peak.chance});
  }
}

}  // namespace

LineSearch find_lines(const OrdinateGrid& grid, const Eigen::ArrayXd& ordinate, int lobe_half,
                      double correlation, const Eigen::ArrayXd& node_frequency,
                      const Eigen::ArrayXd& transfer) {
  if (grid.profile()) return profile_lines(grid, ordinate, lobe_half, correlation, node_frequency, transfer);
  LineSearch search;
  plane_waves(grid, ordinate, lobe_half, correlation, node_frequency, transfer, &search);
  rings(grid, ordinate, lobe_half, correlation, node_frequency, transfer, &search);
  return search;
}

}  // namespace aberfit::internal
