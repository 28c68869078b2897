#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/constants.h"
#include "aberfit/core/root.h"
#include "aberfit/focus/circles_of_square.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "radial_transform.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kSquareRoot = 1e-12;                   // relative accuracy of a side
constexpr double kStepsOfLight = 4, kStepsOfSpot = 64;  // steps per lambda N and per spot radius
constexpr int kMostSteps = 200'000;
// Structure function of the phase in Kolmogorov turbulence, 2 (24/5 Gamma(6/5))^(5/6), over (x/r0)^(5/3).
constexpr double kStructureOfAir = 6.883877182;

}  // namespace

MeanSpot::Share MeanSpot::share(double v) const {
  const RadialTransform::Disc disc = transform_->disc(v);
  return {disc.share, disc.derivative};
}

double MeanSpot::encircled_energy(double radius) const { return share(radius * v_per_radius_).value; }

double MeanSpot::encircled_energy_slope(double radius) const {
  return share(radius * v_per_radius_).derivative * v_per_radius_;
}

double MeanSpot::encircled_energy_radius(double fraction) const {
  if (!(fraction > 0 && fraction < 1)) return kNaN;
  const double v_max = focal_length_ * v_per_radius_;
  // Over log v: a halo is decades wider than the core. A dark ring has no slope, so Newton's steps stay
  // inside a bracket. If they do not shrink, a regula falsi step (Illinois) follows.
  double low = -kInfinity, high = kInfinity, at_low = 0, at_high = 0, last = kInfinity;
  double u = std::min(std::log(guess_ * v_per_radius_), std::log(v_max));
  if (!std::isfinite(u)) u = 0;
  int side = 0;
  for (int i = 0; i < 200; ++i) {
    const double v = std::exp(u);
    const Share here = share(v);
    const double excess = here.value - fraction;
    const double newton = -excess / (v * here.derivative);
    if (here.derivative > 0 && std::abs(newton) <= 1e-7) return v * (1 + newton) / v_per_radius_;
    const int now = excess < 0 ? -1 : 1;
    (now < 0 ? low : high) = u;
    (now < 0 ? at_low : at_high) = excess;
    if (now == side) (now < 0 ? at_high : at_low) *= 0.5;
    side = now;
    if (low >= std::log(v_max)) return kInfinity;
    if (high - low <= 1e-14) return std::exp(high) / v_per_radius_;
    double next = u + newton;
    const bool bracketed = std::isfinite(low) && std::isfinite(high);
    const bool good = here.derivative > 0 && next > low && next < high && std::abs(newton) <= 0.5 * last;
    last = good ? std::abs(newton) : kInfinity;
    if (bracketed && !good) {
      next = (low * at_high - high * at_low) / (at_high - at_low);
      const double margin = 0.05 * (high - low);
      next = std::clamp(next, low + margin, high - margin);
    } else if (!bracketed) {
      next = std::clamp(here.derivative > 0 ? next : u + 2 * (now < 0 ? 1 : -1), u - 2, u + 2);
      next = std::min(next, std::log(v_max));  // there the result is infinity or the bracket closes
    }
    u = next;
  }
  return std::exp(u) / v_per_radius_;
}

double MeanSpot::irradiance(double radius) const {
  const double v = radius * v_per_radius_, per_area = v_per_radius_ * v_per_radius_ / (2 * kPi);
  // The limit of derivative/v at v = 0.
  if (v == 0) return per_area * (transform_->first_moment());
  return per_area * share(v).derivative / v;
}

// d/dv int s J0(v s) T ds = -int s^2 J1(v s) T ds: the disc integral of s^2 T, over v.
double MeanSpot::irradiance_slope(double radius) const {
  const double v = radius * v_per_radius_, per_area = v_per_radius_ * v_per_radius_ / (2 * kPi);
  if (v == 0) return 0;
  std::vector<TransferPanel> panels = transform_->panels();
  for (TransferPanel& panel : panels) panel.value *= panel.nodes().square();
  return -per_area * v_per_radius_ * RadialTransform(std::move(panels)).disc(v).share / v;
}

double MeanSpot::ensquared_energy(double side) const {
  const Quadrature circles = circles_of_square(side * v_per_radius_);
  double sum = 0;
  for (Eigen::Index k = 0; k < circles.nodes.size(); ++k)
    sum += circles.weights[k] * encircled_energy(circles.nodes[k] * side);
  return sum;
}

double MeanSpot::ensquared_energy_slope(double side) const {
  const Quadrature circles = circles_of_square(side * v_per_radius_);
  double sum = 0;
  for (Eigen::Index k = 0; k < circles.nodes.size(); ++k)
    sum += circles.weights[k] * circles.nodes[k] * encircled_energy_slope(circles.nodes[k] * side);
  return sum;
}

