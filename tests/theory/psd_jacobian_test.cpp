// Derivatives of statistics over the parameters of a PSD, against differences in more digits than double.
#include "aberfit/theory/psd_jacobian.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "ghs_in_many_digits.h"
#include "short_form.h"

using namespace aberfit;
using namespace aberfit::many_digits;

namespace {

using Wide = long double;  // 64 bits: sixth-order differences by 1e-3 keep 15 digits

// Allowed error of d ln(statistic)/d ln(parameter), and a floor for values near zero.
constexpr double kAgreed = 1e-8, kNothing = 1e-2;

// So slow that the paraxial truth agrees with the aperture-exact form to 1/(32 N^2) = 1.4e-10.
const Scene kScene{1500, 0.1, 500e-9};
constexpr double kOut = 540;  // 0.4 waves of defocus
constexpr double kRing = 9e-3, kBandwidth = 1.5e-3;

// Statistics of the focus, of one plane, across planes and of the surface.
const std::vector<Statistic> kStatistics{EncircledEnergyRadius{0.5, 0},
                                         EncircledEnergyRadius{0.8, kOut},
                                         RingThrough{kRing, 0, false},
                                         RingThrough{kRing, kOut, false},
                                         SpotFwhm{kBandwidth},
                                         RmsHeight{},
                                         ScatterRms{},
                                         ScatterMean{},
                                         StrehlRatio{},
                                         ModulationTransfer{40},  // 0.3 of the cutoff
                                         EnsquaredThrough{kRing, 0},
                                         EnsquaredThrough{kRing, kOut}};
// For rings the truth has its peak in the focus; the theory's peak is there only to 3e-7.
const Scene kShallow{150, 0.1, 500e-9};
constexpr double kAgreedOfRings = 1e-6;
const std::vector<Statistic> kRings{RingFwhm{0.5, 0.1 * kRing}, RingFwhm{0.5, {}}};

// near: the value in double, where the search starts.
template <class Real>
Real value_in(const Paraxial<Real>& truth, const Statistic& statistic, double near) {
  if (const auto* radius = std::get_if<EncircledEnergyRadius>(&statistic))
    return truth.radius(Real(radius->fraction), Real(radius->dz), Real(near));
  if (const auto* through = std::get_if<RingThrough>(&statistic))
    return truth.encircled(Real(through->ring_radius), Real(through->dz));
  if (const auto* spot = std::get_if<SpotFwhm>(&statistic))
    return truth.spot_fwhm(Real(spot->bandwidth), Real(near));
  if (const auto* width = std::get_if<RingFwhm>(&statistic)) {
    const Real ring = width->ring_radius
                          ? Real(*width->ring_radius)
                          : truth.radius(Real(width->ring_fraction), Real(0), Real(0.1 * kRing));
    return truth.half_plane(ring, Real(0.5 * near)) - truth.half_plane(ring, Real(-0.5 * near));
  }
  if (const auto* square = std::get_if<EnsquaredThrough>(&statistic))
    return truth.ensquared(Real(square->side), Real(square->dz));
  if (const auto* transfer = std::get_if<ModulationTransfer>(&statistic))
    return truth.modulation(Real(transfer->frequency));
  if (std::holds_alternative<StrehlRatio>(statistic)) return truth.strehl();
  // Angles are proportional to the slope, for any mirror.
  return std::holds_alternative<RmsHeight>(statistic) ? truth.rms_height() : truth.rms_slope();
}

template <class Real>
std::vector<Real> values_in(const Paraxial<Real>& truth, const std::vector<Statistic>& statistics,
                            const Eigen::VectorXd& near) {
  std::vector<Real> all;
  for (const Statistic& statistic : statistics)
    all.push_back(value_in(truth, statistic, near[Eigen::Index(all.size())]));
  return all;
}

/// A PSD model and the same roughness written independently. factors: in the order of psd_variables.
template <class Real>
struct Family {
  PsdModel model;
  std::function<Roughness<Real>(const std::vector<Real>& factors)> roughness;
};

template <class Real>
double worst_of(const Family<Real>& family, const std::vector<Statistic>& statistics, const Scene& scene,
                double* worst_value) {
  const GhsPupil pupil(Mirror{scene.focal_length, -1, {}}, CircleAperture{scene.diameter}, scene.wavelength);
  const std::vector<PsdVariable> variables = psd_variables(family.model);
  const PsdJacobian found = psd_jacobian(family.model, variables, statistics, pupil);
  const Eigen::MatrixXd logarithmic = found.logarithmic();
  double worst = 0;
  const std::vector<Real> none(variables.size(), Real(1));
  const std::vector<Real> here =
      values_in(Paraxial<Real>(scene, family.roughness(none)), statistics, found.values);
  for (std::size_t i = 0; i < statistics.size(); ++i)
    if (kind_of(statistics[i]).dimension != Dimension::kAngle)
      *worst_value = std::max(*worst_value, std::abs(found.values[Eigen::Index(i)] / double(here[i]) - 1));
  for (std::size_t k = 0; k < variables.size(); ++k) {
    std::vector<std::vector<Real>> sides;
    const Real step = 1e-3;
    for (const int side : {-3, -2, -1, 1, 2, 3}) {
      std::vector<Real> factors = none;
      factors[k] = exp(side * step);
      sides.push_back(values_in(Paraxial<Real>(scene, family.roughness(factors)), statistics, found.values));
    }
    for (std::size_t i = 0; i < statistics.size(); ++i) {
      const Real difference =
          45 * (sides[3][i] - sides[2][i]) - 9 * (sides[4][i] - sides[1][i]) + (sides[5][i] - sides[0][i]);
      const double expected = double(difference / (60 * step) / here[i]);
      const double is = logarithmic(Eigen::Index(i), Eigen::Index(k));
      const double off = std::abs(is - expected) / std::max(std::abs(expected), kNothing);
      EXPECT_LE(off, std::holds_alternative<RingFwhm>(statistics[i]) ? kAgreedOfRings : kAgreed)
          << pointer_of(variables[k]) << " of " << statistic_name(statistics[i]) << ": " << is
          << ", expected " << expected;
      worst = std::max(worst, off);
    }
  }
  return worst;
}

template <class Real>
void expect_agreement(const Family<Real>& family, const std::vector<Statistic>& statistics = kStatistics,
                      const Scene& scene = kScene) {
  double worst_value = 0;
  const double worst = worst_of(family, statistics, scene, &worst_value);
  EXPECT_LE(worst_value, 1e-9 + 1 / (16 * std::pow(scene.focal_length / scene.diameter, 2)));
  testing::Test::RecordProperty("worst_derivative_in_1e_12", std::to_string(worst * 1e12));
  testing::Test::RecordProperty("worst_value_in_1e_12", std::to_string(worst_value * 1e12));
}

constexpr double kCycles = 3;  // of f_max = 30 /m across the aperture

// int S d2f over a band.
template <class Real>
Real variance(const std::function<Real(const Real&)>& shape, const Real& low, const Real& high) {
  Real sum = 0;
  for (const Node<Real>& w : nodes<Real>(log(low), log(high), 2)) {
    const Real f = exp(w.x);
    sum += 2 * pi<Real>() * f * f * w.weight * shape(f);
  }
  return sum;
}

template <class Real>
Roughness<Real> with_rms(const std::function<Real(const Real&)>& shape, const Real& rms, const Real& low,
                         const Real& high) {
  const Real factor = rms * rms / variance<Real>(shape, low, high);
  return by_quadrature<Real>([=](const Real& f) { return factor * shape(f); }, {low, high}, kCycles);
}

Roughness<Wide> sum_of(const Roughness<Wide>& one, const Roughness<Wide>& two) {
  return {[=](const Wide& x) { return one.half_structure(x) + two.half_structure(x); },
          one.slope_variance + two.slope_variance};
}

Roughness<Wide> k_correlation(Wide rms, Wide B, Wide exponent, Wide low, Wide high) {
  return with_rms<Wide>([=](const Wide& f) { return std::pow(1 + B * B * f * f, -exponent / 2); }, rms, low,
                        high);
}

}  // namespace

