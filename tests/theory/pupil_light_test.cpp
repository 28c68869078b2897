// The autocorrelation of a pupil from its focal irradiance on grids and rings, against the overlap of round
// pupils by quadrature, closed forms, and a sum over all pairs of pupil points.
#include "../../src/theory/pupil_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "../../src/theory/pupil_moments.h"
#include "../../src/theory/pupil_overlap.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/scene/segments.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "regular_polygon.h"
#include "short_form.h"

namespace aberfit::internal {
namespace {

using std::numbers::pi;

constexpr double kLambda = 633e-9, kDiameter = 0.4;
constexpr int kCells = 256;

const Aperture kCircle = CircleAperture{kDiameter}, kAnnulus = AnnulusAperture{kDiameter, 0.15},
               kRectangle = RectangleAperture{0.32, 0.24};
const Aperture kHexagon =
    PolygonAperture{{{0.2, 0}, {0.1, 0.173}, {-0.1, 0.17}, {-0.19, 0.02}, {-0.1, -0.17}, {0.1, -0.16}}};

PupilField field_of(const Aperture& aperture, double f_number, double conic = -1) {
  return PupilField(Mirror{f_number * kDiameter, conic, {}}, aperture, kLambda, {});
}
// Plane [m] with this number of waves of defocus at the rim.
double plane_of(double waves, double f_number) { return 8 * f_number * f_number * kLambda * waves; }

LightMoments by_cells(const PupilField& field, double dz, const MomentBasis& basis, int degree) {
  const PupilCells cells(field, kCells);
  const FocalGrid grid(FocalGrid::samples_for(cells, 2 * field.outer()),
                       FocalGrid::taper_for(cells, cells.steepest(dz)));
  return {PupilLight::of_cells(cells, grid, nullptr, degree, dz), basis};
}

// Largest difference of any moment beyond 64 grid cells; below that, of their sum.
struct Difference {
  double near = 0, beyond = 0;
};
Difference difference_of(const LightMoments& light, const PupilOverlap& overlap, double outer) {
  Difference most;
  const double far = 64 * 2 * outer / kCells;
  for (double x = 1e-3 * outer; x < 2 * outer; x *= 1.17) {
    const Eigen::ArrayXd off = light(Eigen::ArrayXd::Constant(1, x)).row(0).transpose() - overlap(x);
    most.near = std::max(most.near, std::abs(off.sum()));
    if (x > far) most.beyond = std::max(most.beyond, off.abs().maxCoeff());
  }
  return most;
}

TEST(PupilLight, OfCellsHasEveryMomentOfARoundOverlap) {
  const MomentBasis basis(3);
  for (const Aperture& aperture : {kCircle, kAnnulus})
    for (const double f_number : {1.5, 5.0})
      for (const double waves : {0.0, 3.0}) {
        const PupilField field = field_of(aperture, f_number);
        const double dz = plane_of(waves, f_number);
        const PupilOverlap overlap(field, dz, basis);
        // This basis contains all polynomials up to the fourth degree.
        const LightMoments light = by_cells(field, dz, basis, 4);
        const Difference off = difference_of(light, overlap, field.outer());
        EXPECT_LT(off.near, 2e-4) << f_number << ' ' << waves;
        EXPECT_LT(off.beyond, 2e-4) << f_number << ' ' << waves;
        const Eigen::MatrixXd mean = PupilCells(field, kCells).mean(4);
        EXPECT_LT((LightMoments::whole(mean, basis) - overlap(0)).abs().maxCoeff(), 1e-6);
      }
}

TEST(PupilLight, OfRingsHasEveryMomentOfARoundOverlap) {
  const MomentBasis basis(3);
  for (const Aperture& aperture : {kCircle, kAnnulus})
    for (const auto& [waves, conic] : {std::pair{40.0, -1.0}, {0.0, 30.0}}) {
      const PupilField field = field_of(aperture, 5, conic);
      const double dz = plane_of(waves, 5);
      const PupilOverlap overlap(field, dz, basis);
      const LightMoments light(PupilLight::of_rings(field, 4, dz), basis);
      const Difference off = difference_of(light, overlap, field.outer());
      EXPECT_LT(std::max(off.near, off.beyond), 2e-4) << waves;
      // Rings leave out a fraction of 1e-6 in the middle.
      const PupilLight rings = PupilLight::of_rings(field, 4, dz);
      EXPECT_LT((LightMoments::whole(rings.mean, basis) - overlap(0)).abs().maxCoeff(), 2e-6);
    }
}

// A rectangle so slow that direction equals position, far out of focus. At the shear (x, y) its transfer
// function is the product of those of two slits, (L - |x|)/L sin(t)/t, t = k dz x (L - |x|)/(2 f (f + dz)).
TEST(PupilLight, OfARectangleIsTheProductOfTwoSlits) {
  constexpr double kSlow = 1000;
  const double f = kSlow * kDiameter;
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-14, 0.01}), Mirror{f, -1, {}}, kRectangle,
                                      kLambda);
  for (const double waves : {0.0, 0.7, 12.0, 60.0}) {
    const double dz = plane_of(waves, kSlow), turn = 2 * pi / kLambda * dz / (f * (f + dz));
    const auto slit = [&](double x, double length) {
      const double left = std::max(0.0, length - std::abs(x)), t = 0.5 * turn * x * left;
      return left / length * (std::abs(t) < 1e-6 ? 1 : std::sin(t) / t);
    };
    // Its mean over direction, on panels of the shear.
    constexpr int kDirections = 6000, kPanels = 150, kNodes = 24;
    std::vector<double> shear, weighted;
    for (int p = 0; p < kPanels; ++p) {
      const Quadrature rule = gauss_legendre(kNodes, kDiameter * p / kPanels, kDiameter * (p + 1) / kPanels);
      for (int i = 0; i < kNodes; ++i) {
        double mean = 0;
        for (int k = 0; k < kDirections; ++k) {
          const double angle = 0.5 * pi * (k + 0.5) / kDirections;
          mean += slit(rule.nodes[i] * std::cos(angle), 0.32) * slit(rule.nodes[i] * std::sin(angle), 0.24);
        }
        shear.push_back(rule.nodes[i]);
        weighted.push_back(rule.weights[i] * mean / kDirections);
      }
    }
    const MeanSpot spot = smooth.at_plane(dz);
    for (const double fraction : {0.2, 0.5, 0.8, 0.9}) {
      const double u = 2 * pi * spot.encircled_energy_radius(fraction) / (kLambda * (f + dz));
      double sum = 0;
      for (std::size_t k = 0; k < shear.size(); ++k) {
        const double z = u * shear[k];
        double j0 = 0, j1 = 0;
        bessel_j0_j1(&z, 1, &j0, &j1);
        sum += weighted[k] * u * j1;
      }
      EXPECT_NEAR(sum, fraction, 1e-4) << waves << ' ' << fraction;
    }
  }
}

