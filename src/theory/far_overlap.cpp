#include "far_overlap.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/roughness/bessel.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

// Phase from axis to rim [rad] where rays' transfers, which fall with its power 3/2, are let go, and gone.
constexpr double kRaysFade = 200, kRaysGone = 400;
constexpr double kLeastPhase = 40;   // of what the error's law was tried at
constexpr double kTurnOfPiece = 15;  // of a ray from the rim: a panel of 24 nodes and its neighbour's kink
constexpr double kSmall = 14;        // upward recurrence loses digits of J_10 below
constexpr double kNoTurn = 1e-9;     // J_2 is rounding

// An aperture as seen from the axis: mean of g(|P|) over it = sum_k share_k g(radius_k).
struct RadialRule {
  Eigen::ArrayXd radius, share;  // [m]
};

// Nodes for phases up to kRaysGone. A piece between two radii where an outline has a kink may be four times
// as wide as their mean.
RadialRule radial_rule(const Aperture& aperture) {
  const std::size_t corners = aperture_corners(aperture).size();
  const double pieces = std::max(1.0, 0.25 * double(corners));
  const std::vector<RadialNode> nodes = radial_quadrature(aperture, 16 + int(0.5 * kRaysGone / pieces));
  RadialRule rule{Eigen::ArrayXd(Eigen::Index(nodes.size())), Eigen::ArrayXd(Eigen::Index(nodes.size()))};
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    rule.radius[Eigen::Index(k)] = nodes[k].rho;
    rule.share[Eigen::Index(k)] = nodes[k].weight;
  }
  return rule;
}

// In the coordinates of P.
Aperture outline(const PupilField& field) {
  if (!field.corners().empty()) return PolygonAperture{field.corners()};
  if (field.inner() > 0) return AnnulusAperture{2 * field.outer(), 2 * field.inner()};
  return CircleAperture{2 * field.outer()};
}

// Sides of the rectangle with the area of this one, whose edges are bent, in the middle of every side.
RectangleAperture straightened(const std::vector<PupilField::Point>& corners,
                               const PupilField::Point& corner) {
  double width = 0, height = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const PupilField::Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    width += std::abs(b[1] - a[1]) * std::abs(a[0] + b[0]);
    height += std::abs(b[0] - a[0]) * std::abs(a[1] + b[1]);
  }
  return {0.25 * width / std::abs(corner[1]), 0.25 * height / std::abs(corner[0])};
}

// The aperture whose rays under a phase of constant curvature meet the plane about where those of the outline
// do: from the rim exactly.
Aperture of_square_phase(const PupilField& field) {
  const double f = field.focal_length();
  const auto cosine = [f](double radius) { return std::sqrt(1 - radius * radius / (f * f)); };
  const auto scale = [&](double radius) { return cosine(field.outer()) / cosine(radius); };
  if (field.corners().empty()) {
    if (field.inner() > 0)
      return AnnulusAperture{2 * field.outer(), 2 * field.inner() * scale(field.inner())};
    return CircleAperture{2 * field.outer()};
  }
  std::vector<PupilField::Point> corners = field.is_rectangle() ? field.corners() : field.straight_corners();
  for (PupilField::Point& corner : corners) {
    const double s = scale(std::hypot(corner[0], corner[1]));
    corner = {s * corner[0], s * corner[1]};
  }
  if (field.is_rectangle()) return straightened(corners, field.straight_corners().front());
  return PolygonAperture{corners};
}

// Slope of the phase k |dz| (1 - c)/(1 + dz/f) at a radius [rad/m].
double phase_slope(const PupilField& field, double dz, double radius) {
  const double f = field.focal_length(), sine = radius / f;
  const double defocus = 2 * pi / field.wavelength() * std::abs(dz) / (1 + dz / f);
  return defocus * sine / (f * std::sqrt(1 - sine * sine));
}

// Of the square whose rays from the rim are those of the phase [rad/m^2].
double curvature_of(const PupilField& field, double dz) {
  return phase_slope(field, dz, field.outer()) / field.outer();
}