TEST(PsdJacobian, OfAKCorrelationMeetsDifferencesInMoreDigits) {
  expect_agreement<Wide>({KCorrelationPsd{40e-9, 0.06, 3.2, 8, 30}, [](const std::vector<Wide>& by) {
                            return k_correlation(40e-9L * by[0], 0.06L * by[1], 3.2L * by[2], 8 * by[3],
                                                 30 * by[4]);
                          }});
}

TEST(PsdJacobian, OfRingsThroughTheFocusMeetsDifferencesInMoreDigits) {
  expect_agreement<Wide>({UniformPsd{30e-9, 9, 30},
                          [](const std::vector<Wide>& by) {
                            return with_rms<Wide>([](const Wide&) { return Wide(1); }, 30e-9L * by[0],
                                                  9 * by[1], 30 * by[2]);
                          }},
                         kRings, kShallow);
}

TEST(PsdJacobian, OfPowerLawsMeetsDifferencesInMoreDigits) {
  expect_agreement<Wide>({PowerLawPsd{30e-9, {}, 2.6, 10, 30}, [](const std::vector<Wide>& by) {
                            const Wide b = 2.6L * by[1];
                            return with_rms<Wide>([=](const Wide& f) { return std::pow(f, -b); },
                                                  30e-9L * by[0], 10 * by[2], 30 * by[3]);
                          }});
  expect_agreement<Wide>({PowerLawPsd{{}, 1e-16, 2.2, 10, 30}, [](const std::vector<Wide>& by) {
                            const Wide a = 1e-16L * by[0], b = 2.2L * by[1];
                            return by_quadrature<Wide>([=](const Wide& f) { return a * std::pow(f, -b); },
                                                       {10 * by[2], 30 * by[3]}, kCycles);
                          }});
}

