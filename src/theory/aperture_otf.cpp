#include "aberfit/theory/aperture_otf.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/roughness/bessel.h"
#include "panel_rule.h"
#include "pupil_overlap.h"

namespace aberfit {
using namespace internal;

namespace {

using std::numbers::pi;

constexpr double kTurnOfPanel = 20;  // phase in rad that 24 nodes integrate to rounding: J_48(10) = 1e-28

// int g(t) dt from a to b, `turn` the phase that g turns through; g takes and gives the nodes of a panel.
template <class Function>
double integrate(double a, double b, double turn, const Function& g) {
  const PanelRule& rule = panel_rule();
  const int panels = 1 + int(std::abs(turn) / kTurnOfPanel);
  const double half = 0.5 * (b - a) / panels;
  double sum = 0;
  for (int p = 0; p < panels; ++p)
    sum += (rule.weight * g(PanelArray(a + half * (2 * p + 1 + rule.t)))).sum();
  return half * sum;
}

struct Circular {
  explicit Circular(const PanelArray& phase) {
    sin_cos(phase.data(), kPanelNodes, sine.data(), cosine.data());
  }
  PanelArray sine, cosine;
};

constexpr int kLaguerre = 16;
using LaguerreArray = Eigen::Array<double, kLaguerre, 1>;

// Gauss rule for int_0^inf t^alpha exp(-t) g(t) dt (Golub and Welsch 1969).
struct LaguerreRule {
  explicit LaguerreRule(double alpha) {
    Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(kLaguerre, kLaguerre);
    for (int i = 0; i < kLaguerre; ++i) {
      jacobi(i, i) = 2 * i + 1 + alpha;
      if (i > 0) jacobi(i, i - 1) = jacobi(i - 1, i) = std::sqrt(i * (i + alpha));
    }
    const SymmetricEigen eigen = symmetric_eigen(jacobi);
    t = eigen.values.array();
    weight = std::tgamma(1 + alpha) * eigen.vectors.row(0).transpose().array().square();
  }
  LaguerreArray t, weight;
};

// beta times the distance of a chord's end from the circle, beyond which 16 nodes are exact to 32!/40^32.
constexpr double kFarFromRim = 40;
constexpr double kOnRim = 1e-9;

// Steepest descent from u (from the centre: w), where the chord is cut off: int_0^inf exp(i beta (u + i t))
// sqrt(radius^2 - (w + i t)^2) i dt, its real part.
double descent(double radius, double u, double w, double beta) {
  static const LaguerreRule regular(0), rim(0.5);
  const bool on_rim = beta * (radius - std::abs(w)) < kOnRim;
  const LaguerreRule& rule = on_rim ? rim : regular;
  const LaguerreArray t = rule.t / beta;
  const LaguerreArray re = on_rim ? t : LaguerreArray((radius - w) * (radius + w) + t.square());
  const LaguerreArray im =
      on_rim ? LaguerreArray::Constant(w > 0 ? -2 * radius : 2 * radius) : LaguerreArray(-2 * w * t);
  const LaguerreArray root = (0.5 * (re + (re.square() + im.square()).sqrt())).sqrt();  // re >= 0
  const double x = (rule.weight * root).sum(), y = (rule.weight * im / root).sum() / 2;
  const double scale = on_rim ? 1 / (beta * std::sqrt(beta)) : 1 / beta;
  return -scale * (x * std::sin(beta * u) + y * std::cos(beta * u));
}

// int cos(beta u) sqrt(radius^2 - (u - centre)^2) du from u1 to u2, which lie on the circle's diameter to
// rounding.
double chords(double radius, double centre, double u1, double u2, double beta) {
  if (!(u1 < u2)) return 0;
  beta = std::abs(beta);
  if (beta * (u2 - u1) > 4 * kFarFromRim) {
    // Ends near the rim but not on it are cut off first.
    const auto inside = [&](double u, double sign) {
      const double distance = beta * (radius - std::abs(u - centre));
      return distance < kOnRim || distance >= kFarFromRim ? u : u + sign * kFarFromRim / beta;
    };
    const double v1 = inside(u1, 1), v2 = inside(u2, -1);
    return chords(radius, centre, u1, v1, beta) + chords(radius, centre, v2, u2, beta) +
           descent(radius, v1, v1 - centre, beta) - descent(radius, v2, v2 - centre, beta);
  }
  const double start = std::acos(std::clamp((u2 - centre) / radius, -1.0, 1.0));
  const double end = std::acos(std::clamp((u1 - centre) / radius, -1.0, 1.0));
  if (beta == 0) return 0.5 * radius * radius * (end - start - std::sin(end - start) * std::cos(end + start));
  return radius * radius *
         integrate(start, end, beta * (u2 - u1), [&](const PanelArray& angle) -> PanelArray {
           const Circular point(angle), wave(beta * (centre + radius * point.cosine));
           return wave.cosine * point.sine.square();
         });
}

PanelArray sinc(const PanelArray& z) {
  return (z.abs() < 1e-4).select(1 - z.square() / 6, Circular(z).sine / z);
}

constexpr double kTurnPerDirection = 8, kMostOfDefocus = 300;  // rad; directions

// int (height1 + (height2 - height1) t) cos(beta u) du over u = u1 + t (u2 - u1), t in [0, 1].
double waves_on(const OverlapRegion::Trapezoid& one, double beta) {
  const double width = one.u2 - one.u1, middle = 0.5 * (one.u1 + one.u2), w = 0.5 * beta * width;
  const double first = one.high1 - one.low1, second = one.high2 - one.low2;
  // Means of cos and of t sin over t in [-1, 1], for the phase w t.
  const double sine = std::sin(w), cosine = std::cos(w);
  const double even = std::abs(w) < 1e-4 ? 1 - w * w / 6 : sine / w;
  const double odd =
      std::abs(w) < 1e-2 ? w / 3 * (1 - w * w / 10 * (1 - w * w / 28)) : (sine / w - cosine) / w;
  return width * (0.5 * (first + second) * even * std::cos(beta * middle) -
                  0.5 * (second - first) * odd * std::sin(beta * middle));
}

}  // namespace

ApertureOtf::ApertureOtf(const Aperture& aperture) {
  if (const auto* circle = std::get_if<CircleAperture>(&aperture)) {
    outer_ = 0.5 * circle->diameter;
    breakpoints_ = {2 * outer_};
  } else if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture)) {
    outer_ = 0.5 * annulus->diameter;
    inner_ = 0.5 * annulus->inner_diameter;
    breakpoints_ = {outer_ - inner_, 2 * inner_, outer_ + inner_, 2 * outer_};
  } else if (const auto* rectangle = std::get_if<RectangleAperture>(&aperture)) {
    width_ = rectangle->width;
    height_ = rectangle->height;
    breakpoints_ = {width_, height_, std::hypot(width_, height_)};
  } else {
    const auto& polygon = std::get<PolygonAperture>(aperture);
    corners_ = polygon.vertices;
    area_ = aperture_area(aperture);
    edge_directions_ = edge_directions(corners_);
    breakpoints_ = {longest_distance(corners_)};
  }
  std::sort(breakpoints_.begin(), breakpoints_.end());
  breakpoints_.erase(std::unique(breakpoints_.begin(), breakpoints_.end()), breakpoints_.end());
  if (breakpoints_.front() == 0) breakpoints_.erase(breakpoints_.begin());
  const bool open = width_ > 0 ? height_ > 0 : area_ > 0 || (outer_ > inner_ && inner_ >= 0);
  if (breakpoints_.empty() || !open || !std::isfinite(cutoff()))
    throw ComputationError("the aperture lets no light through: its lengths must be positive and finite");
}

