#include "estimator_response.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/parallel.h"
#include "window.h"

namespace aberfit::internal {
namespace {

// Linear interpolation of f^-4 between nodes has an error of at most 0.13 %.
constexpr int kNodesPerDecade = 100;
constexpr int kProfileAllWaves = 2400;  // samples; up to here every wave of a profile is propagated
// Every wave below these ordinates is propagated.
constexpr int kProfileLow = 96, kMapLow = 8, kSmallMapLow = 12;
constexpr int kSmallMap = 150 * 150;  // points
constexpr int kProfileWavesPerDecade = 120, kMapWavesPerDecade = 24, kMapDirections = 4;
// Small maps with holes need more waves: 24 x 4 give an error of 0.5 % (white, 120 x 128 points, 10 % holes).
constexpr int kSmallMapWavesPerDecade = 96, kSmallMapDirections = 8;

struct Wave {
  double u, v, measure;
};

// Number of parts per axis into which a block of one ordinate by one ordinate is divided.
int profile_cells(int a) { return a < 2 ? 16 : a < 4 ? 8 : a < 12 ? 4 : 2; }
int map_cells(double radius) { return radius < 1 ? 8 : radius < 3.5 ? 4 : 2; }

class Nodes {
 public:
  Nodes(double low, double high) {
    const int n = int(std::ceil(kNodesPerDecade * std::log10(high / low))) + 1;
    frequency = Eigen::exp(Eigen::ArrayXd::LinSpaced(n, std::log(low), std::log(high)));
    low_ = std::log(low), step_ = std::log(high / low) / (n - 1);
  }
  // Adds `amount` of S(f) to a row over the nodes.
  template <class Row>
  void add(Row&& row, double f, double amount) const {
    const Eigen::Index i = place(f);
    const double t = std::clamp((f - frequency[i]) / (frequency[i + 1] - frequency[i]), 0.0, 1.0);
    row[i] += (1 - t) * amount;
    row[i + 1] += t * amount;
  }
  double interpolated(const Eigen::ArrayXd& at_nodes, double f) const {
    const Eigen::Index i = place(f);
    const double t = std::clamp((f - frequency[i]) / (frequency[i + 1] - frequency[i]), 0.0, 1.0);
    return (1 - t) * at_nodes[i] + t * at_nodes[i + 1];
  }
  Eigen::Index place(double f) const {
    return std::clamp(Eigen::Index(std::floor((std::log(f) - low_) / step_)), Eigen::Index(0),
                      frequency.size() - 2);
  }
  Eigen::ArrayXd frequency;