TEST(PsdJacobian, OfATableMeetsDifferencesInMoreDigits) {
  const TablePsd table{{8, 13, 21, 30}, {4e-19, 2.5e-19, 3e-20, 1e-20}};
  expect_agreement<Wide>({table, [=](const std::vector<Wide>& by) {
                            const auto psd = [=](const Wide& f) {
                              std::size_t i = 0;
                              while (i + 2 < 4 && f > table.frequency[i + 1]) ++i;
                              const Wide low = by[i] * Wide(table.psd[i]),
                                         high = by[i + 1] * Wide(table.psd[i + 1]);
                              const Wide t = std::log(f / Wide(table.frequency[i])) /
                                             std::log(Wide(table.frequency[i + 1]) / table.frequency[i]);
                              return Wide(low * std::pow(high / low, t));
                            };
                            return by_quadrature<Wide>(psd, {8, 13, 21, 30}, kCycles);
                          }});
}

TEST(PsdJacobian, OfASumMeetsDifferencesInMoreDigits) {
  const SumPsd sum{{KCorrelationPsd{30e-9, 0.05, 3.5, 8, 30}, GaussianPsd{15e-9, 0.02}}};
  expect_agreement<Wide>(
      {sum, [](const std::vector<Wide>& by) {
         const Wide rms = 15e-9L * by[5], l = 0.02L * by[6];
         const Roughness<Wide> gaussian{
             [=](const Wide& x) { return -rms * rms * std::expm1(-(x / l) * (x / l)); },
             4 * rms * rms / (l * l)};
         return sum_of(k_correlation(30e-9L * by[0], 0.05L * by[1], 3.5L * by[2], 8 * by[3], 30 * by[4]),
                       gaussian);
       }});
}

// Closed form with Bessel functions of the second kind; the band is open at both ends.
TEST(PsdJacobian, OfAnOpenKCorrelationMeetsDifferencesOfItsClosedForm) {
  expect_agreement<Wide>(
      {KCorrelationPsd{30e-9, 0.2, 5.3}, [](const std::vector<Wide>& by) {
         const Wide rms = 30e-9L * by[0], B = 0.2L * by[1], exponent = 5.3L * by[2], nu = exponent / 2 - 1;
         return Roughness<Wide>{[=](const Wide& x) {
                                  const Wide a = 2 * pi<Wide>() * x / B;
                                  return rms * rms *
                                         (1 - 2 / boost::math::tgamma(nu) * std::pow(a / 2, nu) *
                                                  boost::math::cyl_bessel_k(nu, a));
                                },
                                4 * pi<Wide>() * pi<Wide>() * rms * rms / (B * B * (exponent / 2 - 2))};
       }});
}

