// Height, slope and scatter of term surfaces against closed forms and 200 digits, on any grid.
#include "aberfit/forward/term_moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/scene/quadrature_pupil.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/trace/ray_bundle.h"
#include "short_form.h"
#include "terms/zernike_exact.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2.0, kRadius = 0.2, kPi = std::numbers::pi;
// The promised error; 2e-13 was seen.
constexpr double kPromised = 1e-11;

struct Surface {
  TermSet terms;
  Eigen::VectorXd coefficients;
};

// Every `every`-th mode of 2 <= n <= n_max, each with a random coefficient of about 1e-9 m/n.
Surface some_modes(int n_max, int every, std::uint64_t seed) {
  Surface surface;
  surface.terms.radius = kRadius;
  const std::vector<ZernikeMode> all = zernike_modes(2, n_max);
  for (std::size_t j = seed % std::size_t(every); j < all.size(); j += std::size_t(every))
    surface.terms.zernike.push_back(all[j]);
  if (surface.terms.zernike.back().n < n_max) surface.terms.zernike.push_back({n_max, n_max % 2});
  const RandomStream stream(seed, "term-moments-test");
  surface.coefficients.resize(surface.terms.size());
  for (Eigen::Index j = 0; j < surface.coefficients.size(); ++j)
    surface.coefficients[j] =
        1e-9 / surface.terms.zernike[std::size_t(j)].n * stream.normal(std::uint64_t(j));
  return surface;
}

// Heights are orthonormal on their own disc. Of two modes of the same signed m, the lower order has a
// Laplacian orthogonal to the other, so Green's theorem leaves the rim. There R = 1 and R' = (n (n + 2) -
// m^2)/2 of the lower. The mean product of the gradients is sqrt((n + 1)(n' + 1)) (n_min (n_min + 2) -
// m^2)/R^2.
TermMoments on_the_disc(const Surface& s) {
  double height = 0, slope = 0;
  for (std::size_t j = 0; j < s.terms.zernike.size(); ++j) {
    const ZernikeMode a = s.terms.zernike[j];
    height += std::pow(s.coefficients[Eigen::Index(j)], 2);
    for (std::size_t k = 0; k < s.terms.zernike.size(); ++k) {
      const ZernikeMode b = s.terms.zernike[k];
      if (a.m != b.m) continue;
      const double least = std::min(a.n, b.n);
      slope += s.coefficients[Eigen::Index(j)] * s.coefficients[Eigen::Index(k)] *
               std::sqrt((a.n + 1.0) * (b.n + 1.0)) * (least * (least + 2) - double(a.m) * a.m);
    }
  }
  return {std::sqrt(height), std::sqrt(slope / 2) / kRadius};
}

// On an annulus, in 200 digits: R = rho^m q(s), s = rho^2, so integrals over the area are those of
// polynomials.
TermMoments on_an_annulus(const Surface& surface, double inner) {
  using zernike_exact::Real;
  using Polynomial = std::vector<Real>;  // of s
  const auto product = [](const Polynomial& a, const Polynomial& b) {
    Polynomial result(a.size() + b.size() - 1, Real(0));
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t k = 0; k < b.size(); ++k) result[i + k] += a[i] * b[k];
    return result;
  };
  const Real low = Real(inner) * inner / (Real(kRadius) * kRadius);
  const auto mean = [&](const Polynomial& p, int power) {  // of s^power p
    Real sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const int n = int(i) + power + 1;
      if (n > 0) sum += p[i] * (1 - pow(low, n)) / n;  // n = 0 has no coefficient: m = 0 starts at s
    }
    return sum / (1 - low);
  };
  std::map<int, Polynomial> heights;  // by signed m: the sum over n
  for (std::size_t j = 0; j < surface.terms.zernike.size(); ++j) {
    const zernike_exact::Radial radial = zernike_exact::radial(surface.terms.zernike[j]);
    Polynomial& sum = heights[surface.terms.zernike[j].m];
    if (sum.size() < radial.coefficient.size()) sum.resize(radial.coefficient.size(), Real(0));
    for (std::size_t i = 0; i < radial.coefficient.size(); ++i)
      sum[i] += Real(surface.coefficients[Eigen::Index(j)]) * radial.coefficient[i];
  }
  Real height = 0, slope = 0;
  for (const auto& [signed_m, q] : heights) {
    const int m = std::abs(signed_m);
    const Real of_angle = m == 0 ? Real(1) : Real(1) / 2;
    height += of_angle * mean(product(q, q), m);
    if (m == 0) height -= pow(mean(q, 0), 2);
    Polynomial along(q.size());  // rho^(1-m) dR/drho = m q + 2 s q'
    for (std::size_t i = 0; i < q.size(); ++i) along[i] = (m + 2 * int(i)) * q[i];
    slope += of_angle * (mean(product(along, along), m - 1) + m * m * mean(product(q, q), m - 1));
  }
  return {double(sqrt(height)), double(sqrt(slope / 2)) / kRadius};
}

