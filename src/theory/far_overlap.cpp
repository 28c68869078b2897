#include "far_overlap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

constexpr double kTurnOfNodes = 12;  // rad that 24 nodes carry where they crowd to one end
constexpr int kRadialNodes = 24;
// Phase from axis to rim [rad] where rays' transfers, which fall with its power 3/2, are let go, and gone.
constexpr double kRaysFade = 200, kRaysGone = 400;
constexpr double kLeastPhase = 40;    // of what the error's law was tried at
constexpr double kOfBlur = 2.5e-3;    // of Gaussian roughness at kBlurred
constexpr double kSameRadius = 1e-9;  // of the outer one
constexpr double kSmall = 14;         // upward recurrence loses digits of J_10 below
constexpr double kNoTurn = 1e-9;      // J_2 is rounding

bool is_inside(const std::vector<PupilField::Point>& corners, double x, double y) {
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const PupilField::Point &a = corners[i], &b = corners[j];
    if ((a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]) inside = !inside;
  }
  return inside;
}

// Share of a circle about the axis that lies inside the polygon.
double share_of_circle(const std::vector<PupilField::Point>& corners, double radius) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const PupilField::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double ex = b[0] - a[0], ey = b[1] - a[1], length2 = ex * ex + ey * ey;
    const double along = -(a[0] * ex + a[1] * ey) / length2, cross = a[0] * ey - a[1] * ex;
    const double left = radius * radius / length2 - std::pow(cross / length2, 2);
    if (!(left > 0)) continue;
    for (const double t : {along - std::sqrt(left), along + std::sqrt(left)})
      if (t >= 0 && t < 1) angles.push_back(std::atan2(a[1] + t * ey, a[0] + t * ex));
  }
  if (angles.empty()) return is_inside(corners, radius, 0) ? 1 : 0;
  std::sort(angles.begin(), angles.end());
  angles.push_back(angles.front() + 2 * pi);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
    const double middle = 0.5 * (angles[i] + angles[i + 1]);
    if (is_inside(corners, radius * std::cos(middle), radius * std::sin(middle)))
      sum += angles[i + 1] - angles[i];
  }
  return sum / (2 * pi);
}

// Radii where the share has a kink: of corners, and where the circle touches an edge.
std::vector<double> kinks(const std::vector<PupilField::Point>& corners) {
  std::vector<double> all{0};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const PupilField::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double ex = b[0] - a[0], ey = b[1] - a[1], length2 = ex * ex + ey * ey;
    const double along = -(a[0] * ex + a[1] * ey) / length2;
    all.push_back(std::hypot(a[0], a[1]));
    if (along > 0 && along < 1) all.push_back(std::abs(a[0] * ey - a[1] * ex) / std::sqrt(length2));
  }
  std::sort(all.begin(), all.end());
  const double same = kSameRadius * all.back();
  all.erase(std::unique(all.begin(), all.end(), [=](double one, double two) { return two - one < same; }),
            all.end());
  return all;
}

// Between two radii, crowded to the lower one, above which a share grows as a square root.
template <class Share>
void append(double from, double to, double turn, const Share& share, std::vector<double>* radius,
            std::vector<double>* weight) {
  static const Quadrature rule = gauss_legendre(kRadialNodes, 0.0, 1.0);
  const int pieces = 1 + int(turn / kTurnOfNodes);
  for (int p = 0; p < pieces; ++p)
    for (int k = 0; k < kRadialNodes; ++k) {
      const double t = (p + rule.nodes[k]) / pieces, r = from + (to - from) * t * t;
      radius->push_back(r);
      weight->push_back(rule.weights[k] / pieces * 2 * t * (to - from) * 2 * pi * r * share(r));
    }
}

RadialRule finished(const std::vector<double>& radius, const std::vector<double>& weight) {
  return {Eigen::Map<const Eigen::ArrayXd>(radius.data(), Eigen::Index(radius.size())),
          Eigen::Map<const Eigen::ArrayXd>(weight.data(), Eigen::Index(weight.size()))};
}

// Of the phase 1 - c times it on the axis [rad].
double defocus_of(const PupilField& field, double dz) {
  return 2 * pi / field.wavelength() * std::abs(dz) / (1 + dz / field.focal_length());
}