// Gauss-Legendre points on rings or on triangles of an outline, with areas [m^2], negative in holes.
struct AreaPoint {
  double x, y, area;
};
std::vector<AreaPoint> points_on(const Aperture& aperture, int across) {
  std::vector<AreaPoint> points;
  const Quadrature outwards = gauss_legendre(across, 0, 1), along = gauss_legendre((2 * across) / 3, 0, 1);
  if (const auto* circle = std::get_if<CircleAperture>(&aperture)) {
    const double rim = 0.5 * circle->diameter;
    const int turns = 3 * across;
    for (Eigen::Index i = 0; i < outwards.nodes.size(); ++i)
      for (int k = 0; k < turns; ++k) {
        const double r = rim * outwards.nodes[i], angle = 2 * pi * (k + 0.5 * double(i % 2)) / turns;
        points.push_back(
            {r * std::cos(angle), r * std::sin(angle), 2 * pi / turns * r * rim * outwards.weights[i]});
      }
    return points;
  }
  for (const Outline& corners : aperture_outlines(aperture)) {
    double x = 0, y = 0;
    for (const auto& corner : corners)
      x += corner[0] / double(corners.size()), y += corner[1] / double(corners.size());
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const auto &a = corners[k], &b = corners[(k + 1) % corners.size()];
      const double twice = (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x);
      for (Eigen::Index i = 0; i < outwards.nodes.size(); ++i)
        for (Eigen::Index j = 0; j < along.nodes.size(); ++j) {
          const double out = outwards.nodes[i], t = along.nodes[j];
          points.push_back({x + out * ((1 - t) * (a[0] - x) + t * (b[0] - x)),
                            y + out * ((1 - t) * (a[1] - y) + t * (b[1] - y)),
                            twice * out * outwards.weights[i] * along.weights[j]});
        }
    }
  }
  return points;
}