// Fifty digits confirm that eighteen are enough; a uniform band needs only J1.
TEST_WITH_SHORT_FORM(PsdJacobian, OfAUniformBandMeetsDifferencesInFiftyDigits) {
  using Fifty =
      boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>, boost::multiprecision::et_off>;
  const Fifty rms = 35e-9, low = 12, high = 30;
  const auto roughness = [&](const std::vector<Fifty>& by) -> Roughness<Fifty> {
    const Fifty s = rms * by[0], a = low * by[1], b = high * by[2];
    const auto disc = [](const Fifty& f, const Fifty& x) {
      const Fifty z = 2 * pi<Fifty>() * f * x;
      return Fifty(f * f * (1 - 2 * boost::math::cyl_bessel_j(1, z) / z));
    };
    return {[=](const Fifty& x) { return Fifty(s * s * (disc(b, x) - disc(a, x)) / (b * b - a * a)); },
            2 * pi<Fifty>() * pi<Fifty>() * s * s * (a * a + b * b)};
  };
  const GhsPupil pupil(Mirror{kScene.focal_length, -1, {}}, CircleAperture{kScene.diameter},
                       kScene.wavelength);
  const PsdModel model = UniformPsd{35e-9, 12, 30};
  const std::vector<PsdVariable> variables = psd_variables(model);
  const PsdJacobian found =
      psd_jacobian(model, variables, {RingThrough{kRing, 0, false}, RmsHeight{}, ScatterRms{}}, pupil);
  const Eigen::MatrixXd logarithmic = found.logarithmic();
  for (std::size_t k = whole ? 0 : 2; k < variables.size(); ++k) {
    const auto moved = [&](const Fifty& factor) {
      std::vector<Fifty> by(3, Fifty(1));
      by[k] = factor;
      const Paraxial<Fifty> truth(kScene, roughness(by), 2);
      return std::array<Fifty, 3>{log(truth.encircled(kRing, 0)), log(truth.rms_height()),
                                  log(truth.rms_slope())};
    };
    std::array<std::array<Fifty, 3>, 6> at;
    const Fifty step = Fifty(1) / 1000;
    for (int i = 0; i < 6; ++i) at[std::size_t(i)] = moved(exp(step * (i < 3 ? i - 3 : i - 2)));
    for (std::size_t i = 0; i < 3; ++i) {
      const Fifty expected =
          (45 * (at[3][i] - at[2][i]) - 9 * (at[4][i] - at[1][i]) + at[5][i] - at[0][i]) / (60 * step);
      EXPECT_NEAR(logarithmic(Eigen::Index(i), Eigen::Index(k)), double(expected),
                  kAgreed * std::max(std::abs(double(expected)), kNothing))
          << pointer_of(variables[k]) << " " << i;
    }
  }
}