// J_0, J_2, ... of 0 <= z < kSmall: down from an order where nothing is left (Miller), of which
// J_0 + 2 J_2 + 2 J_4 + ... = 1 tells the scale.
template <class Row>
void small_bessel(double z, Row even) {
  if (z < kNoTurn) {
    even.setZero();
    even[0] = 1;
    return;
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
  even /= sum + here;
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
      if (z[k] < kSmall) small_bessel(z[k], even.row(k));
  return (weight.transpose() * even.reshaped()).array();
}

}  // namespace

FarOverlap::FarOverlap(const PupilField& field, double dz, const std::vector<double>& nodes,
                       Eigen::ArrayXd whole)
    : curvature_(curvature_of(field, dz)),
      gone_(kRaysGone / (curvature_ * field.outer())),
      order_(int(nodes.size())),
      ends_(!field.corners().empty()),
      whole_(std::move(whole)),
      otf_(of_square_phase(field)) {
  const RadialRule straight = radial_rule(of_square_phase(field)), bent = radial_rule(outline(field));
  straight_slopes_ = curvature_ * straight.radius;
  straight_ = straight.share.matrix();
  slopes_ = bent.radius.unaryExpr([&](double r) { return phase_slope(field, dz, r); });
  set_polynomials(nodes, bent.radius, bent.share, field);
}

double FarOverlap::error(const PupilField& field, double dz, double blurred) {
  const double rim = field.outer() / field.focal_length(), curvature = curvature_of(field, dz);
  const double phase = 0.5 * curvature * std::pow(std::min(field.outer(), 0.5 * field.across()), 2);
  if (!(phase > kLeastPhase)) return HUGE_VAL;
  const double fringes = 1.35 * std::pow(phase, -0.6);
  const double of_blurred = 2.5e-3 * curvature * blurred * blurred + 0.15 / phase + kBlurred * fringes;
  return rim * rim * std::min(fringes, of_blurred);
}

// l_i(a) l_j(a cos^2) as a cosine series in twice the angle, whose terms' means with cos(z cos) are
// (-1)^m J_2m(z).
void FarOverlap::set_polynomials(const std::vector<double>& nodes, const Eigen::ArrayXd& radius,
                                 const Eigen::ArrayXd& share, const PupilField& field) {
  const double outer = field.outer(), focal_length = field.focal_length();
  const Eigen::Index n = radius.size();
  const auto lagrange = [&](int i, double a) {
    double product = 1;
    for (int k = 0; k < order_; ++k)
      if (k != i) product *= (a - nodes[std::size_t(k)]) / (nodes[std::size_t(i)] - nodes[std::size_t(k)]);
    return product;
  };
  polynomial_ = Eigen::MatrixXd::Zero(n * order_, order_ * order_);
  double light = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double r = radius[k], a = r * r / (outer * outer);
    const double c = std::sqrt(1 - r * r / (focal_length * focal_length));
    const double weight = share[k] * 4 / ((1 + c) * (1 + c) * c);
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
  if (ends_ && x >= gone_) return Eigen::ArrayXd::Zero(whole_.size());
  Eigen::ArrayXd sum = whole_ * otf_(x, curvature_);
  if (!(x > 0 && x < gone_)) return sum;
  const double fading = std::clamp((x / gone_ * kRaysGone - kRaysFade) / (kRaysGone - kRaysFade), 0.0, 1.0),
               left = 0.5 * (1 + std::cos(pi * fading));
  const Eigen::ArrayXd rays = bessel_sum(slopes_, x, order_, polynomial_);
  const double straight = bessel_sum(straight_slopes_, x, 1, straight_)[0];
  if (ends_) sum *= left;
  return sum + left * (rays - whole_ * straight);
}

std::vector<double> FarOverlap::breakpoints() const {
  std::vector<double> result;
  if (ends_) {
    const double end = std::min(gone_, otf_.cutoff()), turn = kRaysGone * end / gone_;
    const int pieces = 1 + int(turn / kTurnOfPiece);
    for (int k = 1; k <= pieces; ++k) result.push_back(end * k / pieces);
  } else {
    result = otf_.breakpoints();
  }
  return result;
}

}  // namespace aberfit::internal