// E(r) of a rough mirror as the sum over all pairs of pupil points. Pairs differ by amplitudes, phases, and
// the coherence H of their positions on the mirror (PHYSICS 6).
class AllPairs {
 public:
  AllPairs(const Mirror& mirror, const Aperture& aperture, const RadialPsd& psd, double dz,
           const std::function<double(double, double)>& departure, int across,
           const std::vector<double>& radii) {
    const double f = mirror.focal_length, rim = aperture_radius(aperture);
    struct Point {
      double x, y, q, amplitude, phase;
      std::size_t segment;
      std::array<double, 2> from_centre;  // from the centre of its segment, times q
    };
    std::optional<Segments> segments;
    if (has_segment_errors(aperture)) segments.emplace(std::get<SegmentedAperture>(aperture));
    const double piston2 = segments ? std::pow(segments->piston(), 2) : 0,
                 tilt2 = segments ? std::pow(segments->tip_tilt(), 2) : 0;
    std::vector<Point> points;
    double light = 0;
    for (const AreaPoint& place : points_on(aperture, across)) {
      const double t2 = (place.x * place.x + place.y * place.y) / (4 * f * f), q = 1 / (1 + t2),
                   c = (1 - t2) / (1 + t2);
      const double height = departure ? departure(place.x, place.y) : 0;
      const double phase = 2 * pi / kLambda * ((1 + c) * height + dz * (1 - c) / (1 + dz / f));
      // Even illumination of the mirror has the amplitude 1/(q sqrt(c)) over P.
      Point point{q * place.x, q * place.y, q, place.area * q * std::sqrt(c), phase, 0, {}};
      if (segments) {
        point.segment = segments->at(place.x, place.y);
        const auto& centre = segments->all()[point.segment].centre;
        point.from_centre = {q * (place.x - centre[0]), q * (place.y - centre[1])};
      }
      points.push_back(point);
      light += place.area;
    }
    const double g2 = std::pow(4 * pi / kLambda, 2), variance = std::pow(psd_moments(psd).rms_height(), 2);
    constexpr int kSteps = 4000;
    const double reach = 1.3 * 2 * rim;
    const Eigen::ArrayXd less =
        structure_function(psd, Eigen::ArrayXd::LinSpaced(kSteps + 1, 0.0, reach)) * g2;
    energies_.assign(radii.size(), 0);
    std::vector<double> shear, weight, z, j0, j1;
    for (std::size_t m = 0; m < points.size(); ++m) {
      shear.clear();
      weight.clear();
      for (std::size_t n = 0; n < m; ++n) {
        const Point &one = points[m], &two = points[n];
        const double on_mirror = std::hypot(one.x / one.q - two.x / two.q, one.y / one.q - two.y / two.q);
        const double place = on_mirror / reach * kSteps;
        const auto k = Eigen::Index(place);
        const double e = less[k] + (place - double(k)) * (less[k + 1] - less[k]);
        // Variance of the path difference that segment errors cause.
        const auto of_one = [&](const Point& p) {
          return p.q * p.q * piston2 +
                 tilt2 * (std::pow(p.from_centre[0], 2) + std::pow(p.from_centre[1], 2));
        };
        const double apart = one.segment == two.segment
                                 ? std::pow(one.q - two.q, 2) * piston2 +
                                       tilt2 * (std::pow(one.from_centre[0] - two.from_centre[0], 2) +
                                                std::pow(one.from_centre[1] - two.from_centre[1], 2))
                                 : of_one(one) + of_one(two);
        const double h = std::exp(-one.q * two.q * e - 0.5 * std::pow(one.q - two.q, 2) * g2 * variance -
                                  0.5 * g2 * apart);
        shear.push_back(std::max(1e-9, std::hypot(one.x - two.x, one.y - two.y)));
        weight.push_back(2 * one.amplitude * two.amplitude * std::cos(one.phase - two.phase) * h);
      }
      for (std::vector<double>* all : {&z, &j0, &j1}) all->resize(shear.size());
      for (std::size_t r = 0; r < radii.size(); ++r) {
        const double u = 2 * pi * radii[r] / (kLambda * (f + dz));
        for (std::size_t k = 0; k < z.size(); ++k) z[k] = u * shear[k];
        bessel_j0_j1(z.data(), int(z.size()), j0.data(), j1.data());
        for (std::size_t k = 0; k < z.size(); ++k) energies_[r] += weight[k] * u * j1[k] / shear[k];
        energies_[r] += 0.5 * u * u * points[m].amplitude * points[m].amplitude;
        if (m + 1 == points.size()) energies_[r] /= 2 * pi * light;
      }
    }
  }
  const std::vector<double>& energies() const { return energies_; }

 private:
  std::vector<double> energies_;
};

struct PairCase {
  const char* name;
  Aperture aperture;
  double f_number, waves, coma;  // waves: of defocus; coma: amplitude of the Zernike, in waves of height
  int across = 24;               // points across a triangle
};