// Of the square whose rays from the rim are those of the phase [rad/m^2].
double curvature_of(const PupilField& field, double dz) {
  const double f = field.focal_length(), sine = field.outer() / f;
  return defocus_of(field, dz) / (f * f * std::sqrt(1 - sine * sine));
}

// J_0, J_2, ... of 0 <= z < kSmall: down from an order where nothing is left (Miller), of which
// J_0 + 2 J_2 + 2 J_4 + ... = 1 tells the scale.
Eigen::RowVectorXd small_bessel(double z, int harmonics) {
  Eigen::RowVectorXd even = Eigen::RowVectorXd::Zero(harmonics);
  if (z < kNoTurn) {
    even[0] = 1;
    return even;
  }
  double above = 0, here = 1e-250, sum = 0;
  for (int order = z < 1 ? 16 : 48; order > 0; --order) {
    if (order % 2 == 0) {
      sum += 2 * here;
      if (order / 2 < even.size()) even[order / 2] = here;
    }
    const double below = 2 * order / z * here - above;
    above = here;
    here = below;
  }
  even[0] = here;
  return even / (sum + here);
}

// sum over the radii and orders 0, 2, ... of J(x q) times the columns of `weight`, x > 0.
Eigen::ArrayXd bessel_sum(const Eigen::ArrayXd& q, double x, int harmonics, const Eigen::MatrixXd& weight) {
  const Eigen::Index n = q.size();
  const Eigen::ArrayXd z = x * q;
  Eigen::MatrixXd even(n, harmonics);
  Eigen::ArrayXd before(n), last(n);
  bessel_j0_j1(z.data(), int(n), before.data(), last.data());
  even.col(0) = before;
  for (int order = 1; order < 2 * (harmonics - 1); ++order) {
    const Eigen::ArrayXd next = 2 * order / z * last - before;
    before = last;
    last = next;
    if (order % 2 == 1) even.col((order + 1) / 2) = next;
  }
  if (harmonics > 1)
    for (Eigen::Index k = 0; k < n; ++k)
      if (z[k] < kSmall) even.row(k) = small_bessel(z[k], harmonics);
  return (weight.transpose() * even.reshaped()).array();
}

}  // namespace

RadialRule radial_rule(const std::vector<PupilField::Point>& corners, double turn) {
  const std::vector<double> edges = kinks(corners);
  std::vector<double> radius, weight;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i)
    append(
        edges[i], edges[i + 1], turn * (edges[i + 1] - edges[i]) / edges.back(),
        [&](double r) { return share_of_circle(corners, r); }, &radius, &weight);
  return finished(radius, weight);
}

RadialRule radial_rule(double outer, double inner, double turn) {
  std::vector<double> radius, weight;
  append(
      inner, outer, turn * (outer - inner) / outer, [](double) { return 1.0; }, &radius, &weight);
  return finished(radius, weight);
}

FarOverlap::FarOverlap(const PupilField& field, double dz, const std::vector<double>& nodes,
                       Eigen::ArrayXd whole)
    : defocus_(defocus_of(field, dz)),
      focal_length_(field.focal_length()),
      curvature_(curvature_of(field, dz)),
      order_(int(nodes.size())),
      whole_(std::move(whole)) {
  const double outer = field.outer();
  gone_ = kRaysGone / (curvature_ * outer);
  otf_.emplace(shape_of(field));
  true_ = field.corners().empty() ? radial_rule(outer, field.inner(), kRaysGone)
                                  : radial_rule(field.corners(), kRaysGone);
  slopes_ = true_.radius.unaryExpr([&](double r) { return slope(r); });
  straight_.weight /= straight_.weight.sum();
  set_polynomials(nodes, outer);
}

double FarOverlap::error(const PupilField& field, double dz, double blurred, double rest) {
  const double rim = field.outer() / field.focal_length();
  const double curvature = curvature_of(field, dz), phase = 0.5 * curvature * std::pow(field.outer(), 2);
  if (!(phase > kLeastPhase)) return HUGE_VAL;
  const double fringes = 1.3 * std::pow(phase, -0.6);
  return rim * rim *
         std::min(fringes, kOfBlur * curvature * blurred * blurred + 0.15 / phase + rest * fringes);
}

double FarOverlap::slope(double radius) const {
  const double sine = radius / focal_length_;
  return defocus_ * sine / (focal_length_ * std::sqrt(1 - sine * sine));
}

