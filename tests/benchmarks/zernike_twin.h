#pragma once
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "aberfit/terms/surface_operator.h"

/// L in long double, the reference for errors in these benchmarks. It uses other recurrences than the
/// library, one point at a time. One row compares it with sums in 200 digits.
namespace aberfit::benchmarks {

using Long = long double;

struct LongPoint {
  Long height = 0, slope_x = 0, slope_y = 0;
};

/// sum c_nm Z_n^m and its gradient in disc coordinates, all modes 0..n_max in OSA order (index (n (n + 2) +
/// m) / 2). V_n^m = R_n^|m| exp(i m theta) obeys V_n^m = z V_{n-1}^{m-1} + z* V_{n-1}^{m+1} - V_{n-2}^m with
/// d/dx (V_n^m - V_{n-2}^m) = n (V_{n-1}^{m-1} + V_{n-1}^{m+1}), d/dy the same with i (first - second):
/// Andersen, Optics Express 26 (2018) 18878, in complex form. No division, no angle.
inline LongPoint zernike_sum(int n_max, const Eigen::VectorXd& osa, Long x, Long y) {
  struct Mode {
    Long re = 0, im = 0, re_dx = 0, im_dx = 0, re_dy = 0, im_dy = 0;
  };
  // Rows for orders n, n-1 and n-2, entry m = 0..n; beyond n zero. V_n^{-m} is the conjugate.
  std::vector<std::vector<Mode>> rows(3, std::vector<Mode>(std::size_t(n_max) + 3));
  LongPoint sum;
  for (int n = 0; n <= n_max; ++n) {
    std::vector<Mode>& row = rows[std::size_t(n % 3)];
    const std::vector<Mode>& one = rows[std::size_t((n + 2) % 3)];
    const std::vector<Mode>& two = rows[std::size_t((n + 1) % 3)];
    for (Mode& mode : row) mode = {};
    for (int m = n % 2; m <= n; m += 2) {
      Mode& v = row[std::size_t(m)];
      if (n == 0) {
        v.re = 1;
      } else {
        const Mode& up = one[std::size_t(m) + 1];
        Mode down = one[std::size_t(m == 0 ? 1 : m - 1)];
        if (m == 0) down.im = -down.im;
        const Mode& before = two[std::size_t(m)];
        v.re = x * down.re - y * down.im + x * up.re + y * up.im - before.re;
        v.im = x * down.im + y * down.re + x * up.im - y * up.re - before.im;
        v.re_dx = n * (down.re + up.re) + before.re_dx;
        v.im_dx = n * (down.im + up.im) + before.im_dx;
        v.re_dy = -n * (down.im - up.im) + before.re_dy;
        v.im_dy = n * (down.re - up.re) + before.im_dy;
      }
      const Long norm = std::sqrt(Long(n + 1) * (m == 0 ? 1 : 2));
      const Long a = norm * Long(osa[(n * (n + 2) + m) / 2]);
      const Long b = m == 0 ? 0 : norm * Long(osa[(n * (n + 2) - m) / 2]);
      sum.height += a * v.re + b * v.im;
      sum.slope_x += a * v.re_dx + b * v.im_dx;
      sum.slope_y += a * v.re_dy + b * v.im_dy;
    }
  }
  return sum;
}

/// Height and slopes of `terms` at a point [m]. Zernikes: all of 0..n_max (zernike_modes(0, n_max)), or a
/// tail n_min..n_max of it.
inline LongPoint surface_twin(const TermSet& terms, const Eigen::VectorXd& c, double x, double y) {
  LongPoint sum;
  if (!terms.zernike.empty()) {
    const int n_max = terms.zernike.back().n;
    Eigen::VectorXd osa = Eigen::VectorXd::Zero((n_max + 1) * (n_max + 2) / 2);
    for (std::size_t j = 0; j < terms.zernike.size(); ++j)
      osa[(terms.zernike[j].n * (terms.zernike[j].n + 2) + terms.zernike[j].m) / 2] = c[Eigen::Index(j)];
    sum = zernike_sum(n_max, osa, Long(x) / terms.radius, Long(y) / terms.radius);
    sum.slope_x /= terms.radius, sum.slope_y /= terms.radius;
  }
  const Long two_pi = 2 * std::acos(Long(-1));
  for (std::size_t j = 0; j < terms.fourier.size(); ++j) {
    const Long fx = terms.fourier[j].fx, fy = terms.fourier[j].fy, phase = two_pi * (fx * x + fy * y);
    const Long a = c[terms.fourier_begin() + 2 * Eigen::Index(j)],
               b = c[terms.fourier_begin() + 2 * Eigen::Index(j) + 1];
    const Long cosine = std::cos(phase), sine = std::sin(phase), along = two_pi * (b * cosine - a * sine);
    sum.height += a * cosine + b * sine, sum.slope_x += fx * along, sum.slope_y += fy * along;
  }
  return sum;
}

/// Largest difference between `field` and the reference at about `samples` of the points, relative to the
/// largest height or slope among them, whichever difference is larger. The points nearest to the rim, where
/// recurrences are worst, are always included.
inline double relative_error(const TermSet& terms, const Eigen::VectorXd& c, const Eigen::ArrayXd& x,
                             const Eigen::ArrayXd& y, const SurfaceField& field, int samples) {
  std::vector<Eigen::Index> points;
  Eigen::Index outermost = 0;
  (x.square() + y.square()).maxCoeff(&outermost);
  points.push_back(outermost);
  const Eigen::Index step = std::max<Eigen::Index>(1, x.size() / samples);
  for (Eigen::Index i = 0; i < x.size(); i += step) points.push_back(i);
  Long height = 0, slope = 0, height_error = 0, slope_error = 0;
  for (const Eigen::Index i : points) {
    const LongPoint exact = surface_twin(terms, c, x[i], y[i]);
    height = std::max(height, std::abs(exact.height));
    slope = std::max({slope, std::abs(exact.slope_x), std::abs(exact.slope_y)});
    const Long dh = std::abs(exact.height - field.height[i]), dx = std::abs(exact.slope_x - field.slope_x[i]),
               dy = std::abs(exact.slope_y - field.slope_y[i]);
    if (!(dh + dx + dy < 1e300L)) return std::nan("");
    height_error = std::max(height_error, dh);
    slope_error = std::max({slope_error, dx, dy});
  }
  return double(std::max(height_error / height, slope_error / slope));
}

}  // namespace aberfit::benchmarks