// A square with four vanes of 1/40 of its size, and 18 hexagons with gaps of 1/20 of their size.
const Aperture kVanes =
    obstructed(RectangleAperture{0.28, 0.28},
               {{0.01, pi / 4, 0}, {0.01, 3 * pi / 4, 0}, {0.01, -pi / 4, 0}, {0.01, -3 * pi / 4, 0}});
const Aperture kSegments = hexagonal_segments(2, 0.07, 0.0035, false, 0);

Aperture erring(double piston, double tip_tilt) {
  SegmentedAperture result = std::get<SegmentedAperture>(kSegments);
  result.piston = piston;
  result.tip_tilt = tip_tilt;
  return result;
}

TEST_WITH_SHORT_FORM(PupilLight, IsTheSumOverAllPairsOfPoints) {
  const std::vector<PairCase> cases{{"hexagon", kHexagon, 2, 0, 0},
                                    {"hexagon", kHexagon, 2, 0.8, 0},
                                    {"rectangle", kRectangle, 2, 0, 0},
                                    {"rectangle", kRectangle, 7, 1, 0},
                                    {"hexagon", kHexagon, 1.5, 0, 0},
                                    {"circle", kCircle, 3, 0, 0.15},
                                    {"hexagon", kHexagon, 3, 0.5, 0.15},
                                    {"vanes", kVanes, 2, 0.5, 0, 14},
                                    {"segments", kSegments, 1.75, 0.3, 0, 5},
                                    {"pistons", erring(60e-9, 0), 1.75, 0, 0, 6},
                                    {"tilts", erring(40e-9, 1e-6), 1.75, 0.3, 0, 6}};
  for (const PairCase& one : test::all_or_few(whole, cases, {1, 5, 9})) {
    const Mirror mirror{one.f_number * kDiameter, -1, {}};
    const RadialPsd psd(GaussianPsd{60e-9, 0.12});
    std::function<double(double, double)> departure;
    if (one.coma != 0)
      departure = [&](double x, double y) {
        const double r2 = (x * x + y * y) / (0.04 * kDiameter * kDiameter * 6.25);
        return one.coma * kLambda * std::sqrt(8.0) * (3 * r2 - 2) * x / 0.2;
      };
    const double dz = plane_of(one.waves, one.f_number);
    const GeneralisedHarveyShack light(psd, mirror, one.aperture, kLambda, {.departure = departure});
    const MeanSpot spot = light.at_plane(dz);
    const std::vector<double> fractions{0.2, 0.5, 0.8};
    std::vector<double> radii;
    for (const double fraction : fractions) radii.push_back(spot.encircled_energy_radius(fraction));
    const AllPairs few(mirror, one.aperture, psd, dz, departure, one.across, radii),
        more(mirror, one.aperture, psd, dz, departure, one.across + one.across / 4, radii);
    for (std::size_t k = 0; k < radii.size(); ++k) {
      EXPECT_NEAR(few.energies()[k], more.energies()[k], 1e-5) << one.name;
      EXPECT_NEAR(more.energies()[k], fractions[k], 1e-4)
          << one.name << " f/" << one.f_number << ' ' << one.waves << ' ' << one.coma;
    }
  }
}

// A smooth mirror far out of focus against rays; the tolerance is the effect of the rim's fringes.
TEST(PupilLight, FarOutOfFocusIsThatOfTheRays) {
  const RadialPsd smooth(GaussianPsd{1e-13, 0.02});
  for (const auto& [aperture, phase] :
       {std::pair{kRectangle, 400.0}, {kHexagon, 600.0}, {kCircle, 1500.0}, {kAnnulus, 1500.0}}) {
    const double f = 8 * kDiameter, dz = plane_of(phase / (2 * pi), 8);
    const MeanSpot spot = GeneralisedHarveyShack(smooth, Mirror{f, -1, {}}, aperture, kLambda).at_plane(dz);
    const std::vector<RadialNode> rays = radial_quadrature(aperture, 4000);
    for (const double part : {0.45, 0.7, 0.95}) {
      double inside = 0;
      for (const RadialNode& ray : rays) {
        const double t = ray.rho / (2 * f);
        // tan of the ray's angle, times the distance from the focus.
        if (2 * t / (1 - t * t) * dz < part * dz / 16) inside += ray.weight;
      }
      EXPECT_NEAR(spot.encircled_energy(part * dz / 16), inside, 0.3 / std::sqrt(phase) * part)
          << phase << ' ' << part;
    }
  }
}