double ApertureOtf::of_polygon(double x, double beta) const {
  // A defocus that turns far over the overlap tells directions apart.
  const int defocused = int(std::min(std::abs(beta) * cutoff() / kTurnPerDirection, kMostOfDefocus));
  const AzimuthRule azimuths = polygon_azimuths(edge_directions_, kFineDirections + defocused);
  double sum = 0;
  for (std::size_t d = 0; d < azimuths.direction.size(); ++d)
    for (const OverlapRegion::Trapezoid& one :
         polygon_overlap(in_frame(corners_, azimuths.direction[d]), x).trapezoids)
      sum += azimuths.weight[d] * waves_on(one, beta);
  return sum / area_;
}

double ApertureOtf::operator()(double x, double curvature) const {
  if (x >= cutoff()) return 0;
  const double beta = curvature * x;  // phase per length across the overlap [rad/m]
  if (!corners_.empty()) return of_polygon(x, beta);
  if (width_ > 0) {
    const double from = x > width_ ? std::acos(width_ / x) : 0;
    const double to = x > height_ ? std::asin(height_ / x) : 0.5 * pi;
    if (beta == 0) {
      const auto antiderivative = [&](double angle) {
        const double sine = std::sin(angle);
        return angle - x * sine / width_ + x * std::cos(angle) / height_ +
               0.5 * x * x * sine * sine / (width_ * height_);
      };
      return 2 / pi * (antiderivative(to) - antiderivative(from));
    }
    const auto side = [&](const PanelArray& shear, double length) -> PanelArray {
      const PanelArray overlap = (length - shear).max(0.0);
      return overlap / length * sinc(0.5 * curvature * shear * overlap);
    };
    return 2 / pi *
           integrate(from, to, beta * std::hypot(width_, height_),
                     [&](const PanelArray& angle) -> PanelArray {
                       const Circular direction(angle);
                       return side(x * direction.cosine, width_) * side(x * direction.sine, height_);
                     });
  }
  double quarter = 0;
  for (const OverlapRegion::Arc& arc : round_overlap(outer_, inner_, x).arcs)
    quarter += arc.sign * chords(arc.radius, arc.centre, arc.u1, arc.u2, beta);
  return 4 * quarter / (pi * (outer_ - inner_) * (outer_ + inner_));
}

}  // namespace aberfit