void expect_same(const TermMoments& found, const TermMoments& expected) {
  EXPECT_NEAR(found.rms_height / expected.rms_height, 1, kPromised);
  EXPECT_NEAR(found.rms_slope_per_axis / expected.rms_slope_per_axis, 1, kPromised);
}

TEST(TermMoments, OfZernikesOnTheirDiscAreTheClosedForms) {
  for (const int n_max : {2, 9, 24, 40, 60}) {
    const Surface surface = some_modes(n_max, 1, 3);
    expect_same(*term_moments(CircleAperture{2 * kRadius}, surface.terms, surface.coefficients),
                on_the_disc(surface));
  }
}

TEST(TermMoments, OfZernikesOnAnAnnulusAreThoseOf200Digits) {
  for (const int n_max : {5, 18, 40, 60})
    for (const double inner : {0.03, 0.12}) {
      const Surface surface = some_modes(n_max, n_max < 10 ? 1 : 5, 4);
      expect_same(*term_moments(AnnulusAperture{2 * kRadius, 2 * inner}, surface.terms, surface.coefficients),
                  on_an_annulus(surface, inner));
    }
}

// Mean of cos 2 pi q.x over the aperture: 2 J1(u)/u on a circle, the product of two sinc on a rectangle.
double transform(const Aperture& aperture, double qx, double qy) {
  if (const auto* rectangle = std::get_if<RectangleAperture>(&aperture)) {
    const auto sinc = [](double u) { return u == 0 ? 1.0 : std::sin(u) / u; };
    return sinc(kPi * qx * rectangle->width) * sinc(kPi * qy * rectangle->height);
  }
  const double u = 2 * kPi * std::hypot(qx, qy) * aperture_radius(aperture);
  return u == 0 ? 1.0 : 2 * std::cyl_bessel_j(1.0, u) / u;
}

TEST(TermMoments, OfWavesUpTo60CyclesAcrossAreTheClosedForms) {
  for (const Aperture& aperture : {Aperture(CircleAperture{0.4}), Aperture(RectangleAperture{0.4, 0.25})})
    for (const double cycles : {1.0, 9.0, 60.0}) {
      Surface surface;
      const RandomStream stream(5, "waves");
      const double highest = cycles / (2 * aperture_radius(aperture));
      for (int i = 0; i < 6; ++i) {
        const double angle = 2 * kPi * stream.uniform_pair(std::uint64_t(i))[0], f = highest * (1 - 0.15 * i);
        surface.terms.fourier.push_back({f * std::cos(angle), f * std::sin(angle)});
      }
      surface.coefficients.resize(surface.terms.size());
      for (Eigen::Index j = 0; j < surface.coefficients.size(); ++j)
        surface.coefficients[j] = 1e-8 * stream.normal(std::uint64_t(100 + j));
      double squares = 0, mean = 0, slopes = 0;
      for (std::size_t i = 0; i < surface.terms.fourier.size(); ++i) {
        const FourierMode f = surface.terms.fourier[i];
        const double a = surface.coefficients[Eigen::Index(2 * i)],
                     b = surface.coefficients[Eigen::Index(2 * i + 1)];
        mean += a * transform(aperture, f.fx, f.fy);
        for (std::size_t k = 0; k < surface.terms.fourier.size(); ++k) {
          const FourierMode g = surface.terms.fourier[k];
          const double c = surface.coefficients[Eigen::Index(2 * k)],
                       d = surface.coefficients[Eigen::Index(2 * k + 1)];
          const double minus = transform(aperture, f.fx - g.fx, f.fy - g.fy),
                       plus = transform(aperture, f.fx + g.fx, f.fy + g.fy);
          const double cosines = 0.5 * (minus + plus), sines = 0.5 * (minus - plus);
          squares += a * c * cosines + b * d * sines;
          slopes += 4 * kPi * kPi * (f.fx * g.fx + f.fy * g.fy) * (a * c * sines + b * d * cosines);
        }
      }
      expect_same(*term_moments(aperture, surface.terms, surface.coefficients),
                  {std::sqrt(squares - mean * mean), std::sqrt(slopes / 2)});
    }
}

