#include "aberfit/spectrum/outliers.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "aberfit/core/constants.h"
#include "processing.h"

namespace aberfit {
namespace {

using Eigen::Index;

constexpr double kFalseAlarms = 0.005;  // probability of an alarm in a clean measurement, see outliers.h
constexpr double kDeviationsOfMedian = 1.4826;
constexpr double kEfficiencyOfMedian = 0.37;  // relative to the standard deviation
constexpr double kBesideOthers = 3.5;         // standard deviations
// Limit of the median step at the rim of a region over the height of the region. It is 1 for damage and 0.1
// to 0.3 for a bend of the surface, such as the turned-down rim of an interferogram.
constexpr double kSharp = 0.4, kSharpOnAProfile = 0.25;
constexpr Index kFewestTested = 32, kFewestInTile = 40;
// Every pass extends a damaged region by a sample. Eight passes meet the documented size; the upper limits
// bound the time for a large map with damage everywhere.
constexpr Index kMostPasses = 50, kFewestPasses = 12, kMostVisits = 100'000'000;

struct Arm {
  Index row, column;
};

// Prediction of a sample from its neighbours at one distance.
struct Prediction {
  double value = 0;
  int kind = -1;  // 0: all pairs; 1 + k: pair k; 1 + arms + k: line k extrapolated; -1: no neighbours
};

// Returns the standard deviation of Gaussian numbers about `centre`, insensitive to a few outliers.
double deviation_about(double centre, std::vector<double> values) {
  for (double& v : values) v = std::abs(v - centre);
  return kDeviationsOfMedian * median_of(&values);
}

class Samples {
 public:
  explicit Samples(const Profile& profile)
      : value_(profile.value.transpose()), x_(&profile.x), longest_(1.5 * median_pitch(profile)) {}
  explicit Samples(const HeightMap& map) : value_(map.height) {}

  bool profile() const { return x_ != nullptr; }
  const Grid& value() const { return value_; }
  void take_out(const Mask& marked) { value_ = marked.select(kNaN, value_); }

  double at(Index r, Index c) const {
    return r < 0 || c < 0 || r >= value_.rows() || c >= value_.cols() ? kNaN : value_(r, c);
  }
  // Value at (r, c) of the line through the samples at one and `other` arms: -1 interpolates, 2 extrapolates.
  double along(Index r, Index c, Arm arm, int other) const {
    const double near = at(r + arm.row, c + arm.column),
                 far = at(r + other * arm.row, c + other * arm.column);
    if (!std::isfinite(near) || !std::isfinite(far)) return kNaN;
    double share = 1.0 / (1 - other);
    if (x_) {
      const double a = (*x_)[c + arm.column] - (*x_)[c], b = (*x_)[c + other * arm.column] - (*x_)[c];
      // Across a gap of the record the neighbours are too far apart to predict the sample.
      if (std::max(std::abs(a), std::abs(b - a)) >
          longest_ * double(std::abs(arm.column) * (other < 0 ? 2 : 1)))
        return kNaN;
      share = a / (a - b);
    }
    return near + share * (far - near);
  }
  // Smallest step between neighbours, an estimate of the rounding of the numbers.
  double rounding() const {
    double least = kInfinity;
    for (Index r = 0; r < value_.rows(); ++r)
      for (Index c = 1; c < value_.cols(); ++c)
        if (const double step = std::abs(value_(r, c) - value_(r, c - 1)); step > 0)
          least = std::min(least, step);
    return std::isfinite(least) ? least : 0;
  }

 private:
  Grid value_;
  const Eigen::ArrayXd* x_ = nullptr;
  double longest_ = 0;
};

// Residuals of all samples from their neighbours at one distance, in standard deviations.
class Residuals {
 public:
  Residuals(const Samples& samples, Index distance) : samples_(samples) {
    const Index d = distance;
    arms_ = samples.profile() ? std::vector<Arm>{{0, d}, {0, 2 * d}, {0, 3 * d}}
                              : std::vector<Arm>{{0, d}, {d, 0}, {d, d}, {d, -d}};
    const Index rows = samples.value().rows(), columns = samples.value().cols();
    const Index tile = samples.profile() ? std::max<Index>(128, 32 * d) : std::max<Index>(32, 8 * d);
    tiles_down_ = std::max<Index>(1, rows / tile), tiles_across_ = std::max<Index>(1, columns / tile);
    for (Index r = 0; r < rows; ++r)
      first_of_row_.push_back(std::size_t(r * tiles_down_ / rows * tiles_across_));
    for (Index c = 0; c < columns; ++c) tile_of_column_.push_back(std::size_t(c * tiles_across_ / columns));
    const std::size_t tiles = std::size_t(tiles_down_ * tiles_across_);
    tile_centre_.assign(tiles, 0), tile_deviation_.assign(tiles, 0), tile_factor_.assign(tiles, 1);
    changed_.assign(tiles, false);
    residual_ = Grid::Constant(rows, columns, kNaN);
    kind_.setConstant(rows, columns, -1);
    for (Index r = 0; r < rows; ++r)
      for (Index c = 0; c < columns; ++c) compare(r, c);
    scale();
  }

