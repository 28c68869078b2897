#include "line_spread.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "aberfit/core/root.h"

namespace aberfit::internal {
namespace {

// The smoothed profile is a sum of one Gaussian per ray and is needed at some hundred points. We collect rays
// in cells once. With t the distance of a ray and u that of a point from the centre of the cell, in
// bandwidths,
//   exp(-(u - t)^2/2) = exp(-u^2/2) sum_k He_k(u) t^k / k!
// (generating function of the Hermite polynomials He_k, He_{k+1} = u He_k - k He_{k-1}). Since |He_k
// exp(-u^2/2)| < 1.1 sqrt(k!), terms from kTerms on are below 1e-18 of a ray's weight, and 5e-18 in a slope.
constexpr double kCell = 0.25;      // width of a cell [bandwidths]
constexpr std::size_t kTerms = 14;  // even, because powers are made in pairs
constexpr double kReach = 8.5;      // exp(-u^2/2) is below 2e-16 there
constexpr int kNear = int(kReach / kCell) + 1;
constexpr double kWidestLine = 16384;  // half length of the line [bandwidths]; 30 MB of cells
// Points of the scan per cell, and terms of the series for them. The error is 4e-10 of a ray's weight.
constexpr int kPoints = 4;
constexpr std::size_t kScanTerms = 8;
// Largest relative difference between the highest point of the scan and the peak beside it. The second
// derivative is at least minus the profile over bandwidth^2.
constexpr double kLowerThanPeak = 0.5 * (0.5 * kCell / kPoints) * (0.5 * kCell / kPoints);

/// Profile (unnormalised Gaussian kernel) and its derivative.
struct Value {
  double profile = 0, slope = 0;
};

// He_k(u) exp(-u^2/2) for k = 0 ... size - 1.
template <std::size_t size>
std::array<double, size> hermite_functions(double u) {
  std::array<double, size> h;
  h[0] = std::exp(-0.5 * u * u);
  h[1] = u * h[0];
  for (std::size_t k = 2; k < size; ++k) h[k] = u * h[k - 1] - double(k - 1) * h[k - 2];
  return h;
}

class LineSpread {
 public:
  /// Takes the rays within `reach` of `mean`.
  LineSpread(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight, double mean, double reach,
             double bandwidth)
      : position_(position),
        weight_(weight),
        bandwidth_(bandwidth),
        cells_(2 * int(std::ceil(reach / (kCell * bandwidth)))),
        first_(mean - 0.5 * kCell * bandwidth * (cells_ - 1)),
        moments_(std::size_t(cells_), Moments{}) {
    for (Eigen::Index i = 0; i < position_.size(); ++i) {
      const Place at = place(position_[i]);
      if (at.cell < 0) continue;
      Moments& moments = moments_[std::size_t(at.cell)];
      double even = weight_[i], odd = weight_[i] * at.t;
      const double t2 = at.t * at.t;
      for (std::size_t k = 0; k < kTerms; k += 2) {
        moments[k] += even;
        moments[k + 1] += odd;
        even *= t2;
        odd *= t2;
      }
    }
    double factorial = 1;
    for (std::size_t k = 2; k < kTerms; ++k) {
      factorial *= double(k);
      for (Moments& moments : moments_) moments[k] /= factorial;
    }
  }

  Value operator()(double x) const {
    Value value;
    for_cells_near(x, [&](std::size_t cell, double u) {
      const auto h = hermite_functions<kTerms + 1>(u);
      for (std::size_t k = 0; k < kTerms; ++k) {
        value.profile += h[k] * moments_[cell][k];
        value.slope -= h[k + 1] * moments_[cell][k];
      }
    });
    value.slope /= bandwidth_;
    return value;
  }

  double pitch() const { return kCell * bandwidth_ / kPoints; }
  double scan_point(std::size_t k) const {
    return first_ + pitch() * (double(k) - 0.5 * (kPoints - 1) - kPoints * kNear);
  }
  /// The profile at scan_point(0), scan_point(1), ..., over all cells within kReach of a ray.
  std::vector<double> scan() const {
    std::vector<std::array<double, kScanTerms>> from;
    for (int j = 0; j < kPoints * (2 * kNear + 1); ++j)
      from.push_back(hermite_functions<kScanTerms>(kCell * ((j - 0.5 * (kPoints - 1)) / kPoints - kNear)));
    std::vector<double> profile(std::size_t(kPoints) * (std::size_t(cells_) + 2 * kNear), 0.0);
    for (std::size_t cell = 0; cell < moments_.size(); ++cell) {
      if (!(moments_[cell][0] > 0)) continue;
      for (std::size_t j = 0; j < from.size(); ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < kScanTerms; ++k) sum += from[j][k] * moments_[cell][k];
        profile[kPoints * cell + j] += sum;
      }
    }
    return profile;
  }

