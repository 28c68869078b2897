// Compares pupils of direction cosines (PHYSICS 6) with sums over the mirror, exact rays and PHYSICS 5.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/trace/ray_bundle.h"
#include "aberfit/waves/diffraction_psf.h"
#include "short_form.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi, kWave = 1e-6;

struct MirrorNode {
  double x, y, area;
};

// Gauss-Legendre over the triangles between the vertex and the edges of a polygon around it.
std::vector<MirrorNode> polygon_nodes(const std::vector<std::array<double, 2>>& corners) {
  const Quadrature rule = gauss_legendre(48, 0.0, 1.0);
  std::vector<MirrorNode> nodes;
  for (std::size_t e = 0; e < corners.size(); ++e) {
    const auto &a = corners[e], &b = corners[(e + 1) % corners.size()];
    const double twice = std::abs(a[0] * b[1] - a[1] * b[0]);
    for (int i = 0; i < 48; ++i)
      for (int j = 0; j < 48; ++j) {
        const double u = rule.nodes[i], v = rule.nodes[j];
        nodes.push_back({u * (a[0] + v * (b[0] - a[0])), u * (a[1] + v * (b[1] - a[1])),
                         rule.weights[i] * rule.weights[j] * u * twice});
      }
  }
  return nodes;
}
std::vector<MirrorNode> disc_nodes(double inner, double outer) {
  const Quadrature rule = gauss_legendre(64, inner, outer);
  std::vector<MirrorNode> nodes;
  constexpr int kSpokes = 160;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < kSpokes; ++j) {
      const double r = rule.nodes[i], angle = 2 * kPi * j / kSpokes;
      nodes.push_back({r * std::cos(angle), r * std::sin(angle), rule.weights[i] * r * 2 * kPi / kSpokes});
    }
  return nodes;
}

// Energy fraction per area at (X, Y, f + dz) from spherical waves of every point of the mirror, at height
// z(x, y), by their exact path. Each wave falls with the distance from the focus and with the root of the
// cosine of its angle there. So the energy through the plane is all that the mirror reflects.
double kirchhoff(const std::vector<MirrorNode>& nodes, double f, double dz, double X, double Y,
                 const std::function<double(double, double)>& error) {
  std::complex<double> sum = 0;
  double area = 0;
  for (const MirrorNode& n : nodes) {
    const double sag = (n.x * n.x + n.y * n.y) / (4 * f), z = sag + error(n.x, n.y);
    const double away = f + sag, cosine = (f - sag) / away;
    const double path =
        std::sqrt((n.x - X) * (n.x - X) + (n.y - Y) * (n.y - Y) + (f + dz - z) * (f + dz - z)) - z - (f + dz);
    sum += n.area * std::sqrt(cosine) / away * std::polar(1.0, 2 * kPi / kWave * path);
    area += n.area;
  }
  return std::norm(sum) / (kWave * kWave * area) / ((1 + dz / f) * (1 + dz / f));
}

struct ExactCase {
  const char* name;
  double f;
  Aperture aperture;
  std::vector<MirrorNode> nodes;
};
std::vector<ExactCase> exact_cases() {
  const std::vector<std::array<double, 2>> square{
      {-0.01, -0.008}, {0.01, -0.008}, {0.01, 0.008}, {-0.01, 0.008}};
  const std::vector<std::array<double, 2>> pentagon{
      {-0.009, -0.007}, {0.008, -0.01}, {0.011, 0.004}, {0.001, 0.01}, {-0.008, 0.006}};
  return {{"f/1 circle", 0.02, CircleAperture{0.02}, disc_nodes(0, 0.01)},
          {"f/3 annulus", 0.06, AnnulusAperture{0.02, 0.008}, disc_nodes(0.004, 0.01)},
          {"f/1.25 rectangle", 0.025, RectangleAperture{0.02, 0.016}, polygon_nodes(square)},
          {"f/1.5 pentagon", 0.03, PolygonAperture{pentagon}, polygon_nodes(pentagon)}};
}

