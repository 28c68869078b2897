#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "aberfit/core/linear_algebra.h"
#include "detrend_basis.h"

namespace aberfit::internal {
namespace {

constexpr double kNoShape = 1e-12;       // fraction of the values; less is the rounding of a plane
constexpr double kLeastProduct = 1e-10;  // half^2/(p q); below, the ellipse is a parabola

// Mirror ellipse over its tangent at the pole. It follows from |P - F1| + |P - F2| = p + q with F1 = (-p cos,
// p sin), F2 = (q cos, q sin), squared once and solved for z:
//   z = E x^2 / (2 - D x + 2 sqrt(1 - D x - G x^2)),
//   E = sin(theta) (1/p + 1/q), D = cos(theta) (1/q - 1/p), G = 1/(p q).
// E is a linear parameter, and D and G are nearly linear (cubic and quartic of the height). In p, q and theta
// the valley of the least squares would be long and bent.
// `shape` = (D half, G half^2). Returns z/E or its derivative, NaN beyond the end of the ellipse.
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

// The data of the fit: valid points of a profile, with positions about their middle.
struct Points {
  double half = 0;  // half of their span [m]
  bool slope = false;
  std::vector<Eigen::Index> valid;
  Eigen::ArrayXd everywhere, x;  // all positions, and those of the valid points
  Eigen::VectorXd value;
  // Piston and tilt (for slopes only the tilt, a constant) are linear as well and are projected out.
  Eigen::MatrixXd linear;
  std::unique_ptr<const LeastSquares> linear_part;
  Eigen::VectorXd data;  // the values without them
};

Eigen::MatrixXd linear_basis(const Points& points, const Eigen::ArrayXd& x) {
  return legendre_basis(x, -points.half, points.half, points.slope ? 0 : 1);
}

Eigen::VectorXd project(const Points& points, const Eigen::VectorXd& v) {
  return Eigen::VectorXd(v - points.linear * points.linear_part->solve(v));
}

Points points_of(const Profile& profile, std::vector<Eigen::Index> valid) {
  Points points;
  const double low = profile.x[valid.front()], high = profile.x[valid.back()];
  points.half = 0.5 * (high - low);
  points.slope = profile.quantity == ProfileQuantity::kSlope;
  points.everywhere = profile.x - 0.5 * (low + high);
  points.x = points.everywhere(valid);
  points.value = profile.value(valid).matrix();
  points.valid = std::move(valid);
  points.linear = linear_basis(points, points.x);
  points.linear_part = std::make_unique<const LeastSquares>(points.linear);
  points.data = project(points, points.value);
  return points;
}

Eigen::VectorXd unit_ellipse(const Points& points, const Eigen::Vector2d& shape) {
  return unit_ellipse(points.x, points.half, shape, points.slope);
}

// A trial shape with its least-squares E.
struct Attempt {
  double cost = std::numeric_limits<double>::infinity();
  double factor = 0;  // E
  Eigen::Vector2d shape = Eigen::Vector2d::Zero();
  Eigen::VectorXd unit, residual;
};

Attempt attempt_at(const Points& points, const Eigen::Vector2d& shape) {
  Attempt attempt;
  attempt.shape = shape;
  attempt.unit = project(points, unit_ellipse(points, shape));
  attempt.factor = attempt.unit.dot(points.data) / attempt.unit.squaredNorm();
  attempt.residual = points.data - attempt.factor * attempt.unit;
  const double cost = attempt.residual.squaredNorm();
  if (std::isfinite(cost)) attempt.cost = cost;
  return attempt;
}

// Derivatives with respect to the shape; E is the least-squares value for each shape (Kaufman 1975).
Eigen::MatrixXd shape_jacobian(const Points& points, const Attempt& at) {
  Eigen::MatrixXd jacobian(points.x.size(), 2);
  for (int k = 0; k < 2; ++k) {
    Eigen::Vector2d up = at.shape, down = at.shape;
    const double h = 1e-5;  // truncation error h^2
    up[k] += h, down[k] -= h;
    const Eigen::VectorXd change =
        at.factor / (2 * h) * project(points, unit_ellipse(points, up) - unit_ellipse(points, down));
    jacobian.col(k) = change - at.unit * (at.unit.dot(change) / at.unit.squaredNorm());
  }
  return jacobian;
}

// Returns the shape after a Levenberg-Marquardt step, damped by the lengths of the columns.
Eigen::Vector2d damped_step(const Attempt& at, const Eigen::MatrixXd& jacobian, const Eigen::Vector2d& length,
                            double damping) {
  const Eigen::Index size = jacobian.rows();
  Eigen::MatrixXd stacked(size + 2, 2);
  stacked << jacobian, Eigen::MatrixXd((std::sqrt(damping) * length).asDiagonal());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size + 2);
  right.head(size) = at.residual;
  Eigen::Vector2d there = at.shape + LeastNorm(stacked).solve(right);
  if (!(there[1] < kLeastProduct)) return there;
  // G is at its bound; D is the best one there.
  const Eigen::VectorXd only = jacobian.col(0),
                        rest = at.residual - jacobian.col(1) * (kLeastProduct - at.shape[1]);
  return {at.shape[0] + only.dot(rest) / (only.squaredNorm() * (1 + damping)), kLeastProduct};
}

Attempt descend(const Points& points, const Eigen::Vector2d& start) {
  Attempt now = attempt_at(points, start);
  double damping = 1e-6;
  for (int step = 0; step < 100 && std::isfinite(now.cost); ++step) {
    const Eigen::MatrixXd jacobian = shape_jacobian(points, now);
    if (!jacobian.allFinite()) break;
    const Eigen::Vector2d length = jacobian.colwise().norm();
    double gain = 0;
    for (int trial = 0; trial < 25; ++trial, damping *= 5) {
      Attempt next = attempt_at(points, damped_step(now, jacobian, length, damping));
      if (next.cost < now.cost) {
        gain = 1 - next.cost / now.cost;
        now = std::move(next);
        break;
      }
    }
    if (gain < 1e-12) break;
    damping = std::max(damping / 100, 1e-15);
  }
  return now;
}

// Sets p, q and the grazing angle of the ellipse with |E|, D and G.
void set_arms(double e, double d, double g, EllipseFit* result) {
  // E^2/S + D^2/(S - 4 G) = 1 with S = (1/p + 1/q)^2; the other root S is below 4 G and E^2.
  const double middle = 0.5 * (4 * g + e * e + d * d);
  const double s = middle + std::sqrt(std::max(0.0, middle * middle - 4 * g * e * e));
  const double sum = std::sqrt(s), difference = std::sqrt(std::max(0.0, s - 4 * g));
  const double larger = 0.5 * (sum + difference), smaller = g / larger;  // 1/p and 1/q
  result->p = 1 / (d < 0 ? larger : smaller);
  result->q = 1 / (d < 0 ? smaller : larger);
  result->grazing_angle = std::asin(std::min(1.0, e / sum));
}

}  // namespace

