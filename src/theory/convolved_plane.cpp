#include <algorithm>
#include <array>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/theory/aperture_otf.h"
#include "aberfit/theory/convolved_focus.h"
#include "pattern_table.h"

namespace aberfit {

struct AperturePattern::Shared {
  ApertureOtf otf;
  double focal_length, wavelength;
  std::mutex mutex;
  std::vector<std::shared_ptr<const PatternTable>> tables;  // by size class

  double per_metre(double dz) const {
    return 2 * std::numbers::pi * otf.cutoff() / (wavelength * (focal_length + dz));
  }
  // By size alone, not by what was asked for before: same bits for the same rays.
  std::shared_ptr<const PatternTable> table(double u) {
    const std::size_t size = std::size_t(pattern_table_class(u));
    const std::lock_guard lock(mutex);
    if (tables.size() <= size) tables.resize(size + 1);
    if (!tables[size])
      tables[size] = std::make_shared<const PatternTable>(otf, pattern_table_longest(int(size)));
    return tables[size];
  }
};

AperturePattern::AperturePattern(const Aperture& aperture, double focal_length, double wavelength) {
  if (!(focal_length > 0) || !(wavelength > 0))
    throw ComputationError("a diffraction pattern needs a focal length and a wavelength above zero");
  shared_ = std::shared_ptr<Shared>(new Shared{ApertureOtf(aperture), focal_length, wavelength, {}, {}});
}

bool AperturePattern::has_plane(double dz) const {
  return std::isfinite(dz) && shared_->focal_length + dz > 0;
}

double AperturePattern::share(double radius, double distance, double dz) const {
  if (!(radius >= 0) || !(distance >= 0) || !has_plane(dz)) return std::numeric_limits<double>::quiet_NaN();
  const double scale = shared_->per_metre(dz);
  const PatternRule rule(shared_->otf, scale * (radius + distance));
  const double u = scale * distance;
  const Eigen::ArrayXd j0 = rule.s.unaryExpr([u](double s) { return boost::math::cyl_bessel_j(0, u * s); });
  return (rule.weight * rule.disc(scale * radius) * j0).sum();
}

namespace {

// Where u lies among the intervals.
struct Place {
  Eigen::Index interval;
  double t;  // from the interval's middle, in steps
};
Place place(double u) {
  const double x = u / PatternTable::kStep;
  const auto interval = Eigen::Index(x);
  return {interval, x - double(interval) - 0.5};
}

constexpr int kCoefficients = PatternTable::kDegree + 1;
constexpr int kBefore = PatternTable::kDegree / 2;  // nodes of a stencil before its interval

// Nodes below 0 mirror those above.
Eigen::Index node_of(Eigen::Index interval, int i) { return std::abs(interval - kBefore + i); }

}  // namespace

ConvolvedPlane::ConvolvedPlane(const AperturePattern& pattern, const RayBundle& rays, double dz)
    : shared_(*pattern.shared_), rays_(rays), dz_(dz), per_metre_(shared_.per_metre(dz)) {
  if (!pattern.has_plane(dz)) throw std::invalid_argument("the plane lies behind the mirror");
  const Eigen::ArrayXd u =
      per_metre_ * ((rays.x + dz * rays.tx).square() + (rays.y + dz * rays.ty).square()).sqrt();
  double longest = 0;
  for (Eigen::Index i = 0; i < u.size(); ++i)
    if (rays.weight[i] > 0) longest = std::max(longest, u[i]);
  table_ = pattern.shared_->table(longest);
  const PatternTable& table = *table_;
  // Sums of w t^k in every interval, then the stencils' transpose: weights at the nodes.
  Eigen::Matrix<double, kCoefficients, Eigen::Dynamic> sums(kCoefficients, table.intervals());
  sums.setZero();
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double w = rays.weight[i];
    if (!(w > 0)) continue;
    total_ += w;
    if (!(u[i] < table.longest)) {
      all_near_ = false;
      continue;
    }
    const Place at = place(u[i]);
    double* sum = sums.data() + at.interval * kCoefficients;
    double power = w;
    for (int k = 0; k < kCoefficients; ++k, power *= at.t) sum[k] += power;
  }
  const Eigen::Matrix<double, kCoefficients, Eigen::Dynamic> parts =
      PatternTable::stencil().transpose() * sums;
  Eigen::VectorXd nodes = Eigen::VectorXd::Zero(table.bessel.cols());
  for (Eigen::Index interval = 0; interval < parts.cols(); ++interval)
    for (int i = 0; i < kCoefficients; ++i) nodes[node_of(interval, i)] += parts(i, interval);
  weighted_ = table.rule.weight * (table.bessel * nodes).array() / total_;
}