 private:
  double low_, step_;
};

struct Region {
  bool profile;
  int half_x, half_y;  // blocks per axis; the last one may be a half
  double low;
  bool sent(int a, int b) const { return profile ? a < low : std::hypot(a + 0.5, b + 0.5) < low; }
};

std::vector<Wave> low_waves(const OrdinateGrid& grid, const Region& region) {
  std::vector<Wave> waves;
  int sign = 1;
  for (int b = 0; b < region.half_y; ++b)
    for (int a = 0; a < region.half_x; ++a) {
      if (!region.sent(a, b)) continue;
      const int cells = region.profile ? profile_cells(a) : map_cells(std::hypot(a + 0.5, b + 0.5));
      for (int j = 0; j < (region.profile ? 1 : cells); ++j)
        for (int i = 0; i < cells; ++i) {
          const double u = a + (i + 0.5) / cells, v = region.profile ? 0 : b + (j + 0.5) / cells;
          if (2 * u >= grid.cols || (!region.profile && 2 * v >= grid.rows)) continue;
          // One quarter of the plane represents the half plane; the sign alternates because holes break
          // symmetry.
          waves.push_back({u, sign * v, region.profile ? 1.0 / cells : 2.0 / (cells * cells)});
          sign = -sign;
        }
    }
  return waves;
}

std::vector<int> low_ordinates(const OrdinateGrid& grid) {
  std::vector<int> index;
  const int reach = grid.profile() ? std::min(8, (grid.cols - 1) / 2) : 3;
  for (int l = grid.profile() ? 0 : -reach; l <= (grid.profile() ? 0 : reach); ++l)
    for (int k = -reach; k <= reach; ++k)
      if ((k != 0 || l != 0) && 2 * std::abs(k) < grid.cols &&
          (grid.profile() || 2 * std::abs(l) < grid.rows) && (grid.profile() || std::hypot(k, l) < 3.2))
        index.push_back(grid.index(k, l));
  return index;
}

// Adds the waves f, -f and, for a map, their mirror images to the covariance of the low ordinates. In a frame
// about the middle a mirrored wave has mirrored ordinates, and only the modulus of the covariance is used.
void add_low(const OrdinateGrid& grid, const Eigen::VectorXcd& value, double u, double v, double amount,
             LowOrdinates* low) {
  std::vector<int> place(std::size_t(grid.size()), -1);
  const Eigen::Index n = Eigen::Index(low->index.size());
  for (Eigen::Index a = 0; a < n; ++a) place[std::size_t(low->index[std::size_t(a)])] = int(a);
  Eigen::VectorXcd centred(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const int at = low->index[std::size_t(a)];
    const double turn =
        (grid.k(at) - u) * (grid.cols - 1) / grid.cols + (grid.l(at) - v) * (grid.rows - 1) / grid.rows;
    centred[a] = value[a] * std::polar(1.0, kPi * turn);
  }
  for (const int mirror : {1, -1}) {
    if (grid.profile() && mirror < 0) continue;
    for (const int sign : {1, -1}) {
      Eigen::VectorXcd wave(n);
      for (Eigen::Index a = 0; a < n; ++a) {
        const int at = low->index[std::size_t(a)];
        const int from = place[std::size_t(grid.index(sign * grid.k(at), sign * mirror * grid.l(at)))];
        wave[a] = sign > 0 ? centred[from] : std::conj(centred[from]);
      }
      low->covariance += amount * wave * wave.adjoint();
    }
  }
}

// The processing that the waves go through, and the scale of the result.
struct Way {
  const SurfaceProcessing& processing;
  const OrdinateBins& bins;
  int lobe_half;  // half-width of the window's main lobe [ordinates]
  double scale;   // factor from |transform|^2 to the periodogram
  double top;     // highest frequency [cycles/m]
  int threads;
};

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Region region_of(const OrdinateGrid& grid) {
  Region region{grid.profile(), (grid.cols + 1) / 2, grid.profile() ? 1 : (grid.rows + 1) / 2, 0};
  if (grid.profile())
    region.low = grid.cols <= kProfileAllWaves ? grid.cols : kProfileLow;
  else
    region.low = grid.size() <= kSmallMap ? kSmallMapLow : kMapLow;
  return region;
}

// Adds every wave of low frequency to the matrix and to the covariance of the low ordinates.
void send_low(const Way& way, const Region& region, const Nodes& nodes, RowMajorMatrix* matrix,
              LowOrdinates* low) {
  const OrdinateGrid& grid = way.processing.grid;
  const Eigen::Index lows = Eigen::Index(low->index.size());
  const std::vector<Wave> waves = low_waves(grid, region);
  std::vector<Eigen::ArrayXd> in_bins(waves.size());
  std::vector<Eigen::VectorXcd> at_low(waves.size());
  parallel_for(waves.size(), way.threads, [&](std::size_t i) {
    const ComplexGrid samples = way.processing.wave_transform(waves[i].u, waves[i].v);
    in_bins[i] = 2 * way.scale * way.bins.mean(samples.reshaped<Eigen::RowMajor>().abs2());
    at_low[i].resize(lows);
    for (Eigen::Index a = 0; a < lows; ++a) at_low[i][a] = samples.data()[low->index[std::size_t(a)]];
  });
  // A red spectrum is assumed; the covariance of the low ordinates hardly depends on it.
  const double exponent = grid.profile() ? 2.5 : 3.5;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    const double f = std::hypot(waves[i].u * grid.step_x, waves[i].v * grid.step_y);
    for (Eigen::Index b = 0; b < way.bins.size(); ++b)
      nodes.add(matrix->row(b), f, waves[i].measure * in_bins[i][b]);
    if (std::hypot(waves[i].u, waves[i].v) < 16)
      add_low(grid, at_low[i], waves[i].u, waves[i].v,
              waves[i].measure * way.scale * std::pow(f / grid.resolution(), -exponent), low);
  }
}

// Selected waves of high frequency, in groups of one frequency and several directions.
struct Selection {
  struct Selected {
    double u, v;
    std::size_t group;
  };
  std::vector<Selected> waves;
  std::vector<double> group_frequency;
};

Selection select_high(const Way& way, const Region& region) {
  const OrdinateGrid& grid = way.processing.grid;
  Selection selection;
  const double start = region.low * grid.resolution();
  const bool small = grid.size() <= kSmallMap;
  const int per_decade = grid.profile() ? kProfileWavesPerDecade
                         : small        ? kSmallMapWavesPerDecade
                                        : kMapWavesPerDecade;
  const int directions = grid.profile() ? 1 : small ? kSmallMapDirections : kMapDirections;
  for (int g = 0; start < way.top; ++g) {
    const double f = start * std::pow(10, (g + 0.5) / per_decade);
    if (f >= way.top) break;
    bool any = false;
    for (int d = 0; d < directions; ++d) {
      // Directions advance from group to group, so that they do not always meet the same line of ordinates.
      const double turn = std::fmod((d + 0.5) / directions + 0.6180339887498949 * g, 1.0);
      const double angle = grid.profile() ? 0 : 0.5 * kPi * turn;
      const double u = f * std::cos(angle) / grid.step_x;
      const double v = grid.profile() ? 0 : (d % 2 ? -1 : 1) * f * std::sin(angle) / grid.step_y;
      if (2 * u >= grid.cols - 1 || (!grid.profile() && 2 * std::abs(v) >= grid.rows - 1)) continue;
      if (std::hypot(u, v) < region.low) continue;
      selection.waves.push_back({u, v, selection.group_frequency.size()});
      any = true;
    }
    if (any) selection.group_frequency.push_back(f);
  }
  return selection;
}

// Means over the directions of a group: the fraction in the main lobe, and where the rest goes.
struct Leakage {
  std::vector<double> transfer;
  Eigen::MatrixXd spread;  // bins x groups
};

Leakage send_selected(const Way& way, const Selection& selection) {
  const SurfaceProcessing& processing = way.processing;
  const OrdinateGrid& grid = processing.grid;
  const int lobe_half = way.lobe_half;
  std::vector<Eigen::ArrayXd> diffuse(selection.waves.size());
  std::vector<double> kept(selection.waves.size());
  parallel_for(selection.waves.size(), way.threads, [&](std::size_t i) {
    const auto [u, v, group] = selection.waves[i];
    Eigen::ArrayXd power = processing.wave_transform(u, v).reshaped<Eigen::RowMajor>().abs2();
    double measured = 0, ideal = 0;
    const int k0 = int(std::floor(u)), l0 = int(std::floor(v));
    for (int l = grid.profile() ? 0 : l0 - lobe_half + 1; l <= (grid.profile() ? 0 : l0 + lobe_half); ++l)
      for (int k = k0 - lobe_half + 1; k <= k0 + lobe_half; ++k) {
        double& here = power[grid.index(k, l)];
        measured += here * way.scale;
        ideal += lobe(processing.window_x, k - u) * (grid.profile() ? 1 : lobe(processing.window_y, l - v));
        here = 0;
      }
    kept[i] = measured / ideal;
    diffuse[i] = 2 * way.scale * way.bins.mean(power);
  });
  const std::size_t groups = selection.group_frequency.size();
  Leakage mean{std::vector<double>(groups, 0), Eigen::MatrixXd::Zero(way.bins.size(), Eigen::Index(groups))};
  std::vector<double> weight(groups, 0);
  for (std::size_t i = 0; i < selection.waves.size(); ++i) {
    const std::size_t g = selection.waves[i].group;
    weight[g] += 1, mean.transfer[g] += kept[i];
    mean.spread.col(Eigen::Index(g)) += diffuse[i].matrix();
  }
  for (std::size_t g = 0; g < groups; ++g)
    mean.transfer[g] /= weight[g], mean.spread.col(Eigen::Index(g)) /= weight[g];
  return mean;
}

// Interpolates from groups to nodes in log f. Sets the transfer and returns the leakage, bins x nodes.
Eigen::MatrixXd at_nodes(const Leakage& leakage, const std::vector<double>& group_frequency,
                         const Nodes& nodes, Eigen::ArrayXd* transfer) {
  const std::size_t groups = group_frequency.size();
  Eigen::MatrixXd leaked(leakage.spread.rows(), nodes.frequency.size());
  for (Eigen::Index n = 0; n < nodes.frequency.size(); ++n) {
    const double f = nodes.frequency[n];
    const std::size_t after = std::size_t(
        std::upper_bound(group_frequency.begin(), group_frequency.end(), f) - group_frequency.begin());
    const std::size_t right = std::min(after, groups - 1), left = after == 0 ? 0 : after - 1;
    double t = 0;
    if (left < right)
      t = std::log(f / group_frequency[left]) / std::log(group_frequency[right] / group_frequency[left]);
    (*transfer)[n] = (1 - t) * leakage.transfer[left] + t * leakage.transfer[right];
    leaked.col(n) =
        (1 - t) * leakage.spread.col(Eigen::Index(left)) + t * leakage.spread.col(Eigen::Index(right));
  }
  return leaked;
}

// Main lobes of waves on a grid of half an ordinate, distributed over the bins according to the window.
class MainLobes {
 public:
  explicit MainLobes(const Way& way)
      : way_(way),
        grid_(way.processing.grid),
        taps_(2 * way.lobe_half),
        along_x_(taps_, 2),
        along_y_(taps_, 2) {
    along_y_.setOnes();
    for (int side = 0; side < 2; ++side)
      for (int t = 0; t < taps_; ++t) {
        const double nu = t - way.lobe_half + 1 - (0.25 + 0.5 * side);
        along_x_(t, side) = lobe(way.processing.window_x, nu);
        if (!grid_.profile()) along_y_(t, side) = lobe(way.processing.window_y, nu);
      }
    share.resize(way.bins.size());
  }