// In and out of focus, for spots without a closed form.
TEST(PsdJacobian, OfAnAnnulusAndOfARectangleMeetsDifferencesInMoreDigits) {
  const auto annulus = [](const Wide& x, const Wide& turn) {
    return annulus_overlap<Wide>(0.05L, 0.018L, x, turn * x);
  };
  const auto rectangle = [](const Wide& x, const Wide& turn) {
    return rectangle_overlap<Wide>(0.08L, 0.06L, x, turn);
  };
  struct Case {
    Aperture aperture;
    std::vector<Wide> edges;
    ParaxialOf<Wide>::Overlap overlap;
    Wide area;
  };
  const Case cases[] = {
      {AnnulusAperture{0.1, 0.036},
       {0, 0.032L, 0.036L, 0.068L, 0.1L},
       annulus,
       pi<Wide>() * (0.05L * 0.05L - 0.018L * 0.018L)},
      {RectangleAperture{0.08, 0.06}, {0, 0.06L, 0.08L, 0.1L}, rectangle, 0.0048L},
  };
  const PsdModel model = KCorrelationPsd{40e-9, 0.06, 3.2, 8, 30};
  const std::vector<PsdVariable> variables = psd_variables(model);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, kOut},
                                          RingThrough{kRing, 0, false}, RingThrough{kRing, kOut, false},
                                          RmsHeight{}};
  double worst = 0;
  for (const Case& one : cases) {
    const GhsPupil pupil(Mirror{kScene.focal_length, -1, {}}, one.aperture, kScene.wavelength);
    const PsdJacobian found = psd_jacobian(model, variables, statistics, pupil);
    const bool by_light = std::holds_alternative<RectangleAperture>(one.aperture);
    const Eigen::MatrixXd logarithmic = found.logarithmic();
    const auto logs = [&](std::size_t k, Wide factor) {
      std::vector<Wide> by(variables.size(), 1);
      by[k] = factor;
      const ParaxialOf<Wide> truth(
          kScene, one.edges, one.overlap, one.area,
          k_correlation(40e-9L * by[0], 0.06L * by[1], 3.2L * by[2], 8 * by[3], 30 * by[4]));
      std::vector<Wide> result;
      for (const Eigen::Index i : {0, 1})
        result.push_back(std::log(truth.radius(i == 0 ? 0.5L : 0.8L, i == 0 ? 0 : kOut, found.values[i])));
      result.push_back(std::log(truth.encircled(kRing, 0)));
      result.push_back(std::log(truth.encircled(kRing, kOut)));
      result.push_back(std::log(truth.rms_height()));
      return result;
    };
    const std::vector<Wide> here = logs(0, 1);
    for (std::size_t i = 0; i < here.size(); ++i)
      EXPECT_NEAR(found.values[Eigen::Index(i)] / double(std::exp(here[i])), 1, by_light ? 2e-5 : 1e-9) << i;
    for (std::size_t k = 0; k < variables.size(); ++k) {
      const Wide step = 1e-3L;
      std::vector<std::vector<Wide>> at;
      for (const int side : {-3, -2, -1, 1, 2, 3}) at.push_back(logs(k, std::exp(side * step)));
      for (std::size_t i = 0; i < here.size(); ++i) {
        const auto expected = double(
            (45 * (at[3][i] - at[2][i]) - 9 * (at[4][i] - at[1][i]) + at[5][i] - at[0][i]) / (60 * step));
        const double is = logarithmic(Eigen::Index(i), Eigen::Index(k));
        const double off = std::abs(is - expected) / std::max(std::abs(expected), kNothing);
        EXPECT_LE(off, by_light ? 2e-6 : kAgreed)
            << pointer_of(variables[k]) << " of " << statistic_name(statistics[i]) << ": " << is
            << ", expected " << expected;
        worst = std::max(worst, off);
      }
    }
  }
  RecordProperty("worst_derivative_in_1e_12", std::to_string(worst * 1e12));
}

// Polygons have only the aperture-exact form. The references are differences of the theory, and the same
// rectangle, whose moments average over other directions (kMeanMoments).
TEST(PsdJacobian, OfAPolygonMeetsDifferencesOfTheTheory) {
  const Mirror mirror{1.2, -1, {}};
  const PsdModel model = KCorrelationPsd{40e-9, 0.06, 3.2, 8, 60};
  const std::vector<PsdVariable> variables = psd_variables(model);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 1e-4},
                                          RingThrough{1e-5, 0, false}, RmsHeight{}};
  const GhsPupil polygon(mirror,
                         PolygonAperture{{{-0.08, -0.06}, {0.08, -0.06}, {0.08, 0.06}, {-0.08, 0.06}}},
                         kScene.wavelength),
      rectangle(mirror, RectangleAperture{0.16, 0.12}, kScene.wavelength);
  const PsdJacobian found = psd_jacobian(model, variables, statistics, polygon),
                    same = psd_jacobian(model, variables, statistics, rectangle);
  EXPECT_LT((found.values.array() / same.values.array() - 1).abs().maxCoeff(), 3e-6);
  EXPECT_LT((found.logarithmic() - same.logarithmic()).array().abs().maxCoeff(), 5e-5);
  for (std::size_t k = 0; k < variables.size(); ++k)
    for (std::size_t i = 0; i < statistics.size(); ++i) {
      const auto moved = [&](double factor) {
        const PsdModel other = with_value(model, variables[k], factor * value_of(model, variables[k]));
        return std::log(GeneralisedHarveyShack(RadialPsd(other), polygon).predict({statistics[i]})[0]);
      };
      EXPECT_NEAR(found.logarithmic()(Eigen::Index(i), Eigen::Index(k)), log_derivative<double>(moved, 3e-3),
                  kAgreed)
          << pointer_of(variables[k]) << " of " << statistic_name(statistics[i]);
    }
}

