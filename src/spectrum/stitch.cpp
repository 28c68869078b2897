#include <algorithm>
#include <stdexcept>
#include <vector>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {
namespace {

struct Bin {
  std::size_t band;
  Eigen::Index index;
};

bool overlap(const PsdEstimate& a, Eigen::Index i, const PsdEstimate& b, Eigen::Index j) {
  return a.low[i] < b.high[j] && b.low[j] < a.high[i];
}

bool trusted(const PsdEstimate& band, Eigen::Index i) {
  return band.frequency[i] >= band.trusted_from && band.frequency[i] <= band.trusted_to;
}

}  // namespace

PsdEstimate stitch(const std::vector<PsdEstimate>& bands) {
  if (bands.empty())
    throw std::invalid_argument("there is nothing to stitch, because no PSD estimate is given");
  for (const PsdEstimate& band : bands)
    if (band.kind != bands.front().kind)
      throw std::invalid_argument(
          "PSDs of profiles and of maps cannot be stitched; convert them to one kind first");
  PsdEstimate result;
  result.kind = bands.front().kind, result.options = bands.front().options;
  std::vector<Bin> stay;
  int pairs = 0, disagree = 0;
  for (std::size_t s = 0; s < bands.size(); ++s)
    for (Eigen::Index i = 0; i < bands[s].psd.size(); ++i) {
      if (!trusted(bands[s], i)) continue;
      bool beaten = false;
      for (std::size_t t = 0; t < bands.size(); ++t)
        for (Eigen::Index j = 0; t != s && j < bands[t].psd.size(); ++j) {
          if (!trusted(bands[t], j) || !overlap(bands[s], i, bands[t], j)) continue;
          const double own = bands[s].dof[i], other = bands[t].dof[j];
          if (bands[t].low[j] <= bands[s].frequency[i] && bands[s].frequency[i] < bands[t].high[j] &&
              (other > own || (other == own && t < s)))
            beaten = true;
          if (s < t) {
            ++pairs;
            if (bands[s].upper[i] < bands[t].lower[j] || bands[t].upper[j] < bands[s].lower[i]) ++disagree;
          }
        }
      if (!beaten) stay.push_back({s, i});
    }
  std::stable_sort(stay.begin(), stay.end(), [&](const Bin& a, const Bin& b) {
    return bands[a.band].frequency[a.index] < bands[b.band].frequency[b.index];
  });
  // The nodes of all bands are placed side by side in ascending order.
  std::vector<Bin> nodes;
  for (std::size_t s = 0; s < bands.size(); ++s)
    for (Eigen::Index i = 0; i < bands[s].node_frequency.size(); ++i) nodes.push_back({s, i});
  std::stable_sort(nodes.begin(), nodes.end(), [&](const Bin& a, const Bin& b) {
    return bands[a.band].node_frequency[a.index] < bands[b.band].node_frequency[b.index];
  });
  const Eigen::Index n = Eigen::Index(stay.size()), m = Eigen::Index(nodes.size());
  for (Eigen::ArrayXd* column : {&result.frequency, &result.low, &result.high, &result.psd, &result.count,
                                 &result.dof, &result.lower, &result.upper})
    column->resize(n);
  result.node_frequency.resize(m);
  result.response = Eigen::MatrixXd::Zero(n, m);
  result.relative_covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < m; ++k)
    result.node_frequency[k] = bands[nodes[std::size_t(k)].band].node_frequency[nodes[std::size_t(k)].index];
  for (Eigen::Index b = 0; b < n; ++b) {
    const auto [s, i] = stay[std::size_t(b)];
    const PsdEstimate& band = bands[s];
    result.frequency[b] = band.frequency[i], result.low[b] = band.low[i], result.high[b] = band.high[i];
    result.psd[b] = band.psd[i], result.count[b] = band.count[i], result.dof[b] = band.dof[i];
    result.lower[b] = band.lower[i], result.upper[b] = band.upper[i];
    for (Eigen::Index k = 0; k < m; ++k)
      if (nodes[std::size_t(k)].band == s)
        result.response(b, k) = band.response(i, nodes[std::size_t(k)].index);
    for (Eigen::Index c = 0; c < n; ++c)
      if (stay[std::size_t(c)].band == s)
        result.relative_covariance(b, c) = band.relative_covariance(i, stay[std::size_t(c)].index);
  }
  result.resolution = bands.front().resolution;
  for (const PsdEstimate& band : bands) {
    result.lines.insert(result.lines.end(), band.lines.begin(), band.lines.end());
    result.warnings.insert(result.warnings.end(), band.warnings.begin(), band.warnings.end());
    result.rms_height = std::max(result.rms_height, band.rms_height);
    if (band.rms_slope > result.rms_slope) {
      result.rms_slope = band.rms_slope, result.rms_slope_as_slopes = band.rms_slope_as_slopes;
      result.rms_slope_x = band.rms_slope_x, result.rms_slope_y = band.rms_slope_y;
    }
    result.resolution = std::min(result.resolution, band.resolution);
    result.nyquist = std::max(result.nyquist, band.nyquist);
  }
  if (disagree > 0)
    result.warnings.push_back(
        {"bands-disagree", std::to_string(disagree) + " of " + std::to_string(pairs) +
                               " overlapping pairs of bins differ by more than their intervals"});
  return result;
}

}  // namespace aberfit