EllipseFit fit_ellipse(const Profile& profile) {
  EllipseFit result;
  std::vector<Eigen::Index> valid;
  for (Eigen::Index i = 0; i < profile.size(); ++i)
    if (std::isfinite(profile.value[i])) valid.push_back(i);
  if (valid.size() < 8) return result;
  const Points points = points_of(profile, std::move(valid));

  Attempt best;
  // The first start is the parabola, so that the result fits at least as well.
  for (const double product : {kLeastProduct, 0.1})
    for (const double skew : {0., -0.5, 0.5}) {
      Attempt found = descend(points, {skew, product});
      if (found.cost < best.cost) best = std::move(found);
    }
  // A plane does not determine p and q.
  if (!(std::abs(best.factor) * best.unit.norm() > kNoShape * points.value.norm())) return result;
  const Eigen::VectorXd all = unit_ellipse(points.everywhere, points.half, best.shape, points.slope);
  if (!all.allFinite()) return result;
  const Eigen::VectorXd rest =
      points.linear_part->solve(points.value - best.factor * Eigen::VectorXd(all(points.valid)));
  result.converged = true;
  set_arms(std::abs(best.factor), best.shape[0] / points.half, best.shape[1] / (points.half * points.half),
           &result);
  result.shape = (best.factor * all + linear_basis(points, points.everywhere) * rest).array();
  return result;
}

}  // namespace aberfit::internal