// The aperture-exact form of a slow mirror, where the theory's interpolation is exact to 1e-10.
TEST(PsdJacobian, OfTheApertureExactFormMeetsDifferencesInMoreDigits) {
  const Scene scene{12, 0.2, 500e-9};
  const Mirror mirror{scene.focal_length, -1, {}};
  const GhsPupil pupil(mirror, CircleAperture{scene.diameter}, scene.wavelength);
  const PsdModel model = GaussianPsd{45e-9, 0.012};
  const std::vector<PsdVariable> variables = psd_variables(model);
  for (const double dz : {0.0, 8e-3}) {
    const std::vector<Statistic> radius{EncircledEnergyRadius{0.7, dz}};
    const PsdJacobian found = psd_jacobian(model, variables, radius, pupil);
    const auto moved = [&](std::size_t k, Wide factor) {
      const Wide rms = 45e-9L * (k == 0 ? factor : 1), l = 0.012L * (k == 1 ? factor : 1);
      const Roughness<Wide> gaussian{
          [=](const Wide& x) { return -rms * rms * std::expm1(-(x / l) * (x / l)); }, 0};
      return std::log(Exact<Wide>(scene, gaussian, rms * rms, dz).radius(0.7L, found.values[0]));
    };
    EXPECT_NEAR(double(std::exp(moved(0, 1))) / found.values[0], 1, 1e-9) << dz;
    for (std::size_t k = 0; k < 2; ++k) {
      const double expected =
          double(log_derivative<Wide>([&](const Wide& factor) { return moved(k, factor); }, 1e-3L));
      EXPECT_NEAR(found.logarithmic()(0, Eigen::Index(k)) / expected, 1, kAgreed)
          << pointer_of(variables[k]) << " " << dz;
    }
  }
}

// A fast annular mirror with a band edge that is softened far out, against differences of the theory.
TEST(PsdJacobian, OfAFastMirrorMeetsDifferencesOfTheTheory) {
  const GhsPupil pupil(Mirror{2.4, -1, {}}, AnnulusAperture{1.2, 0.36}, 550e-9);
  const PsdModel model = KCorrelationPsd{17e-9, 0.3, 3, 1, 100};
  const std::vector<Statistic> radius{EncircledEnergyRadius{0.8, 0}};
  const std::vector<PsdVariable> variables = psd_variables(model);
  const PsdJacobian found = psd_jacobian(model, variables, radius, pupil);
  for (std::size_t k = 0; k < variables.size(); ++k) {
    const auto moved = [&](double factor) {
      const PsdModel other = with_value(model, variables[k], factor * value_of(model, variables[k]));
      return std::log(GeneralisedHarveyShack(RadialPsd(other), pupil).predict(radius)[0]);
    };
    const double expected = log_derivative<double>(moved, 3e-4);  // a dark ring passes: r bends within 1e-2
    EXPECT_NEAR(found.logarithmic()(0, Eigen::Index(k)), expected, 2e-8 * std::max(1.0, std::abs(expected)))
        << pointer_of(variables[k]);
  }
}