  // Sets share and touched for the wave at quarter i of column a and quarter j of row b.
  void place(int a, int i, int b, int j) {
    share.setZero();
    touched.clear();
    for (int tl = 0; tl < (grid_.profile() ? 1 : taps_); ++tl) {
      const int row =
          (grid_.profile() ? 0 : OrdinateGrid::wrapped(b + tl - way_.lobe_half + 1, grid_.rows)) * grid_.cols;
      const double down = grid_.profile() ? 1 : along_y_(tl, j);
      for (int tk = 0; tk < taps_; ++tk) {
        const int bin =
            way_.bins.of[std::size_t(row + OrdinateGrid::wrapped(a + tk - way_.lobe_half + 1, grid_.cols))];
        if (bin < 0) continue;
        if (std::find(touched.begin(), touched.end(), bin) == touched.end()) touched.push_back(bin);
        share[bin] += down * along_x_(tk, i);
      }
    }
  }

  Eigen::ArrayXd share;      // fraction of the lobe in each bin
  std::vector<int> touched;  // bins with a part of the lobe

 private:
  const Way& way_;
  const OrdinateGrid& grid_;
  int taps_;
  Eigen::ArrayXXd along_x_, along_y_;  // taps x the two quarters of an ordinate
};

// Adds the main lobes of all high waves to the matrix; returns their measure by nodes.
Eigen::ArrayXd add_main_lobes(const Way& way, const Region& region, const Nodes& nodes,
                              const Eigen::ArrayXd& transfer, RowMajorMatrix* matrix) {
  const OrdinateGrid& grid = way.processing.grid;
  MainLobes lobes(way);
  Eigen::ArrayXd measure = Eigen::ArrayXd::Zero(nodes.frequency.size());
  const double cell = grid.profile() ? 0.5 : 0.25;
  for (int b = -region.half_y; b < region.half_y; ++b) {
    if (grid.profile() && b < 0) continue;
    for (int a = 0; a < region.half_x; ++a) {
      if (region.sent(a, b < 0 ? -1 - b : b)) continue;
      for (int j = 0; j < (grid.profile() ? 1 : 2); ++j)
        for (int i = 0; i < 2; ++i) {
          const double u = a + 0.25 + 0.5 * i, v = grid.profile() ? 0 : b + 0.25 + 0.5 * j;
          if (2 * u >= grid.cols || (!grid.profile() && 2 * std::abs(v) >= grid.rows)) continue;
          const double f = std::hypot(u * grid.step_x, v * grid.step_y);
          lobes.place(a, i, b, j);
          nodes.add(measure, f, cell);
          const double passed = cell * nodes.interpolated(transfer, f);
          for (const int bin : lobes.touched)
            nodes.add(matrix->row(bin), f, passed * lobes.share[bin] / way.bins.count[bin]);
        }
    }
  }
  return measure;
}

}  // namespace