  // Updates the residuals that depend on removed samples, and the standard deviations.
  void without(const Mask& taken) {
    for (Index r = 0; r < taken.rows(); ++r)
      for (Index c = 0; c < taken.cols(); ++c) {
        if (!taken(r, c)) continue;
        compare(r, c);
        for (const Arm& arm : arms_)
          for (const Index steps : {-2, -1, 1, 2}) {
            const Index row = r + steps * arm.row, column = c + steps * arm.column;
            if (row >= 0 && column >= 0 && row < taken.rows() && column < taken.cols()) compare(row, column);
          }
      }
    scale();
  }

  // From now on, lines are extrapolated where no pair exists.
  void continue_lines() {
    continued_ = true;
    for (Index r = 0; r < kind_.rows(); ++r)
      for (Index c = 0; c < kind_.cols(); ++c)
        if (kind_(r, c) < 0 && std::isfinite(samples_.value()(r, c))) compare(r, c);
    scale();
  }

  double residual(Index r, Index c) const { return residual_(r, c); }
  // Returns NaN without neighbours.
  double standardised(Index r, Index c) const {
    const int kind = kind_(r, c);
    if (kind < 0) return kNaN;
    const std::size_t t = tile(r, c);
    return (residual_(r, c) - (kind == 0 ? tile_centre_[t] : 0.0)) /
           (deviation_[std::size_t(kind)] * tile_factor_[t]);
  }

  // Returns true if a sample continues the surface on one of its sides.
  bool continues_a_side(Index r, Index c) const {
    const double residual = residual_(r, c), sign = residual > 0 ? 1 : -1;
    int there = 0, agree = 0;
    const std::size_t arms = samples_.profile() ? 1 : arms_.size();
    for (std::size_t k = 0; k < arms; ++k)
      for (const Index side : {-1, 1}) {
        const double line = samples_.along(r, c, {side * arms_[k].row, side * arms_[k].column}, 2);
        if (!std::isfinite(line)) continue;
        ++there;
        if (sign * (samples_.value()(r, c) - line) < 0.5 * std::abs(residual)) ++agree;
      }
    // A scratch continues in two of eight directions, the corner of a plateau in three.
    return agree > there / 4;
  }

 private:
  void compare(Index r, Index c) {
    const double value = samples_.value()(r, c);
    const Prediction predicted = std::isfinite(value) ? predict(r, c) : Prediction();
    residual_(r, c) = predicted.kind < 0 ? kNaN : value - predicted.value;
    kind_(r, c) = std::int8_t(predicted.kind);
    changed_[tile(r, c)] = true;
  }

  std::size_t tile(Index r, Index c) const {
    return first_of_row_[std::size_t(r)] + tile_of_column_[std::size_t(c)];
  }

  double by_kind(Index r, Index c, int kind) const {
    const int arms = int(arms_.size());
    if (kind <= arms) return samples_.along(r, c, arms_[std::size_t(kind - 1)], -1);
    const Arm arm = arms_[std::size_t(kind - 1 - arms)];
    const double line = samples_.along(r, c, arm, 2);
    return std::isfinite(line) ? line : samples_.along(r, c, {-arm.row, -arm.column}, 2);
  }

  Prediction predict(Index r, Index c) const {
    std::array<double, 4> pair{};
    int first = -1;
    std::size_t count = 0;
    for (std::size_t k = 0; k < arms_.size(); ++k) {
      const double value = samples_.along(r, c, arms_[k], -1);
      if (!std::isfinite(value)) continue;
      if (first < 0) first = int(k);
      pair[count++] = value;
    }
    if (count == arms_.size()) {
      const auto [low, high] = std::minmax(pair[0], pair[1]);
      if (count == 3) return {std::max(low, std::min(high, pair[2])), 0};
      return {0.5 * (std::max(low, std::min(pair[2], pair[3])) + std::min(high, std::max(pair[2], pair[3]))),
              0};
    }
    if (count > 0) return {pair[0], 1 + first};
    for (int kind = 1 + int(arms_.size()); continued_ && kind <= 2 * int(arms_.size()); ++kind)
      if (const double value = by_kind(r, c, kind); std::isfinite(value)) return {value, kind};
    return {};
  }