// A smooth surface error, sampled well by the nodes of the sum.
double smooth_error(double x, double y) {
  return 90e-9 * std::sin(260 * x + 130 * y) + 60e-9 * std::cos(300 * y - 90 * x);
}

// Remaining errors: the grid and, out of focus, the path to second order in t^2 dz/f. Largest: 1e-5 in focus,
// 7e-4 of the peak at f/1 with two waves of defocus.
TEST(ApertureExact, IntensityIsThatOfSphericalWavesFromTheMirror) {
  for (const ExactCase& c : exact_cases()) {
    const double unit = kWave * c.f / 0.02;  // lambda F
    const DiffractionPupil pupil = diffraction_pupil(c.aperture, c.f, 0.02 / 128);
    for (const bool rough : {false, true}) {
      const auto error = [&](double x, double y) { return rough ? smooth_error(x, y) : 0.0; };
      Eigen::ArrayXd height(pupil.sample.size());
      for (Eigen::Index k = 0; k < height.size(); ++k)
        height[k] = error(pupil.sample.x[k], pupil.sample.y[k]);
      for (const double waves : {0.0, 1.5, -2.0}) {
        const double dz = waves * 8 * kWave * std::pow(c.f / 0.02, 2);
        const PsfImage image = diffraction_psf({pupil, c.f, kWave}, height, {4 * unit, 0.8 * unit, dz});
        const double peak = image.intensity.maxCoeff();
        double worst = 0;
        for (Eigen::Index row = 0; row < image.intensity.rows(); ++row)
          for (Eigen::Index column = 0; column < image.intensity.cols(); ++column) {
            const double truth = kirchhoff(c.nodes, c.f, dz, image.first + double(column) * image.pitch,
                                           image.first + double(row) * image.pitch, error);
            worst = std::max(worst, std::abs(image.intensity(row, column) - truth) / peak);
          }
        RecordProperty(std::string(c.name) + (rough ? " rough " : " ") + std::to_string(waves),
                       std::to_string(worst));
        EXPECT_LT(worst, 1.5e-3) << c.name << (rough ? ", rough" : "") << ", " << waves << " waves";
      }
    }
  }
}

TEST(ApertureExact, CellsHoldTheAreaOfTheMirror) {
  for (const ExactCase& c : exact_cases())
    for (const double cells : {50.0, 101.0}) {
      const DiffractionPupil pupil = diffraction_pupil(c.aperture, c.f, 0.02 / cells);
      const double cell = std::pow(0.02 / cells, 2), area = aperture_area(c.aperture);
      EXPECT_NEAR(pupil.total * cell, area, 1e-12 * area) << c.name;
      // int |A|^2 = int A A^2/A. `amplitude` is right to third order for any smooth field, so also for A.
      Eigen::ArrayXd root(pupil.sample.size());
      for (Eigen::Index k = 0; k < root.size(); ++k) {
        const double t2 = (std::pow(pupil.sample.x[k], 2) + std::pow(pupil.sample.y[k], 2)) / (4 * c.f * c.f);
        EXPECT_NEAR(pupil.obliquity[k], 1 / (1 + t2), 1e-12);
        root[k] = std::sqrt(std::pow(1 + t2, 3) / (1 - t2));
      }
      EXPECT_NEAR((pupil.amplitude * root).sum() * cell, area, 3 * std::pow(cells, -3.0) * area) << c.name;
      EXPECT_NEAR(pupil.sample.weight.sum(), 1, 1e-12);
    }
  EXPECT_THROW(diffraction_pupil(CircleAperture{1.0}, 0.25, 0.01), ComputationError);
  EXPECT_THROW(diffraction_pupil(CircleAperture{1.0}, 1.0, 0.01, {0.7, 0}), ComputationError);
}

// A smooth surface of given RMS height in wavelengths; its radii by wave optics and by exact rays.
struct DrawBothWays {
  double f;
  Aperture aperture;
  TermSet terms;
  Eigen::VectorXd coefficients;

