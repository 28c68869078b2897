#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "detrend_basis.h"

namespace aberfit {
namespace {

constexpr double kNoShape = 1e-12;       // of the values: what is left of a plane by rounding
constexpr double kLeastProduct = 1e-10;  // half^2/(p q): with less the ellipse is a parabola

// Mirror ellipse over its tangent at the pole. From |P - F1| + |P - F2| = p + q with F1 = (-p cos, p sin), F2
// = (q cos, q sin), squared once and solved for z:
//   z = E x^2 / (2 - D x + 2 sqrt(1 - D x - G x^2)),
//   E = sin(theta) (1/p + 1/q), D = cos(theta) (1/q - 1/p), G = 1/(p q).
// E is linear, and D and G are nearly so (cubic and quartic of the height), whereas in p, q and theta the
// valley of the least squares is long and bent. `shape` = (D half, G half^2); the result is z/E or its
// derivative, NaN beyond the ellipse's end.
Eigen::VectorXd unit_ellipse(const Eigen::ArrayXd& x, double half, const Eigen::Vector2d& shape, bool slope) {
  const double d = shape[0] / half, g = shape[1] / (half * half);
  Eigen::VectorXd z(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double t = x[i], inside = 1 - d * t - g * t * t;
    if (!(inside > 0)) {
      z[i] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const double root = std::sqrt(inside), below = 2 - d * t + 2 * root;
    z[i] = slope ? (2 * t + t * t * (d + (d + 2 * g * t) / root) / below) / below : t * t / below;
  }
  return z;
}

struct Attempt {
  double cost = std::numeric_limits<double>::infinity();
  double factor = 0;  // E
  Eigen::Vector2d shape = Eigen::Vector2d::Zero();
  Eigen::VectorXd unit, residual;
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
  // Piston and tilt (of slopes: only the tilt, a constant) are linear, too: they are projected out of
  // everything.
  const Eigen::MatrixXd linear = legendre_basis(x, -half, half, slope ? 0 : 1);
  const LeastSquares linear_part(linear);
  const auto project = [&](const Eigen::VectorXd& v) {
    return Eigen::VectorXd(v - linear * linear_part.solve(v));
  };
  const Eigen::VectorXd data = project(value);
  const auto attempt_at = [&](const Eigen::Vector2d& shape) {
    Attempt attempt;
    attempt.shape = shape;
    attempt.unit = project(unit_ellipse(x, half, shape, slope));
    attempt.factor = attempt.unit.dot(data) / attempt.unit.squaredNorm();
    attempt.residual = data - attempt.factor * attempt.unit;
    const double cost = attempt.residual.squaredNorm();
    if (std::isfinite(cost)) attempt.cost = cost;
    return attempt;
  };

  Attempt best;
  // The first start is the parabola: the result is at least as near to the data.
  for (const double product : {kLeastProduct, 0.1})
    for (const double skew : {0., -0.5, 0.5}) {
      Attempt now = attempt_at({skew, product});
      double damping = 1e-6;
      for (int step = 0; step < 100 && std::isfinite(now.cost); ++step) {
        Eigen::MatrixXd jacobian(x.size(), 2);  // E follows the shape (Kaufman 1975)
        for (int k = 0; k < 2; ++k) {
          Eigen::Vector2d up = now.shape, down = now.shape;
          const double h = 1e-5;  // truncation h^2
          up[k] += h, down[k] -= h;
          const Eigen::VectorXd change =
              now.factor / (2 * h) *
              project(unit_ellipse(x, half, up, slope) - unit_ellipse(x, half, down, slope));
          jacobian.col(k) = change - now.unit * (now.unit.dot(change) / now.unit.squaredNorm());
        }
        if (!jacobian.allFinite()) break;
        const Eigen::Vector2d length = jacobian.colwise().norm();
        double gain = 0;
        for (int trial = 0; trial < 25; ++trial, damping *= 5) {
          Eigen::MatrixXd stacked(x.size() + 2, 2);
          stacked << jacobian, Eigen::MatrixXd((std::sqrt(damping) * length).asDiagonal());
          Eigen::VectorXd right = Eigen::VectorXd::Zero(x.size() + 2);
          right.head(x.size()) = now.residual;
          Eigen::Vector2d there = now.shape + LeastNorm(stacked).solve(right);
          if (there[1] < kLeastProduct) {  // at its bound, and the skew the best one there
            const Eigen::VectorXd only = jacobian.col(0),
                                  rest = now.residual - jacobian.col(1) * (kLeastProduct - now.shape[1]);
            there = {now.shape[0] + only.dot(rest) / (only.squaredNorm() * (1 + damping)), kLeastProduct};
          }
          Attempt next = attempt_at(there);
          if (next.cost < now.cost) {
            gain = 1 - next.cost / now.cost;
            now = std::move(next);
            break;
          }
        }
        if (gain < 1e-12) break;
        damping = std::max(damping / 100, 1e-15);
      }
      if (now.cost < best.cost) best = std::move(now);
    }
  // A plane fixes no arms.
  if (!(std::abs(best.factor) * best.unit.norm() > kNoShape * value.norm())) return result;
  const Eigen::VectorXd all = unit_ellipse(everywhere, half, best.shape, slope);
  if (!all.allFinite()) return result;
  const Eigen::VectorXd rest = linear_part.solve(value - best.factor * Eigen::VectorXd(all(valid)));
  // E^2/S + D^2/(S - 4 G) = 1 with S = (1/p + 1/q)^2; the other root has S below 4 G and E^2.
  const double e = std::abs(best.factor), d = best.shape[0] / half, g = best.shape[1] / (half * half);
  const double middle = 0.5 * (4 * g + e * e + d * d);
  const double s = middle + std::sqrt(std::max(0.0, middle * middle - 4 * g * e * e));
  const double sum = std::sqrt(s), difference = std::sqrt(std::max(0.0, s - 4 * g));
  const double larger = 0.5 * (sum + difference), smaller = g / larger;  // 1/p and 1/q
  result.converged = true;
  result.p = 1 / (d < 0 ? larger : smaller);
  result.q = 1 / (d < 0 ? smaller : larger);
  result.grazing_angle = std::asin(std::min(1.0, e / sum));
  result.shape = (best.factor * all + legendre_basis(everywhere, -half, half, slope ? 0 : 1) * rest).array();
  return result;
}

}  // namespace aberfit