// Waves longer than ten apertures tilt the mirror; the ends of this band lie on either side of that.
TEST(PsdJacobian, OfWavesLongerThanTheApertureMeetsDifferencesOfTheTheory) {
  constexpr double kAcross = 0.2;
  const GhsPupil pupil(Mirror{1.3 * kAcross, -1, {}}, CircleAperture{kAcross}, 1e-6);
  const std::vector<Statistic> inside{RingThrough{2e-6, 0, false}, RingThrough{2e-6, 4e-6, false}};
  for (const bool by_rms : {false, true})
    for (const double f_min : {0.02, 0.3}) {
      PowerLawPsd model;
      model.exponent = 3.3;
      model.f_min = f_min / kAcross;
      model.f_max = 40 / kAcross;
      (by_rms ? model.rms : model.amplitude) = by_rms ? (f_min < 0.1 ? 1.5e-6 : 3e-7) : 6e-16;
      const std::vector<PsdVariable> variables = psd_variables(model);
      const PsdJacobian found = psd_jacobian(model, variables, inside, pupil);
      for (std::size_t k = 0; k < variables.size(); ++k)
        for (std::size_t i = 0; i < inside.size(); ++i) {
          const auto moved = [&](double factor) {
            const PsdModel other = with_value(model, variables[k], factor * value_of(model, variables[k]));
            return std::log(GeneralisedHarveyShack(RadialPsd(other), pupil).predict({inside[i]})[0]);
          };
          const double expected = log_derivative<double>(moved, 1e-3),
                       is = found.logarithmic()(Eigen::Index(i), Eigen::Index(k));
          EXPECT_NEAR(is, expected, 1e-7 * std::max(1.0, std::abs(expected)))
              << pointer_of(variables[k]) << " " << f_min << (by_rms ? " rms" : " amplitude");
        }
    }
}

TEST(PsdJacobian, ASharedSceneGivesTheSameBits) {
  const Mirror mirror{2.8, -0.9, {}};
  const AnnulusAperture aperture{0.4, 0.1};
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 1e-4},
                                          SpotFwhm{1e-6}, RmsHeight{}};
  const GhsPupil shared(mirror, aperture, 632.8e-9);
  for (const double rms : {200e-9, 10e-9, 60e-9, 10e-9}) {  // in any order of earlier calls
    const RadialPsd psd(UniformPsd{rms, 2.5, 20});
    const Eigen::VectorXd alone = GeneralisedHarveyShack(psd, mirror, aperture, 632.8e-9).predict(statistics),
                          together = GeneralisedHarveyShack(psd, shared).predict(statistics, 2);
    EXPECT_TRUE((alone.array() == together.array()).all()) << rms;
  }
}

TEST(PsdJacobian, LightThatDoesNotScatterHasNoDerivative) {
  // Roughness above 1/lambda has height but does not scatter.
  const PsdModel model = SumPsd{{UniformPsd{20e-9, 10, 60}, UniformPsd{5e-9, 3e6, 4e6}}};
  const GhsPupil pupil(Mirror{5, -1, {}}, CircleAperture{0.1}, 500e-9);
  const PsdVariable above{"rms", {1}, 0};
  const PsdJacobian found = psd_jacobian(model, {above}, {EncircledEnergyRadius{0.8, 0}, RmsHeight{}}, pupil);
  EXPECT_EQ(found.derivatives(0, 0), 0);
  EXPECT_NEAR(found.derivatives(1, 0), 5e-9 / found.values[1], 1e-9);
}

TEST(PsdJacobian, KnowsTheNumbersOfAModel) {
  const PsdModel model = SumPsd{
      {KCorrelationPsd{1e-9, 0.1, 3}, TablePsd{{1, 2}, {1e-20, 1e-21}}, PowerLawPsd{{}, 1e-20, 2, 1, 9}}};
  std::vector<std::string> pointers;
  for (const PsdVariable& one : psd_variables(model)) pointers.push_back(pointer_of(one));
  EXPECT_EQ(pointers, (std::vector<std::string>{"/parts/0/rms", "/parts/0/B", "/parts/0/exponent",
                                                "/parts/1/psd/0", "/parts/1/psd/1", "/parts/2/amplitude",
                                                "/parts/2/exponent", "/parts/2/f_min", "/parts/2/f_max"}));
  EXPECT_EQ(psd_variable(model, "/parts/1/scale").key, "scale");
  EXPECT_THROW(psd_variable(model, "/parts/0/f_max"), std::invalid_argument);
  const PsdModel taller = with_value(model, psd_variable(model, "/parts/1/scale"), 3);
  EXPECT_EQ(std::get<TablePsd>(std::get<SumPsd>(taller).parts[1]).psd[1], 9e-21);
}