  // Updates the standard deviations; those of tiles only where a sample has changed.
  void scale() {
    rounding_ = samples_.rounding();
    std::vector<std::vector<double>> in_tile(changed_.size());
    for (Index r = 0; r < residual_.rows(); ++r)
      for (Index c = 0; c < residual_.cols(); ++c)
        if (kind_(r, c) == 0 && changed_[tile(r, c)]) in_tile[tile(r, c)].push_back(residual_(r, c));
    for (std::size_t t = 0; t < in_tile.size(); ++t) {
      if (!changed_[t]) continue;
      const bool enough = Index(in_tile[t].size()) >= kFewestInTile;
      tile_centre_[t] = enough ? median_of(&in_tile[t]) : 0;
      tile_deviation_[t] = enough ? deviation_about(tile_centre_[t], std::move(in_tile[t])) : 0;
      changed_[t] = false;
    }
    std::vector<double> all;
    all.reserve(std::size_t(residual_.size()));
    for (Index r = 0; r < residual_.rows(); ++r)
      for (Index c = 0; c < residual_.cols(); ++c)
        if (kind_(r, c) == 0) all.push_back(std::abs(residual_(r, c) - tile_centre_[tile(r, c)]));
    deviation_.assign(1 + 2 * arms_.size(), kInfinity);
    if (Index(all.size()) < kFewestTested) return;
    const double whole = std::max(kDeviationsOfMedian * median_of(&all), rounding_);
    for (std::size_t t = 0; t < tile_factor_.size(); ++t)
      tile_factor_[t] = std::max(1.0, tile_deviation_[t] / whole);
    deviation_[0] = whole;
    for (int kind = 1; kind < int(deviation_.size()); ++kind)
      if ((kind_ == std::int8_t(kind)).any()) deviation_[std::size_t(kind)] = deviation_of(kind);
  }

  // Standard deviation of a prediction used at the rim only, estimated from samples everywhere.
  double deviation_of(int kind) const {
    constexpr Index kEnough = 20000;
    const Index step = std::max<Index>(1, residual_.size() / kEnough) | 1;
    std::vector<double> values;
    for (Index i = 0; i < residual_.size(); i += step) {
      const Index r = i / residual_.cols(), c = i % residual_.cols();
      const double value = samples_.at(r, c) - by_kind(r, c, kind);
      if (std::isfinite(value)) values.push_back(value);
    }
    if (Index(values.size()) < kFewestTested) return kInfinity;
    const double centre = median_of(&values);
    return std::max(deviation_about(centre, std::move(values)), rounding_);
  }

