#include "independent_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAtRim = 0.2;  // of n^2: Zernikes turn within R/n^2 there

// Sum of weight_k R_(m+2k)^m, R_n^m = rho^m P_k^(0,m)(2 rho^2 - 1), by the three-term recurrence of Jacobi
// polynomials (Abramowitz and Stegun 22.7.1 with alpha = 0, beta = m).
void add_radial(int m, double rho, const std::vector<double>& cosine, const std::vector<double>& sine,
                double* of_cosine, double* of_sine) {
  const double x = 2 * rho * rho - 1, b = m;
  double before = 0, now = 1;
  *of_cosine = cosine[0], *of_sine = sine[0];
  for (std::size_t j = 1; j < cosine.size(); ++j) {
    const double k = double(j) - 1, s = 2 * k + b;
    const double next =
        j == 1 ? 0.5 * (2 + b) * (x - 1) + 1
               : ((s + 1) * ((s + 2) * s * x - b * b) * now - 2 * k * (k + b) * (s + 2) * before) /
                     (2 * (k + 1) * (k + 1 + b) * s);
    before = now;
    now = next;
    *of_cosine += cosine[j] * now;
    *of_sine += sine[j] * now;
  }
  const double outer = std::pow(rho, m);
  *of_cosine *= outer;
  *of_sine *= outer;
}

// Conic sag less rho^2/(4f), c rho^2/(1 + q) - c rho^2/2 with q^2 = 1 - (1 + K) c^2 rho^2, and the even
// powers.
double departure(const Mirror& mirror, double rho2) {
  const double c = 1 / (2 * mirror.focal_length), inside = (1 + mirror.conic) * c * c * rho2;
  const double q = std::sqrt(1 - inside);
  double sum = 0.5 * c * rho2 * inside / ((1 + q) * (1 + q)), power = rho2;
  for (const double even : mirror.spherical) sum += even * (power *= rho2);
  return sum;
}

}  // namespace

void IndependentSurface::Zernikes::add(const ZernikeMode& mode, double value) {
  const int m = std::abs(mode.m);
  auto order = std::find_if(orders.begin(), orders.end(), [m](const Order& o) { return o.m == m; });
  if (order == orders.end()) order = orders.insert(orders.end(), Order{m, {}, {}});
  const auto k = std::size_t((mode.n - m) / 2);
  if (order->cosine.size() <= k) order->cosine.resize(k + 1), order->sine.resize(k + 1);
  const double norm = std::sqrt((m == 0 ? 1.0 : 2.0) * (mode.n + 1));
  (mode.m >= 0 ? order->cosine : order->sine)[k] += norm * value;
}

double IndependentSurface::Zernikes::height(double x, double y) const {
  if (orders.empty()) return 0;
  const double rho = std::hypot(x, y) / radius, angle = std::atan2(y, x);
  double sum = 0;
  for (const Order& order : orders) {
    double cosine, sine;
    add_radial(order.m, rho, order.cosine, order.sine, &cosine, &sine);
    sum += cosine * std::cos(order.m * angle) + sine * std::sin(order.m * angle);
  }
  return sum;
}

double IndependentSurface::step(double x, double y) const {
  for (const Step& step : steps_) {
    if (std::pow(x - step.x, 2) + std::pow(y - step.y, 2) > step.reach2) continue;
    bool inside = false;  // by the edges to the right of the point
    for (std::size_t i = 0, j = step.outline.size() - 1; i < step.outline.size(); j = i++) {
      const auto &a = step.outline[i], &b = step.outline[j];
      if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])) inside = !inside;
    }
    if (inside) return step.piston + step.slope_x * (x - step.x) + step.slope_y * (y - step.y);
  }
  return 0;
}

IndependentSurface::IndependentSurface(const Mirror& mirror, const TermSet& terms,
                                       const Eigen::VectorXd& coefficients)
    : mirror_(mirror), radius_(terms.radius) {
  terms_.radius = terms.radius;
  known_.radius = mirror.zernike_radius;
  double finest = 3;  // radians over the radius: of the conic
  Eigen::Index j = 0;
  for (const ZernikeMode& mode : terms.zernike) {
    terms_.add(mode, coefficients[j++]);
    finest = std::max(finest, kAtRim * mode.n * mode.n);
  }
  for (const FourierMode& mode : terms.fourier) {
    waves_.push_back({mode.fx, mode.fy, coefficients[j], coefficients[j + 1]});
    finest = std::max(finest, 2 * kPi * std::hypot(mode.fx, mode.fy) * radius_);
    j += 2;
  }
  for (const int power : terms.spherical) powers_.push_back({power, coefficients[j++]});
  if (terms.segments)
    for (const Segments::Segment& segment : terms.segments->all()) {
      // The segments are regular, so the mean of the corners is the middle.
      Step step{segment.clear.front(), 0, 0, 0, 0, 0, 0};
      const auto corners = double(step.outline.size());
      for (const auto& [x, y] : step.outline) step.x += x / corners, step.y += y / corners;
      for (const auto& [x, y] : step.outline)
        step.reach2 = std::max(step.reach2, std::pow(x - step.x, 2) + std::pow(y - step.y, 2));
      if (terms.segments->piston() > 0) step.piston = coefficients[j++];
      if (terms.segments->tip_tilt() > 0) {
        step.slope_x = coefficients[j++] / std::sqrt(step.reach2);
        step.slope_y = coefficients[j++] / std::sqrt(step.reach2);
      }
      steps_.push_back(std::move(step));
    }
  for (const KnownZernike& term : mirror.zernike) {
    known_.add(term.mode, term.height);
    finest = std::max(finest, kAtRim * term.mode.n * term.mode.n);
  }
  // The differences have a relative error of (step finest)^4/30.
  step_ = 0.02 / finest * radius_;
  cost_ = double(terms.zernike.size()) / 2 + 2 * double(waves_.size()) + double(known_.orders.size()) + 4;
}

double IndependentSurface::height(double x, double y) const {
  double sum = terms_.height(x, y) + known_.height(x, y);
  for (const Wave& wave : waves_) {
    const double turn = 2 * kPi * (wave.fx * x + wave.fy * y);
    sum += wave.cosine * std::cos(turn) + wave.sine * std::sin(turn);
  }
  for (const Power& term : powers_) sum += term.value * std::pow(std::hypot(x, y) / radius_, term.power);
  return sum + departure(mirror_, x * x + y * y);
}

std::array<double, 2> IndependentSurface::slopes(double x, double y) const {
  const double h = step_;
  return {
      (8 * (height(x + h, y) - height(x - h, y)) - (height(x + 2 * h, y) - height(x - 2 * h, y))) / (12 * h),
      (8 * (height(x, y + h) - height(x, y - h)) - (height(x, y + 2 * h) - height(x, y - 2 * h))) / (12 * h)};
}

}  // namespace aberfit