// Both sides of the switch of a round pupil to its focal irradiance, at fractions of the blur radius.
TEST(PupilMoments, GoOverFromTheOverlapToTheLightWithoutAStep) {
  const Mirror mirror{1.2, -1, {}};  // f/3
  const GeneralisedHarveyShack smooth(RadialPsd(GaussianPsd{1e-12, 0.01}), mirror, kCircle, kLambda);
  const PupilField field = field_of(kCircle, 3);
  const MomentBasis basis(1);
  double low = 1e-3, high = 1e-1;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (low + high);
    (PupilOverlap(field, middle, basis).turn(2 * field.outer()) < 1500 ? low : high) = middle;
  }
  const double step = 1e-9;
  const MeanSpot one = smooth.at_plane(low - step), other = smooth.at_plane(high + step);
  for (const double part : {0.1, 0.3, 0.6, 0.8, 1.2}) {
    const double radius = part * low / 6;
    EXPECT_NEAR(one.encircled_energy(radius), other.encircled_energy(radius), 3e-5) << part;
  }
}

TEST(PupilMoments, RefuseAPhaseThatNoGridHolds) {
  for (const auto& [aperture, waves] : {std::pair{kHexagon, 1000.0}, {kCircle, 20000.0}}) {
    const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{1e-12, 0.01}), Mirror{3.2, -1, {}}, aperture,
                                       kLambda);
    EXPECT_THROW(light.at_plane(plane_of(waves, 8)), ComputationError);
  }
}

// A core of 1e-7 of the energy is most of the irradiance on the axis of a rough mirror. Out of focus and with
// aberrations it must be that of the focus of a perfect mirror.
TEST(ExactTransfer, KeepsAWeakCoreOfAnyMirror) {
  constexpr double kHeight = 4, kLength = 2e-5;
  const RadialPsd psd(GaussianPsd{kHeight * kLambda / (4 * pi), kLength});
  for (const Aperture& aperture : {Aperture(CircleAperture{0.1}), Aperture(RectangleAperture{0.08, 0.06})}) {
    const GeneralisedHarveyShack perfect(psd, Mirror{1, -1, {}}, aperture, kLambda),
        conic(psd, Mirror{1, -0.9999, {}}, aperture, kLambda);
    const double axis = perfect.at_plane(0).irradiance(0);
    EXPECT_NEAR(perfect.at_plane(1e-7).irradiance(0) / axis, 1, 1e-3);
    EXPECT_NEAR(conic.at_plane(0).irradiance(0) / axis, 1, 1e-3);
    const double core = std::exp(-kHeight * kHeight) * aperture_area(aperture) / std::pow(kLambda, 2);
    EXPECT_GT(core, 0.2 * axis);
  }
}

// A mirror so far from its parabola that its full overlap, with hundreds of waves, is out of reach. The
// roughness leaves a core of 2e-5, so the mean spot needs only short shears. Reference: Simpson's rule.
TEST(ExactTransfer, TakesShortShearsOfManyWaves) {
  constexpr double kHeight = 3.28, kLength = 2e-4, kFocalLength = 8;  // g; m
  const double sigma = kHeight * kLambda / (4 * pi), dz = 0.01;
  const Mirror mirror{kFocalLength, 2000, {}};
  const PupilField field(mirror, kCircle, kLambda, {});
  const MomentBasis basis(1);
  const PupilOverlap overlap(field, dz, basis);
  ASSERT_GT(overlap.turn(kDiameter), 1500);
  const GeneralisedHarveyShack light(RadialPsd(GaussianPsd{sigma, kLength}), mirror, kCircle, kLambda);
  const MeanSpot spot = light.at_plane(dz);
  constexpr int kShears = 401;
  const double end = 3.2 * kLength, step = end / (kShears - 1);
  Eigen::ArrayXd seen(kShears);
  for (int k = 0; k < kShears; ++k)  // f/20: all heights count fully
    seen[k] =
        overlap(k * step).sum() * std::exp(kHeight * kHeight * std::expm1(-std::pow(k * step / kLength, 2)));
  for (const double fraction : {0.2, 0.5, 0.8, 0.95}) {
    const double radius = spot.encircled_energy_radius(fraction);
    const double u = 2 * pi * radius / (kLambda * (kFocalLength + dz));
    double sum = 0;
    for (int k = 0; k < kShears; ++k) {
      const double weight = k == 0 || k + 1 == kShears ? 1 : k % 2 == 1 ? 4 : 2, z = u * k * step;
      double j0 = 0, j1 = 0;
      bessel_j0_j1(&z, 1, &j0, &j1);
      sum += weight * seen[k] * j1;
    }
    EXPECT_NEAR(u * sum * step / 3, fraction, 2e-4) << fraction;
  }
}

}  // namespace
}  // namespace aberfit::internal