// Root mean square and mean of the angle between two unit vectors by another rule, three times as fine, and
// by the one-mode-at-a-time Zernikes.
std::pair<double, double> angles(const Mirror& mirror, const Surface& surface, double inner) {
  const int n_max = surface.terms.zernike.back().n;
  const Quadrature radial = gauss_legendre(3 * n_max + 40, inner * inner, kRadius * kRadius);
  const int spokes = 7 * n_max + 41;
  double squares = 0, sum = 0;
  for (Eigen::Index i = 0; i < radial.nodes.size(); ++i)
    for (int k = 0; k < spokes; ++k) {
      const double angle = 2 * kPi * (k + 0.5) / spokes, rho = std::sqrt(radial.nodes[i]);
      const double x = rho * std::cos(angle), y = rho * std::sin(angle);
      const SurfacePoint<double> base = base_surface(mirror, x, y);
      double p = base.slope_x, q = base.slope_y;
      for (std::size_t j = 0; j < surface.terms.zernike.size(); ++j) {
        const ZernikeValue z = zernike(surface.terms.zernike[j], x / kRadius, y / kRadius);
        p += surface.coefficients[Eigen::Index(j)] / kRadius * z.dx;
        q += surface.coefficients[Eigen::Index(j)] / kRadius * z.dy;
      }
      // Half the angle between the rays is that between the normals, except for the turn out of their plane.
      // It is exact from the chord of the two directions of PHYSICS 1.
      const auto direction = [](double a, double b) {
        const double g2 = a * a + b * b;
        return std::array<double, 3>{-2 * a / (1 + g2), -2 * b / (1 + g2), (1 - g2) / (1 + g2)};
      };
      const auto u = direction(p, q), v = direction(base.slope_x, base.slope_y);
      const double chord = std::hypot(u[0] - v[0], u[1] - v[1], u[2] - v[2]);
      const double turned = 2 * std::asin(chord / 2), weight = radial.weights[i] / spokes;
      squares += weight * turned * turned;
      sum += weight * turned;
    }
  const double area = kRadius * kRadius - inner * inner;
  return {std::sqrt(squares / area), sum / area};
}

FreshStatistics seen(const Mirror& mirror, const Aperture& aperture, const Surface& surface,
                     const FreshPupil& pupil, const std::vector<Statistic>& statistics) {
  return statistics_with_error({mirror, aperture, 632.8e-9, Centre::kNominal}, pupil, surface.terms,
                               surface.coefficients, statistics, 2, nullptr);
}

// The grids have at most a few cells per cycle, and the rays are few, because moments do not depend on them.
TEST_WITH_SHORT_FORM(TermMoments, ReachEveryModelWhateverItsGrid) {
  Mirror mirror{kFocal, -0.9, {}};
  mirror.zernike = {{{2, 2}, 100e-9}, {{3, 1}, 60e-9}};
  mirror.zernike_radius = kRadius;
  const std::vector<Statistic> moments{RmsHeight{}, ScatterRms{}, ScatterMean{}};
  for (const double inner : {0.0, 0.08})
    for (const int n_max : test::all_or_few(whole, std::vector{7, 40, 60}, {0, 1})) {
      const Aperture aperture = inner > 0 ? Aperture(AnnulusAperture{2 * kRadius, 2 * inner})
                                          : Aperture(CircleAperture{2 * kRadius});
      const Surface surface = some_modes(n_max, n_max < 10 ? 1 : 60, 6);
      const auto [rms, mean] = angles(mirror, surface, inner);
      const double height = on_an_annulus(surface, inner).rms_height;
      for (const FreshPupil& pupil :
           {FreshPupil{FocusModel::kRays, 256, 3, 0}, FreshPupil{FocusModel::kWaves, 0, 1, kRadius / 32}}) {
        const FreshStatistics found = seen(mirror, aperture, surface, pupil, moments);
        EXPECT_NEAR(found.value[0] / height, 1, kPromised) << to_string(pupil.model) << n_max;
        EXPECT_NEAR(found.value[1] / rms, 1, 1e-9) << to_string(pupil.model) << n_max;  // cancelling chords
        EXPECT_NEAR(found.value[2] / mean, 1, 5 * kMeanAngleError) << to_string(pupil.model) << n_max;
        EXPECT_EQ(found.standard_error[0], 0);
        EXPECT_EQ(found.standard_error[1], 0);
        EXPECT_GE(found.standard_error[2], kMeanAngleError * found.value[2]);
      }
    }
}