// Hundreds of cycles across the aperture. The softened edge moves with f_max and shows near its ring.
TEST(PsdJacobian, OfASoftenedEdgeMeetsDifferencesOfTheTheory) {
  const double f_max = 800, edge = 632.8e-9 * 2.8 * f_max;
  const GhsPupil pupil(Mirror{2.8, -1, {}}, CircleAperture{0.4}, 632.8e-9);
  const PsdModel model = UniformPsd{30e-9, 2.5, f_max};
  const std::vector<Statistic> shares{RingThrough{0.995 * edge, 0, false},
                                      RingThrough{1.005 * edge, 0, false}};
  const PsdVariable variable{"f_max", {}, 0};
  const PsdJacobian found = psd_jacobian(model, {variable}, shares, pupil);
  for (const Eigen::Index i : {0, 1}) {
    const auto moved = [&](double factor) {
      const PsdModel other = with_value(model, variable, factor * f_max);
      return GeneralisedHarveyShack(RadialPsd(other), pupil).predict(shares)[i];
    };
    const double expected =
        log_derivative<double>(moved, 4e-5);  // the phase of the edge changes by 2000 rad over its shear

    EXPECT_NEAR(found.derivatives(i, 0) * f_max, expected, kAgreed * std::max(std::abs(expected), kNothing))
        << i << " " << found.values[i];
  }
}

// Turbulence without an outer scale. Radii of a wide aperture go with 1/r0, and r0 with the amplitude to the
// power -3/5 (PHYSICS 6). The derivative over the exponent is compared with differences of the theory.
TEST(PsdJacobian, OfKolmogorovRoughnessFollowsTheFriedParameter) {
  const double wavelength = 1e-6, diameter = 1e6, r0 = diameter / 1e4;
  const double amplitude =
      0.02289558710855518 * std::pow(r0, -5.0 / 3) * std::pow(wavelength / (4 * std::numbers::pi), 2);
  const PsdModel model = PowerLawPsd{{}, amplitude, 11.0 / 3, 0, 1e3 / r0};
  const GhsPupil pupil(Mirror{1e9, -1, {}}, CircleAperture{diameter}, wavelength);
  const std::vector<Statistic> radii{EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 0}};
  const std::vector<PsdVariable> variables{{"amplitude", {}, 0}, {"exponent", {}, 0}};
  const Eigen::MatrixXd found = psd_jacobian(model, variables, radii, pupil).logarithmic();
  for (const Eigen::Index i : {0, 1}) {
    EXPECT_NEAR(found(i, 0), 0.6, 2e-4) << "a finite aperture: 1e-4 of the radius";
    for (const Eigen::Index k : {0, 1}) {
      const PsdVariable& variable = variables[std::size_t(k)];
      const auto moved = [&](double factor) {
        const PsdModel other = with_value(model, variable, factor * value_of(model, variable));
        return std::log(GeneralisedHarveyShack(RadialPsd(other), pupil).predict(radii)[i]);
      };
      const double expected = log_derivative<double>(moved, 1e-3);
      EXPECT_NEAR(found(i, k), expected, 2e-8 * std::max(1.0, std::abs(expected))) << i << " " << k;
    }
  }
}

// Roughness with so short a correlation length that its scatter misses the focus: Strehl exp(-g^2).
TEST(PsdJacobian, OfShortRoughnessTheStrehlRatioIsTheSpecularShare) {
  const double wavelength = 500e-9, rms = 25e-9, g = 4 * std::numbers::pi * rms / wavelength;
  const GhsPupil pupil(Mirror{5000, -1, {}}, CircleAperture{0.1}, wavelength);
  const double middle = 0.01 * wavelength * 5000 / 0.1;  // of the Airy pattern
  const std::vector<Statistic> share{RingThrough{middle, 0, false}};
  const PsdModel model = GaussianPsd{rms, 10e-6};
  const PsdJacobian found = psd_jacobian(model, psd_variables(model), share, pupil);
  const double perfect =
      GeneralisedHarveyShack(RadialPsd(GaussianPsd{1e-18, 10e-6}), pupil).predict(share)[0];
  // The halo adds about g^2 (2 l/D)^2 of the peak: 1e-7.
  EXPECT_NEAR(found.values[0] / perfect / std::exp(-g * g), 1, 1e-6);
  EXPECT_NEAR(found.logarithmic()(0, 0), -2 * g * g, 1e-6);
  EXPECT_NEAR(found.logarithmic()(0, 1), 0, 1e-6);
}