// The aperture whose rays under a phase of constant curvature meet the plane where those of the outline do.
Aperture FarOverlap::shape_of(const PupilField& field) {
  const auto cosine = [&](double radius) { return std::sqrt(1 - std::pow(radius / focal_length_, 2)); };
  const auto scale = [&](double radius) { return cosine(field.outer()) / cosine(radius); };
  if (field.corners().empty()) {
    const double inner = field.inner() > 0 ? field.inner() * scale(field.inner()) : 0;
    straight_ = radial_rule(field.outer(), inner, kRaysGone);
    if (inner > 0) return AnnulusAperture{2 * field.outer(), 2 * inner};
    return CircleAperture{2 * field.outer()};
  }
  std::vector<PupilField::Point> corners = field.is_rectangle() ? field.corners() : field.straight_corners();
  for (PupilField::Point& corner : corners) {
    const double s = scale(std::hypot(corner[0], corner[1]));
    corner = {s * corner[0], s * corner[1]};
  }
  if (field.is_rectangle()) {  // in closed form over the azimuth, too, where its edges are straight
    double width = 0, height = 0;
    const std::size_t n = corners.size();
    for (std::size_t i = 0; i < n; ++i) {
      const PupilField::Point &a = corners[i], &b = corners[(i + 1) % n];
      width += 0.5 * std::abs(b[1] - a[1]) * std::abs(a[0] + b[0]);
      height += 0.5 * std::abs(b[0] - a[0]) * std::abs(a[1] + b[1]);
    }
    const PupilField::Point& corner = field.straight_corners().front();
    width /= 2 * std::abs(corner[1]);
    height /= 2 * std::abs(corner[0]);
    const double w = 0.5 * width, h = 0.5 * height;
    straight_ = radial_rule({{w, h}, {-w, h}, {-w, -h}, {w, -h}}, kRaysGone);
    return RectangleAperture{width, height};
  }
  straight_ = radial_rule(corners, kRaysGone);
  return PolygonAperture{corners};
}

// l_i(a) l_j(a cos^2) as a cosine series in twice the angle, whose terms' means with cos(z cos) are
// (-1)^m J_2m(z).
void FarOverlap::set_polynomials(const std::vector<double>& nodes, double outer) {
  const Eigen::Index n = true_.radius.size();
  const auto lagrange = [&](int i, double a) {
    double product = 1;
    for (int k = 0; k < order_; ++k)
      if (k != i) product *= (a - nodes[std::size_t(k)]) / (nodes[std::size_t(i)] - nodes[std::size_t(k)]);
    return product;
  };
  polynomial_ = Eigen::MatrixXd::Zero(n * order_, order_ * order_);
  double light = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double r = true_.radius[k], a = r * r / (outer * outer);
    const double c = std::sqrt(1 - r * r / (focal_length_ * focal_length_));
    const double weight = true_.weight[k] * 4 / ((1 + c) * (1 + c) * c);
    light += weight;
    for (int m = 0; m < order_; ++m)
      for (int j = 0; j < order_; ++j) {
        double term = 0;
        for (int s = 0; s < order_; ++s) {
          const double angle = pi * (s + 0.5) / order_;
          term += lagrange(j, 0.5 * a * (1 + std::cos(angle))) * std::cos(m * angle);
        }
        term *= (m == 0 ? 1.0 : 2.0) / order_ * (m % 2 == 0 ? weight : -weight);
        for (int i = 0; i < order_; ++i) polynomial_(m * n + k, i * order_ + j) = lagrange(i, a) * term;
      }
  }
  polynomial_ /= light;
}

Eigen::ArrayXd FarOverlap::operator()(double x) const {
  Eigen::ArrayXd sum = whole_ * (*otf_)(x, curvature_);
  if (!(x > 0 && x < gone_)) return sum;
  const double fading = std::clamp((x / gone_ * kRaysGone - kRaysFade) / (kRaysGone - kRaysFade), 0.0, 1.0);
  const Eigen::ArrayXd rays = bessel_sum(slopes_, x, order_, polynomial_);
  const double straight = bessel_sum(curvature_ * straight_.radius, x, 1, straight_.weight.matrix())[0];
  return sum + 0.5 * (1 + std::cos(pi * fading)) * (rays - whole_ * straight);
}

}  // namespace aberfit::internal
