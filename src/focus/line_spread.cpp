#include "line_spread.h"

#include <cmath>

namespace aberfit::internal {
namespace {

// Smoothed profile (unnormalised Gaussian kernel) and its first two derivatives.
struct Value {
  double profile = 0, slope = 0, curvature = 0;
};

class LineSpread {
 public:
  LineSpread(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight, double bandwidth)
      : position_(position), weight_(weight), bandwidth_(bandwidth) {}

  Value operator()(double x) const {
    Value value;
    for (Eigen::Index i = 0; i < position_.size(); ++i) {
      const double u = (x - position_[i]) / bandwidth_;
      if (std::abs(u) > kReach) continue;
      const double kernel = weight_[i] * std::exp(-0.5 * u * u);
      value.profile += kernel;
      value.slope -= u * kernel;
      value.curvature += (u * u - 1.0) * kernel;
    }
    value.slope /= bandwidth_;
    value.curvature /= bandwidth_ * bandwidth_;
    return value;
  }

  // d profile(x) / d position of every ray, times scale, added to `gradient`.
  void add_gradient(double x, double scale, std::vector<double>* gradient) const {
    for (Eigen::Index i = 0; i < position_.size(); ++i) {
      const double u = (x - position_[i]) / bandwidth_;
      if (std::abs(u) > kReach) continue;
      (*gradient)[std::size_t(i)] += scale * weight_[i] * u * std::exp(-0.5 * u * u) / bandwidth_;
    }
  }

 private:
  static constexpr double kReach = 8.5;  // exp(-u^2/2) below 2e-16
  const Eigen::ArrayXd& position_;
  const Eigen::ArrayXd& weight_;
  double bandwidth_;
};

}  // namespace

std::optional<double> line_spread_fwhm(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight,
                                       double bandwidth, double scale, std::vector<double>* d_position) {
  const double total = weight.sum();
  if (!(bandwidth > 0) || !(total > 0)) return std::nullopt;
  const double mean = (weight * position).sum() / total;
  const double sigma = std::sqrt((weight * (position - mean).square()).sum() / total);
  const LineSpread spread(position, weight, bandwidth);
  // Coarse look at the profile of the binned rays; the refinement below works on the rays themselves.
  const double reach = 4.0 * sigma + 4.0 * bandwidth;
  const int steps = int(std::min(4000.0, std::ceil(16.0 * reach / bandwidth)));
  const double pitch = 2.0 * reach / steps;
  Eigen::ArrayXd cell_position = Eigen::ArrayXd::LinSpaced(steps + 1, mean - reach, mean + reach);
  Eigen::ArrayXd cell_weight = Eigen::ArrayXd::Zero(steps + 1);
  for (Eigen::Index i = 0; i < position.size(); ++i) {
    const double cell = std::round((position[i] - mean + reach) / pitch);
    if (cell >= 0 && cell <= steps) cell_weight[Eigen::Index(cell)] += weight[i];
  }
  const LineSpread coarse(cell_position, cell_weight, bandwidth);
  std::vector<double> profile(std::size_t(steps) + 1, 0.0);
  std::size_t highest = 0;
  for (std::size_t k = 0; k < profile.size(); ++k) {
    profile[k] = coarse(mean - reach + pitch * double(k)).profile;
    if (profile[k] > profile[highest]) highest = k;
  }
  double peak = mean - reach + pitch * double(highest);
  const double first_peak = peak;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Value value = spread(peak);
    if (!(value.curvature < 0)) break;
    const double step = value.slope / value.curvature;
    if (std::abs(peak - step - first_peak) > pitch) break;
    peak -= step;
    if (std::abs(step) < 1e-14 * reach) break;
  }
  const double top = spread(peak).profile;
  const auto crossing = [&](bool up) -> std::optional<double> {
    // Outermost: a lumpy profile may dip below half between its lumps.
    std::size_t k = up ? profile.size() - 1 : 0;
    while (k != highest && profile[k] < 0.5 * top) up ? --k : ++k;
    double inside = mean - reach + pitch * double(k), outside = inside + (up ? pitch : -pitch);
    if (k == highest) inside = peak;
    for (int iteration = 0; iteration < 200; ++iteration) {
      double x = 0.5 * (inside + outside);
      if (iteration > 3) {  // Newton from a bracket that is already narrow
        const Value value = spread(x);
        const double candidate = x - (value.profile - 0.5 * top) / value.slope;
        if (candidate > std::min(inside, outside) && candidate < std::max(inside, outside)) {
          if (std::abs(candidate - x) < 1e-14 * reach) return candidate;
          (value.profile >= 0.5 * top ? inside : outside) = x;
          x = candidate;
        }
      }
      (spread(x).profile >= 0.5 * top ? inside : outside) = x;
      if (std::abs(inside - outside) < 1e-15 * reach) break;
    }
    return 0.5 * (inside + outside);
  };
  const auto lower = crossing(false), upper = crossing(true);
  if (d_position) {
    const double for_upper = -scale / spread(*upper).slope, for_lower = scale / spread(*lower).slope;
    d_position->assign(std::size_t(position.size()), 0.0);
    spread.add_gradient(*upper, for_upper, d_position);
    spread.add_gradient(*lower, for_lower, d_position);
    spread.add_gradient(peak, -0.5 * (for_upper + for_lower), d_position);
  }
  return *upper - *lower;
}

}  // namespace aberfit::internal