EstimatorResponse estimator_response(const SurfaceProcessing& processing, const OrdinateBins& bins,
                                     WindowKind window, int threads) {
  const OrdinateGrid& grid = processing.grid;
  const double scale = 1 / (double(grid.size()) * processing.window_power());
  const double top =
      grid.profile() ? grid.nyquist() : 0.5 * std::hypot(grid.cols * grid.step_x, grid.rows * grid.step_y);
  const Way way{processing, bins, main_lobe(window), scale, top, threads};
  const Nodes nodes(grid.resolution() / 16, top);
  EstimatorResponse result;
  result.node_frequency = nodes.frequency;
  RowMajorMatrix matrix = Eigen::MatrixXd::Zero(bins.size(), nodes.frequency.size());
  result.transfer = Eigen::ArrayXd::Ones(nodes.frequency.size());
  result.low.index = low_ordinates(grid);
  const Eigen::Index lows = Eigen::Index(result.low.index.size());
  result.low.covariance = Eigen::MatrixXcd::Zero(lows, lows);

  const Region region = region_of(grid);
  send_low(way, region, nodes, &matrix, &result.low);
  const Selection selection = select_high(way, region);
  if (!selection.waves.empty()) {
    const Leakage leakage = send_selected(way, selection);
    const Eigen::MatrixXd leaked = at_nodes(leakage, selection.group_frequency, nodes, &result.transfer);
    const Eigen::ArrayXd measure = add_main_lobes(way, region, nodes, result.transfer, &matrix);
    matrix += leaked * measure.matrix().asDiagonal();
  }
  result.matrix = matrix;
  return result;
}

}  // namespace aberfit::internal