double MeanSpot::ensquared_side(double fraction) const {
  const double radius = encircled_energy_radius(fraction);
  if (!std::isfinite(radius)) return radius;
  // The square lies between its inscribed and its circumscribed circle.
  const double least = std::numbers::sqrt2 * radius, most = 2 * radius;
  const auto excess = [&](double side) { return ensquared_energy(side) - fraction; };
  const double at_least = excess(least), at_most = excess(most);
  if (at_least >= 0) return least;  // only rounding between the two circles
  if (at_most <= 0) return most;
  return root_between(excess, least, most, at_least, at_most, kSquareRoot);
}

double MeanSpot::search_step() const {
  const double axis = irradiance(0), diffraction = 2 * kPi / v_per_radius_;
  const double spot = axis > 0 ? std::min(guess_, 1 / std::sqrt(kPi * axis)) : guess_;
  return std::max(diffraction / kStepsOfLight, spot / kStepsOfSpot);
}

// Radius of the largest irradiance before it first falls to half of it; NaN where it does not.
double MeanSpot::peak_radius() const {
  const double step = search_step();
  double top = irradiance(0), at_top = 0;
  for (int k = 1; k < kMostSteps && k * step < focal_length_; ++k) {
    const double here = irradiance(k * step);
    if (here > top) top = here, at_top = k * step;
    if (here > 0.5 * top) continue;
    return summit_near(at_top, step);
  }
  return kNaN;
}

// Refines the position of a maximum between two steps of a scan.
double MeanSpot::summit_near(double radius, double step) const {
  if (radius == 0) return 0;
  const auto slope = [&](double r) { return irradiance_slope(r); };
  const double before = radius - step, behind = radius + step, rise = slope(before), fall = slope(behind);
  return rise > 0 && fall < 0 ? root_between(slope, before, behind, rise, fall) : radius;
}

// The transfer function ends at the cutoff, so the irradiance falls from a maximum M no faster than M cos(pi
// x/(2 l))^2, with l = lambda N half of a period (Duffin and Schaeffer 1938). So a ring at r holds at least 2
// pi r M l. The search ends where less energy than that is left beyond the radius.
double MeanSpot::highest_radius() const {
  const double ring = kPi / v_per_radius_, step = 2 * ring / kStepsOfLight;
  double top = irradiance(0), at_top = 0;
  for (int k = 1; k < kMostSteps && k * step < focal_length_; ++k) {
    const double r = k * step, here = irradiance(r);
    if (here > top) top = here, at_top = r;
    if (r > ring && 1 - encircled_energy(r - ring) < 2 * kPi * (r - ring) * ring * top) break;
  }
  return summit_near(at_top, step);
}

double MeanSpot::fwhm() const {
  const double peak = peak_radius();
  if (std::isnan(peak)) return kNaN;
  const double half = 0.5 * irradiance(peak);
  return 2 * first_crossing([&](double r) { return irradiance(r) - half; }, peak, half, search_step(),
                            focal_length_);
}

double MeanSpot::transfer(double nu) const {
  const double s = 2 * kPi * nu / v_per_radius_;
  return s < 1 ? transform_->at(s) : 0;
}

double MeanSpot::seen_through_air(const MeanSpot& other, double r0) const {
  const double air = r0 / cutoff_;
  std::vector<double> edges{0, 1};
  for (const MeanSpot* spot : {this, &other})
    for (const TransferPanel& panel : spot->transform_->panels())
      edges.insert(edges.end(), {panel.a, panel.b});
  std::sort(edges.begin(), edges.end());
  // Panels are at most as long as r0, and are halved towards 0, where (x/r0)^(5/3) is no polynomial.
  constexpr double kSmallest = 1e-4, kGone = 8;
  double sum = 0;
  const auto add = [&](double a, double b) {
    const TransferPanel span{a, b};
    const PanelArray s = span.nodes();
    PanelArray one = transform_->on(a, b), two = other.transform_->on(a, b);
    const PanelArray seen = (-kStructureOfAir * (s / air).pow(5.0 / 3)).exp();
    sum += (b - a) * (panel_rule().weight * one * two * seen * s).sum();
  };
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    double a = edges[k];
    const double end = std::min(edges[k + 1], kGone * air);
    while (end - a > 0) {
      double b = end;
      while (b - a > std::min(air, std::max(a, kSmallest * air))) b = a + 0.5 * (b - a);
      add(a, b);
      a = b;
    }
  }
  return sum;
}

}  // namespace aberfit