  const Samples& samples_;
  bool continued_ = false;
  double rounding_ = 0;
  std::vector<Arm> arms_;
  Grid residual_;
  Eigen::Array<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> kind_;
  Index tiles_down_, tiles_across_;
  std::vector<std::size_t> first_of_row_, tile_of_column_;
  std::vector<double> deviation_;                     // by kind
  std::vector<double> tile_centre_, tile_deviation_;  // for kind 0; deviation 0 if a tile has too few samples
  std::vector<double> tile_factor_;                   // for all kinds
  std::vector<bool> changed_;                         // tiles changed since the last scale()
};

std::vector<Index> distances(const Samples& samples) {
  std::vector<Index> list;
  const Index rows = samples.value().rows(), columns = samples.value().cols();
  if (samples.profile())
    for (Index d = 1; d <= 16 && 24 * d < columns; d *= 2) list.push_back(d);
  else
    for (Index d = 1; d <= 8 && 8 * d < std::min(rows, columns); d *= 2) list.push_back(d);
  return list;
}

double threshold(const Samples& samples, Index tested, Index distance, std::size_t looks) {
  const double area = double(distance) * (samples.profile() ? 1 : double(distance));
  const double freedom = kEfficiencyOfMedian * double(tested) / (2 * area);
  const double tail = kFalseAlarms / (2 * double(tested) * double(looks));
  return quantile(complement(boost::math::students_t(freedom), tail));
}

constexpr std::array<Arm, 8> kWays = {{{0, 1}, {0, -1}, {1, 0}, {-1, 0}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

bool marked(const Mask& mask, Index r, Index c) {
  return r >= 0 && c >= 0 && r < mask.rows() && c < mask.cols() && mask(r, c);
}

// Returns the residuals of samples that stand out, at the distance where they do most; 0 elsewhere.
Grid candidates(const std::vector<Residuals>& at, const Mask& found, const std::vector<double>& limit) {
  Grid stands_out = Grid::Zero(found.rows(), found.cols()), most = stands_out;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Residuals& residuals = at[i];
    for (Index r = 0; r < found.rows(); ++r)
      for (Index c = 0; c < found.cols(); ++c) {
        const double size = std::abs(residuals.standardised(r, c));
        if (!(size > kBesideOthers) || size / limit[i] <= most(r, c)) continue;
        bool beyond = size > limit[i];
        for (const Arm& way : kWays) beyond = beyond || marked(found, r + way.row, c + way.column);
        if (!beyond || residuals.continues_a_side(r, c)) continue;
        most(r, c) = size / limit[i];
        stands_out(r, c) = residuals.residual(r, c);
      }
  }
  return stands_out;
}

// Keeps the regions that end at an edge: their samples continue the outside neither as a line nor as a bend.
Mask with_edges(const Samples& samples, const Grid& stands_out) {
  const Grid& value = samples.value();
  Mask kept = Mask::Constant(value.rows(), value.cols(), false);
  Mask seen = Mask::Constant(value.rows(), value.cols(), false);
  const auto outside = [&](Index r, Index c) {
    const double z = samples.at(r, c);
    return std::isfinite(z) && stands_out(r, c) == 0 ? z : kNaN;
  };
  std::vector<Arm> region;
  std::vector<double> edges, straight_edges;
  for (Index i = 0; i < value.size(); ++i) {
    if (stands_out.data()[i] == 0 || seen.data()[i]) continue;
    region = {{i / value.cols(), i % value.cols()}};
    seen.data()[i] = true;
    edges.clear(), straight_edges.clear();
    for (std::size_t k = 0; k < region.size(); ++k) {
      const auto [r, c] = region[k];
      for (const auto& [row, column] : kWays) {
        const double a = outside(r + row, c + column), b = outside(r + 2 * row, c + 2 * column),
                     d = outside(r + 3 * row, c + 3 * column);
        const double straight = std::abs(value(r, c) - 2 * a + b),
                     bent = std::abs(value(r, c) - 3 * a + 3 * b - d);
        if (std::isfinite(bent)) {
          edges.push_back(std::min(straight, bent) / std::abs(stands_out(r, c)));
          straight_edges.push_back(straight / std::abs(stands_out(r, c)));
        }
        if (!std::isfinite(samples.at(r + row, c + column)) || stands_out(r + row, c + column) == 0 ||
            seen(r + row, c + column))
          continue;
        seen(r + row, c + column) = true;
        region.push_back({r + row, c + column});
      }
    }
    if (region.size() == 1) edges = straight_edges;  // a bend is wider than one sample
    if (edges.empty() || median_of(&edges) > (samples.profile() ? kSharpOnAProfile : kSharp))
      for (const auto& [r, c] : region) kept(r, c) = true;
  }
  return kept;
}

Index most_passes(const Samples& samples) {
  return std::clamp(kMostVisits / std::max<Index>(1, samples.value().size()), kFewestPasses, kMostPasses);
}

Outliers search(Samples samples) {
  Outliers result;
  const Grid& value = samples.value();
  result.found = Mask::Constant(value.rows(), value.cols(), false);
  result.tested = value.isFinite().count();
  const std::vector<Index> at = distances(samples);
  if (result.tested < kFewestTested || at.empty()) return result;
  std::vector<double> limit;
  for (const Index d : at) limit.push_back(threshold(samples, result.tested, d, at.size()));
  result.threshold = limit.front();
  // Samples at the rim are predicted from samples inside, which must be clean first.
  std::vector<Residuals> residuals;
  for (const Index d : at) residuals.emplace_back(samples, d);
  for (const bool continued : {false, true}) {
    if (continued)
      for (Residuals& each : residuals) each.continue_lines();
    for (Index pass = 0; pass < most_passes(samples); ++pass) {
      const Mask fresh = with_edges(samples, candidates(residuals, result.found, limit));
      if (!fresh.any()) break;
      result.found = result.found || fresh;
      samples.take_out(fresh);
      for (Residuals& each : residuals) each.without(fresh);
    }
  }
  result.count = result.found.count();
  return result;
}

}  // namespace

Outliers find_outliers(const Profile& profile) { return search(Samples(profile)); }
Outliers find_outliers(const HeightMap& map) { return search(Samples(map)); }

}  // namespace aberfit