// The mean angle has kinks; its stated error is a root mean square over surfaces.
TEST_WITH_SHORT_FORM(TermMoments, MeanAngleErrsAsStated) {
  const Mirror mirror{kFocal, -1, {}};
  PolygonAperture hexagon;
  for (int i = 0; i < 6; ++i)
    hexagon.vertices.push_back({kRadius * std::cos(i * kPi / 3), kRadius * std::sin(i * kPi / 3)});
  double squares = 0;
  int looks = 0;
  for (const Aperture& aperture :
       {Aperture(CircleAperture{2 * kRadius}), Aperture(AnnulusAperture{2 * kRadius, 0.1}),
        Aperture(RectangleAperture{0.3, 0.2}), Aperture(hexagon)})
    for (const int n_max : {6, 12, 24, 40})
      for (std::uint64_t seed = 1; seed <= (whole ? 3 : 1); ++seed, ++looks) {
        const Surface surface = some_modes(n_max, 1, seed);
        const auto mean_by = [&](const PupilSample& pupil) {
          const SurfaceOperator on(surface.terms, pupil, {});
          return focus_statistics({mirror, pupil, on}, surface.coefficients, {ScatterMean{}}, 2, nullptr)[0];
        };
        const double found = mean_by(*mean_angle_pupil(aperture, surface.terms)),
                     fine = mean_by(quadrature_pupil(aperture, 14 * n_max + 150));
        squares += std::pow(found / fine - 1, 2);
      }
  const double error = std::sqrt(squares / looks);
  RecordProperty("error_in_millionths", int(1e6 * error));
  EXPECT_LT(error, 1.5 * kMeanAngleError);
  EXPECT_GT(error, kMeanAngleError / 3);
}

// Waves of thousands of cycles across would need more points than memory holds. The points of the statistics
// then give the moments, with their error.
TEST(TermMoments, AreLeftToTheRaysWhereTheOrderIsOutOfReach) {
  Surface surface;
  surface.terms.fourier = {{20000, 0}, {0, 9000}};
  surface.coefficients = Eigen::VectorXd::Constant(4, 1e-12);
  const Aperture circle = CircleAperture{2 * kRadius};
  EXPECT_FALSE(moment_pupil(circle, surface.terms).has_value());
  EXPECT_FALSE(mean_angle_pupil(circle, surface.terms).has_value());
  EXPECT_FALSE(term_moments(circle, surface.terms, surface.coefficients).has_value());
  const FreshStatistics found = seen(Mirror{kFocal, -1, {}}, circle, surface,
                                     {FocusModel::kRays, 1 << 15, 3, 0}, {RmsHeight{}, ScatterRms{}});
  EXPECT_GT(found.standard_error[0], 0);
  EXPECT_NEAR(found.value[0], std::sqrt(2.0) * 1e-12, 6 * found.standard_error[0] + 1e-3 * found.value[0]);
}

// Statistics by rays use only the points inside the margin.
TEST(TermMoments, OfRaysAreThoseInsideTheMargin) {
  const Surface surface = some_modes(12, 1, 8);
  const Mirror mirror{kFocal, -1, {}};
  constexpr double kMargin = 0.02;
  const auto height = [&](const Aperture& aperture, FocusModel model) {
    return seen(mirror, aperture, surface, {model, 4096, 3, kRadius / 40}, {RmsHeight{}}).value[0];
  };
  const Aperture with = CircleAperture{2 * kRadius, kMargin}, whole = CircleAperture{2 * kRadius},
                 part = CircleAperture{2 * (kRadius - kMargin)};
  EXPECT_EQ(height(with, FocusModel::kRays), height(part, FocusModel::kRays));
  EXPECT_EQ(height(with, FocusModel::kWaves), height(whole, FocusModel::kWaves));
  EXPECT_GT(std::abs(height(whole, FocusModel::kRays) / height(part, FocusModel::kRays) - 1), 1e-3);
}

}  // namespace
}  // namespace aberfit