  struct Pull {
    double x, scale;
  };
  /// Adds the sum over `pulls` of scale d profile(x) / d position to every ray.
  void gradient(const std::array<Pull, 3>& pulls, std::vector<double>* result) const {
    std::vector<Moments> factors(moments_.size(), Moments{});
    for (const Pull& pull : pulls)
      for_cells_near(pull.x, [&](std::size_t cell, double u) {
        const auto h = hermite_functions<kTerms + 1>(u);
        double factor = pull.scale / bandwidth_;
        for (std::size_t k = 0; k < kTerms; ++k) {
          factors[cell][k] += factor * h[k + 1];
          factor /= double(k + 1);
        }
      });
    result->assign(std::size_t(position_.size()), 0.0);
    for (Eigen::Index i = 0; i < position_.size(); ++i) {
      const Place at = place(position_[i]);
      if (at.cell < 0) continue;
      const Moments& factor = factors[std::size_t(at.cell)];
      const double t2 = at.t * at.t;
      double even = factor[kTerms - 2], odd = factor[kTerms - 1];
      for (std::size_t k = kTerms - 2; k > 0; k -= 2) {
        even = even * t2 + factor[k - 2];
        odd = odd * t2 + factor[k - 1];
      }
      (*result)[std::size_t(i)] = weight_[i] * (even + at.t * odd);
    }
  }

 private:
  using Moments = std::array<double, kTerms>;

  struct Place {
    int cell;  // -1 outside
    double t;  // distance from the centre of the cell [bandwidths]
  };
  Place place(double position) const {
    const double cell = std::floor((position - first_) / (kCell * bandwidth_) + 0.5);
    if (!(cell >= 0 && cell < cells_)) return {-1, 0};
    return {int(cell), (position - middle(int(cell))) / bandwidth_};
  }
  double middle(int cell) const { return first_ + kCell * bandwidth_ * cell; }

  template <typename Use>
  void for_cells_near(double x, const Use& use) const {
    const double nearest = std::round((x - first_) / (kCell * bandwidth_));
    const int from = int(std::max(0.0, nearest - kNear)), to = int(std::min(cells_ - 1.0, nearest + kNear));
    for (int cell = from; cell <= to; ++cell)
      if (moments_[std::size_t(cell)][0] > 0) use(std::size_t(cell), (x - middle(cell)) / bandwidth_);
  }

  const Eigen::ArrayXd& position_;
  const Eigen::ArrayXd& weight_;
  double bandwidth_;
  int cells_;
  double first_;                  // centre of the first cell
  std::vector<Moments> moments_;  // sum of weight t^k / k!
};

}  // namespace

std::optional<double> line_spread_fwhm(const Eigen::ArrayXd& position, const Eigen::ArrayXd& weight,
                                       double bandwidth, double scale, std::vector<double>* d_position) {
  const double total = weight.sum();
  if (!(bandwidth > 0) || !(total > 0)) return std::nullopt;
  const double mean = (weight * position).sum() / total;
  const double sigma = std::sqrt((weight * (position - mean).square()).sum() / total);
  // At most 1/64 of the energy is farther than 8 sigma from its mean (Chebyshev).
  const double reach = std::min((position - mean).abs().maxCoeff(), 8.0 * sigma) + kCell * bandwidth;
  if (!(reach < kWidestLine * bandwidth)) return std::nullopt;
  const LineSpread spread(position, weight, mean, reach, bandwidth);
  const std::vector<double> profile = spread.scan();
  const double pitch = spread.pitch(), first = spread.scan_point(0) - pitch;
  // Roots are measured from the start of the line, so they are exact to rounding of its length.
  const auto root = [&](double a, double b, const auto& f) {
    const auto from_first = [&](double distance) { return f(first + distance); };
    return first + root_between(from_first, a - first, b - first, f(a), f(b));
  };

  double peak = mean, top = 0;
  std::size_t highest = 0;
  const double least = *std::max_element(profile.begin(), profile.end()) * (1 - 2 * kLowerThanPeak);
  for (std::size_t k = 1; k + 1 < profile.size(); ++k) {
    if (profile[k] < least || profile[k] < profile[k - 1] || profile[k] < profile[k + 1]) continue;
    const auto slope = [&](double x) { return spread(x).slope; };
    double x = spread.scan_point(k);
    if (slope(x - pitch) > 0 && slope(x + pitch) < 0) x = root(x - pitch, x + pitch, slope);
    if (const double height = spread(x).profile; height > top) peak = x, top = height, highest = k;
  }

  // We take the outermost crossings, because a profile with several peaks may fall below half between them.
  const auto crossing = [&](bool up) {
    std::size_t k = up ? profile.size() - 1 : 0;
    while (k != highest && profile[k] < 0.5 * top) up ? --k : ++k;
    const double inside = k == highest ? peak : spread.scan_point(k);
    const double outside = spread.scan_point(k) + (up ? pitch : -pitch);
    const auto above_half = [&](double x) { return spread(x).profile - 0.5 * top; };
    if (above_half(inside) <= 0) return inside;  // the difference is below the error of the scan
    if (above_half(outside) >= 0) return outside;
    return root(inside, outside, above_half);
  };
  const double lower = crossing(false), upper = crossing(true);
  if (d_position) {
    const double for_upper = -scale / spread(upper).slope, for_lower = scale / spread(lower).slope;
    spread.gradient({{{upper, for_upper}, {lower, for_lower}, {peak, -0.5 * (for_upper + for_lower)}}},
                    d_position);
  }
  return upper - lower;
}

}  // namespace aberfit::internal