  DrawBothWays(double focal_length, Aperture of, double rms, std::uint64_t seed)
      : f(focal_length), aperture(std::move(of)) {
    terms.radius = aperture_radius(aperture);
    terms.zernike = zernike_modes(2, 7);
    const CoefficientPrior prior = make_prior(
        terms, RadialPsd(UniformPsd{rms, 0.3 / terms.radius, 0.9 / terms.radius}), CovarianceKind::kFull);
    coefficients = prior.colour(draw_white(prior.size(), seed));
  }
  Eigen::VectorXd by_waves(const std::vector<Statistic>& statistics, int cells, bool exact) const {
    const DiffractionPupil pupil =
        diffraction_pupil(aperture, exact ? f : kParaxial, 2 * terms.radius / cells);
    SurfaceField field;
    SurfaceOperator(terms, pupil.sample, {2, {}, {}, true}).apply(coefficients, &field);
    Eigen::VectorXd values;
    evaluate_diffraction({pupil, f, kWave}, field.height, statistics, 2, nullptr, &values, nullptr);
    return values;
  }
  Eigen::VectorXd by_rays(const std::vector<Statistic>& statistics) const {
    const PupilSample pupil = make_pupil(aperture, {PupilLayout::kSobol, 1 << 18, 1});
    SurfaceField field;
    SurfaceOperator(terms, pupil, {2, {}, {}}).apply(coefficients, &field);
    Mirror mirror;
    mirror.focal_length = f;
    return evaluate_exact({trace(mirror, pupil, field), trace_nominal(mirror, pupil), field.height},
                          statistics, 2);
  }
};

// Mean relative difference of encircled-energy radii from those of rays.
double difference(const Eigen::VectorXd& waves, const Eigen::VectorXd& rays) {
  return (waves.array() / rays.array() - 1).mean();
}

TEST_WITH_SHORT_FORM(ApertureExact, SmoothDrawsFocusLikeTheirExactRaysAndTheMoreSoTheSteeper) {
  const double radius = 0.05;
  const std::vector<std::array<double, 2>> hexagon{
      {0.05, 0},  {0.025, 0.0433012701892219},   {-0.025, 0.0433012701892219},
      {-0.05, 0}, {-0.025, -0.0433012701892219}, {0.025, -0.0433012701892219}};
  struct Case {
    double f_number;
    Aperture aperture;
  };
  const std::vector<Case> cases{Case{1.25, CircleAperture{2 * radius}},
                                Case{2.5, AnnulusAperture{2 * radius, 0.03}},
                                Case{1.25, RectangleAperture{0.08, 0.06}},
                                Case{1.5, PolygonAperture{hexagon}}, Case{7.0, CircleAperture{2 * radius}}};
  for (const Case& c : test::all_or_few(whole, cases, {0, 3})) {
    const double f = c.f_number * 2 * aperture_radius(c.aperture);
    Eigen::ArrayXd exact(2), paraxial(2);
    for (int k = 0; k < 2; ++k) {
      const DrawBothWays draw(f, c.aperture, (k == 0 ? 2 : 12) * kWave, 5);
      const Eigen::VectorXd spot = draw.by_rays({EncircledEnergyRadius{0.9, 0}});
      // In focus, and where the cone is a third as wide as the spot.
      const double dz = 0.3 * spot[0] * f / radius;
      std::vector<Statistic> statistics;
      for (const double fraction : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9})
        for (const double plane : {0.0, dz, -dz})
          statistics.push_back(EncircledEnergyRadius{fraction, plane});
      const Eigen::VectorXd rays = draw.by_rays(statistics);
      const int cells = k == 0 ? 256 : 1024;
      exact[k] = difference(draw.by_waves(statistics, cells, true), rays);
      paraxial[k] = difference(draw.by_waves(statistics, cells, false), rays);
    }
    RecordProperty("f/" + std::to_string(c.f_number), std::to_string(exact[0]) + " " +
                                                          std::to_string(exact[1]) + " paraxial " +
                                                          std::to_string(paraxial[1]));
    // Diffraction widens the spot in proportion to 1/g, six times less for the second surface. The remainder
    // at infinite g is the error of the theory; it is below 3e-4.
    EXPECT_LT(std::abs(exact[1]), 0.25 * std::abs(exact[0]))
        << "f/" << c.f_number << ' ' << c.aperture.index();
    EXPECT_LT(std::abs(exact[1] - (exact[0] - exact[1]) / 5), 6e-4) << "f/" << c.f_number;
    if (c.f_number < 2) {
      EXPECT_LT(paraxial[1], exact[1] - 1e-2) << "f/" << c.f_number;
    }
  }
}