double ConvolvedPlane::largest_radius() const {
  return (all_near_ ? table_->largest_v : 2 * table_->longest / 3) / per_metre_;
}

double ConvolvedPlane::energy(double radius) const {
  return (weighted_ * table_->rule.disc(radius * per_metre_)).sum();
}

double ConvolvedPlane::density(double radius) const {
  return per_metre_ * (weighted_ * table_->rule.disc_slope(radius * per_metre_)).sum();
}

std::optional<double> ConvolvedPlane::radius(double fraction) const {
  if (!(fraction > 0 && fraction < 1) || !(total_ > 0)) return std::nullopt;
  // Energy grows with the radius, so the first crossing is the only one.
  double low = 0, f_low = -fraction, high = 1 / per_metre_, f_high = energy(high) - fraction;
  while (f_high < 0) {
    if (high >= largest_radius()) return std::nullopt;
    low = high;
    f_low = f_high;
    high = std::min(2 * high, largest_radius());
    f_high = energy(high) - fraction;
  }
  double r = low + (high - low) * (-f_low) / (f_high - f_low);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double f = energy(r) - fraction;
    if (f == 0) return r;
    (f < 0 ? low : high) = r;
    const double slope = density(r);
    double next = slope > 0 ? r - f / slope : low;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - r) <= 4e-15 * r) return next;
    r = next;
  }
  return r;
}

Eigen::ArrayX2d ConvolvedPlane::energy_gradient(double radius) const {
  const PatternTable& table = *table_;
  const Eigen::VectorXd disc = (table.rule.weight * table.rule.disc(radius * per_metre_)).matrix();
  const Eigen::VectorXd nodes = table.bessel.transpose() * disc;
  // Polynomial of K in every interval.
  Eigen::Matrix<double, kCoefficients, Eigen::Dynamic> parts(kCoefficients, table.intervals());
  for (Eigen::Index interval = 0; interval < parts.cols(); ++interval)
    for (int i = 0; i < kCoefficients; ++i) parts(i, interval) = nodes[node_of(interval, i)];
  const Eigen::Matrix<double, kCoefficients, Eigen::Dynamic> polynomials = PatternTable::stencil() * parts;
  Eigen::ArrayX2d gradient = Eigen::ArrayX2d::Zero(rays_.size(), 2);
  const double scale = per_metre_ / (PatternTable::kStep * total_);
  for (Eigen::Index i = 0; i < rays_.size(); ++i) {
    if (!(rays_.weight[i] > 0)) continue;
    const double x = rays_.x[i] + dz_ * rays_.tx[i], y = rays_.y[i] + dz_ * rays_.ty[i];
    const double r = std::sqrt(x * x + y * y), u = per_metre_ * r;
    if (!(u < table.longest) || r == 0) continue;
    const Place at = place(u);
    const double* c = polynomials.data() + at.interval * kCoefficients;
    double slope = 0;
    for (int k = kCoefficients - 1; k > 0; --k) slope = slope * at.t + k * c[k];
    slope *= scale * rays_.weight[i] / r;
    gradient(i, 0) = slope * x;
    gradient(i, 1) = slope * y;
  }
  return gradient;
}

double ConvolvedPlane::energy_slope(double radius, const Eigen::ArrayX2d& energy_gradient) const {
  double moved = 0, grown = density(radius) * radius;
  for (Eigen::Index i = 0; i < rays_.size(); ++i) {
    const double gx = energy_gradient(i, 0), gy = energy_gradient(i, 1);
    if (gx == 0 && gy == 0) continue;
    moved += gx * rays_.tx[i] + gy * rays_.ty[i];
    grown += gx * (rays_.x[i] + dz_ * rays_.tx[i]) + gy * (rays_.y[i] + dz_ * rays_.ty[i]);
  }
  return moved - grown / (shared_.focal_length + dz_);
}

}  // namespace aberfit
