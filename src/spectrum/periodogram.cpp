#include "periodogram.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace aberfit {

Eigen::ArrayXd OrdinateBins::mean(const Eigen::ArrayXd& ordinate) const {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(size());
  for (std::size_t i = 0; i < of.size(); ++i)
    if (of[i] >= 0) sum[of[i]] += ordinate[Eigen::Index(i)];
  return sum / (2 * count);  // each conjugate pair was added twice
}

OrdinateBins logarithmic_bins(const OrdinateGrid& grid, int bins_per_decade,
                              const std::vector<char>& left_out) {
  const double top = grid.top() * (1 - 1e-9), ratio = std::pow(10, 1.0 / bins_per_decade);
  // This puts the lowest ordinate in the middle of its bin.
  const double first = grid.resolution() / std::sqrt(ratio);
  OrdinateBins bins;
  bins.of.assign(std::size_t(grid.size()), -1);
  const int steps = int(std::log(top / first) / std::log(ratio)) + 1;
  std::vector<double> sum(std::size_t(steps), 0), all(std::size_t(steps), 0), kept(std::size_t(steps), 0);
  for (int i = 0; i < grid.size(); ++i) {
    const double f = grid.frequency(i);
    if (f <= 0 || f >= top) continue;
    const int bin = std::clamp(int(std::floor(std::log(f / first) / std::log(ratio))), 0, steps - 1);
    all[std::size_t(bin)] += 0.5;
    if (!left_out.empty() && left_out[std::size_t(i)]) continue;
    bins.of[std::size_t(i)] = bin;
    kept[std::size_t(bin)] += 0.5;
    sum[std::size_t(bin)] += 0.5 * f;
  }
  // Empty steps are divided between their neighbours, so that bins adjoin.
  std::vector<double> low, high;
  std::vector<int> place(std::size_t(steps), -1), filled;
  for (int b = 0; b < steps; ++b)
    if (all[std::size_t(b)] > 0) filled.push_back(b);
  for (const int b : filled)
    low.push_back(first * std::pow(ratio, b)),
        high.push_back(std::min(first * std::pow(ratio, b + 1), grid.top()));
  for (std::size_t b = 1; b < filled.size(); ++b) low[b] = high[b - 1] = std::sqrt(low[b] * high[b - 1]);
  std::vector<std::size_t> stay;
  for (std::size_t b = 0; b < filled.size(); ++b)
    if (kept[std::size_t(filled[b])] > 0) place[std::size_t(filled[b])] = int(stay.size()), stay.push_back(b);
  const Eigen::Index n = Eigen::Index(stay.size());
  bins.frequency.resize(n), bins.low.resize(n), bins.high.resize(n), bins.count.resize(n);
  for (Eigen::Index b = 0; b < n; ++b) {
    const std::size_t from = stay[std::size_t(b)], step = std::size_t(filled[from]);
    bins.low[b] = low[from], bins.high[b] = high[from], bins.count[b] = kept[step];
    bins.frequency[b] = sum[step] / kept[step];
  }
  for (int& bin : bins.of)
    if (bin >= 0) bin = place[std::size_t(bin)];
  return bins;
}

namespace internal {

Eigen::MatrixXd bin_covariance(const OrdinateGrid& grid, const OrdinateBins& bins,
                               const Eigen::ArrayXd& along_x, const Eigen::ArrayXd& along_y,
                               const LowOrdinates& low) {
  std::vector<int> low_place(std::size_t(grid.size()), -1);
  for (std::size_t a = 0; a < low.index.size(); ++a) low_place[std::size_t(low.index[a])] = int(a);
  const auto reach = [](const Eigen::ArrayXd& taps) {
    int last = 0;
    for (int d = 0; d < taps.size(); ++d)
      if (taps[d] > 0) last = d;
    return last;
  };
  const int reach_x = std::min(reach(along_x), (grid.cols - 1) / 2);
  const int reach_y = grid.profile() ? 0 : std::min(reach(along_y), (grid.rows - 1) / 2);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(bins.size(), bins.size());
  for (int i = 0; i < grid.size(); ++i) {
    const int b = bins.of[std::size_t(i)];
    if (b < 0) continue;
    const int k = grid.k(i), l = grid.l(i);
    for (int dl = -reach_y; dl <= reach_y; ++dl)
      for (int dk = -reach_x; dk <= reach_x; ++dk) {
        const int other = grid.index(k + dk, l + dl), c = bins.of[std::size_t(other)];
        if (c < 0 || (low_place[std::size_t(i)] >= 0 && low_place[std::size_t(other)] >= 0)) continue;
        sum(b, c) += along_x[std::abs(dk)] * (grid.profile() ? 1 : along_y[std::abs(dl)]);
      }
  }
  for (std::size_t a = 0; a < low.index.size(); ++a)
    for (std::size_t d = 0; d < low.index.size(); ++d) {
      const int b = bins.of[std::size_t(low.index[a])], c = bins.of[std::size_t(low.index[d])];
      const Eigen::Index r = Eigen::Index(a), s = Eigen::Index(d);
      if (b >= 0 && c >= 0)
        sum(b, c) +=
            std::norm(low.covariance(r, s)) / (low.covariance(r, r).real() * low.covariance(s, s).real());
    }
  // The sum contains k of both halves of the plane, and l and -l of each pair; half of it is needed.
  for (Eigen::Index b = 0; b < bins.size(); ++b)
    for (Eigen::Index c = 0; c < bins.size(); ++c) sum(b, c) /= 2 * bins.count[b] * bins.count[c];
  return 0.5 * (sum + sum.transpose());
}

}  // namespace internal
}  // namespace aberfit