// PHYSICS 5: standard deviations 2 f s tangential, 2 f s (1 + t^2)/(1 - t^2) radial; mean over the aperture.
double section_5_radius(double fraction, double f, double radius, bool exact) {
  const Quadrature over_area = gauss_legendre(32, 0.0, 1.0);
  const auto inside = [&](double r) {
    double sum = 0;
    for (int i = 0; i < 32; ++i) {
      const double t2 = exact ? over_area.nodes[i] * radius * radius / (4 * f * f) : 0;
      const double a = 1, b = (1 + t2) / (1 - t2);  // in units of 2 f s
      double mean = 0;
      for (int j = 0; j < 64; ++j) {
        const double angle = 2 * kPi * (j + 0.5) / 64;
        const double q = std::pow(std::cos(angle) / a, 2) + std::pow(std::sin(angle) / b, 2);
        mean += (1 - std::exp(-0.5 * r * r * q)) / (q * a * b) / 64;
      }
      sum += over_area.weights[i] * mean;
    }
    return sum;
  };
  double low = 0, high = 20;
  for (int i = 0; i < 60; ++i) (inside(0.5 * (low + high)) < fraction ? low : high) = 0.5 * (low + high);
  return low;
}

// Realisations differ by several percent, but the ratio of exact to paraxial radii does not.
TEST_WITH_SHORT_FORM(ApertureExact, RoughDrawsSpreadByTheApertureExactIntegrals) {
  const double radius = 0.05;
  for (const double f_number : test::all_or_few(whole, std::vector{1.25, 2.5}, {0})) {
    const double f = f_number * 2 * radius;
    const std::vector<double> fractions{0.5, 0.8, 0.9};
    std::vector<Statistic> statistics;
    for (const double p : fractions) statistics.push_back(EncircledEnergyRadius{p, 0});
    Eigen::ArrayXd exact = Eigen::ArrayXd::Zero(3), paraxial = exact;
    const int draws = whole ? 12 : 4;
    for (int seed = 1; seed <= draws; ++seed) {
      DrawBothWays draw(f, CircleAperture{2 * radius}, kWave, std::uint64_t(seed));
      draw.terms.zernike = zernike_modes(2, 24);
      const CoefficientPrior prior =
          make_prior(draw.terms, RadialPsd(UniformPsd{2 * kWave, 10, 50}), CovarianceKind::kFull);
      draw.coefficients = prior.colour(draw_white(prior.size(), std::uint64_t(seed)));
      exact += draw.by_waves(statistics, 768, true).array();
      paraxial += draw.by_waves(statistics, 768, false).array();
    }
    for (int k = 0; k < 3; ++k) {
      const double p = fractions[std::size_t(k)];
      const double expected = section_5_radius(p, f, radius, true) / section_5_radius(p, f, radius, false);
      RecordProperty("f/" + std::to_string(f_number) + " EE" + std::to_string(p),
                     std::to_string(exact[k] / paraxial[k]) + " expected " + std::to_string(expected));
      EXPECT_NEAR(exact[k] / paraxial[k], expected, 0.2 * (expected - 1)) << f_number << ' ' << p;
    }
  }
}

}  // namespace
}  // namespace aberfit
