#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "detrend_basis.h"

namespace aberfit {
namespace {

// Height of a mirror ellipse over its tangent at the pole; p, q: arms [m], theta: grazing angle [rad]. From
// |P - F1| + |P - F2| = p + q with F1 = (-p cos, p sin), F2 = (q cos, q sin), squared once and solved for z:
//   z = 2 s x^2 / (-b + sqrt(b^2 - 4 a x^2)), b = (2 x c (p - q) - 4 p q)/(p + q), a = 1 - (s (p - q)/(p +
//   q))^2.
double ellipse_height(double x, double inverse_p, double inverse_q, double theta) {
  const double s = std::sin(theta), c = std::cos(theta), p = 1 / inverse_p, q = 1 / inverse_q, l = p + q;
  const double minus_b = (4 * p * q - 2 * x * c * (p - q)) / l, a = 1 - std::pow(s * (p - q) / l, 2);
  const double root = minus_b * minus_b - 4 * a * x * x;
  if (root < 0 || minus_b <= 0) return std::numeric_limits<double>::quiet_NaN();  // beyond the ellipse's end
  return 2 * s * x * x / (minus_b + std::sqrt(root));
}

// The model in the profile's own quantity without piston and tilt; shape = (log 1/p, log 1/q, log theta).
Eigen::VectorXd model(const Eigen::ArrayXd& x, double half, const Eigen::Vector3d& shape, bool slope) {
  const double u = std::exp(shape[0]), v = std::exp(shape[1]), theta = std::exp(shape[2]);
  Eigen::VectorXd z(x.size());
  const double h = 1e-3 * half;  // truncation h^2 z'''/6: below 1e-6 of the slope's cubic part
  for (Eigen::Index i = 0; i < x.size(); ++i)
    z[i] = slope ? (8 * (ellipse_height(x[i] + h, u, v, theta) - ellipse_height(x[i] - h, u, v, theta)) -
                    (ellipse_height(x[i] + 2 * h, u, v, theta) - ellipse_height(x[i] - 2 * h, u, v, theta))) /
                       (12 * h)
                 : ellipse_height(x[i], u, v, theta);
  return z;
}

struct Attempt {
  double cost = std::numeric_limits<double>::infinity();
  Eigen::Vector3d shape;
};

}  // namespace

EllipseFit fit_ellipse(const Profile& profile) {
  EllipseFit result;
  std::vector<Eigen::Index> valid;
  for (Eigen::Index i = 0; i < profile.size(); ++i)
    if (std::isfinite(profile.value[i])) valid.push_back(i);
  if (valid.size() < 8) return result;
  const bool slope = profile.quantity == ProfileQuantity::kSlope;
  const double low = profile.x[valid.front()], high = profile.x[valid.back()], half = 0.5 * (high - low);
  const Eigen::ArrayXd everywhere = profile.x - 0.5 * (low + high), x = everywhere(valid);
  const Eigen::VectorXd value = profile.value(valid).matrix();
  // Piston and tilt (of slopes: only the tilt, a constant) are linear: they are projected out of everything.
  const Eigen::MatrixXd linear = legendre_basis(x, -half, half, slope ? 0 : 1);
  const Eigen::LDLT<Eigen::MatrixXd> normal_linear(linear.transpose() * linear);
  const auto fit_linear = [&](const Eigen::VectorXd& v) {
    return Eigen::VectorXd(normal_linear.solve(linear.transpose() * v));
  };
  const auto project = [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(v - linear * fit_linear(v)); };
  const Eigen::MatrixXd quadric = legendre_basis(x, -half, half, slope ? 1 : 2);
  const Eigen::VectorXd bend = (quadric.transpose() * quadric).ldlt().solve(quadric.transpose() * value);
  // P_2 = (3 t^2 - 1)/2 and P_1 = t, t = x/half: second derivative of the height.
  const double curvature = slope ? bend[1] / half : 3 * bend[2] / (half * half);
  const double sign = curvature < 0 ? -1 : 1;
  const Eigen::VectorXd data = project(sign * value);
  if (!(std::abs(curvature) > 0)) return result;
  const double quadratic_cost = (value - quadric * bend).squaredNorm();

  Attempt best;
  for (const double theta : {1e-3, 4e-3, 2e-2, 0.2})
    for (const double ratio : {1e-3, 0.03, 0.3, 3., 30., 1e3}) {
      // curvature = sin(theta) (1/p + 1/q)/2 fixes the scale.
      const double total = 2 * std::abs(curvature) / std::sin(theta);
      Eigen::Vector3d shape(std::log(total * ratio / (1 + ratio)), std::log(total / (1 + ratio)),
                            std::log(theta));
      double cost = (data - project(model(x, half, shape, slope))).squaredNorm(), damping = 1e-3;
      if (!std::isfinite(cost)) continue;
      for (int step = 0; step < 60; ++step) {
        const Eigen::VectorXd residual = data - project(model(x, half, shape, slope));
        Eigen::MatrixXd jacobian(x.size(), 3);
        for (int k = 0; k < 3; ++k) {
          Eigen::Vector3d up = shape, down = shape;
          up[k] += 1e-4, down[k] -= 1e-4;
          jacobian.col(k) = project(model(x, half, up, slope) - model(x, half, down, slope)) / 2e-4;
        }
        if (!jacobian.allFinite()) break;
        const Eigen::Matrix3d normal = jacobian.transpose() * jacobian;
        const Eigen::Vector3d right = jacobian.transpose() * residual;
        bool moved = false;
        double gain = 0;
        for (int attempt = 0; attempt < 12 && !moved; ++attempt, damping *= 5) {
          Eigen::Matrix3d damped = normal;
          damped.diagonal() *= 1 + damping;
          damped.diagonal().array() += 1e-14 * normal.trace();
          const Eigen::Vector3d delta = damped.ldlt().solve(right);
          if (!(delta.norm() < 3)) continue;
          const double there = (data - project(model(x, half, shape + delta, slope))).squaredNorm();
          if (there < cost) gain = (cost - there) / cost, cost = there, shape += delta, moved = true;
        }
        if (moved) damping = std::max(damping / 100, 1e-12);
        if (!moved || gain < 1e-10) break;
      }
      if (cost < best.cost) best = {cost, shape};
    }
  // A plane or a sphere fixes no arms; what does not even reach the parabola is no ellipse.
  if (!(best.cost <= quadratic_cost * (1 + 1e-9))) return result;
  const Eigen::VectorXd fitted = model(x, half, best.shape, slope),
                        all = model(everywhere, half, best.shape, slope);
  if (!all.allFinite()) return result;
  const Eigen::VectorXd rest = fit_linear(sign * value - fitted);
  result.converged = true;
  result.p = std::exp(-best.shape[0]);
  result.q = std::exp(-best.shape[1]);
  result.grazing_angle = std::exp(best.shape[2]);
  result.shape = sign * (all + legendre_basis(everywhere, -half, half, slope ? 0 : 1) * rest).array();
  return result;
}

}  // namespace aberfit
