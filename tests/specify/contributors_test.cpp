// Tests several surfaces, atmosphere and image motion, each against its own law.
#include "aberfit/specify/contributors.h"

#include <fftw3.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {
namespace {

using std::numbers::pi;

const std::string kPsd =
    R"({"model": "k-correlation", "rms": "20 nm", "B": "0.1 m", "exponent": 2.8, "f_min": "5 /m", "f_max": "100 /m"})";

Specification solved(const std::string& with,
                     const std::string& so_that = R"({"ee80_diameter": "<= 2 arcsec"})") {
  return run_solve(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "0.4 m"}, "roughness": {"psd": )" +
                      kPsd + R"(}, "solve": {"for": ["/roughness/psd/rms"], "so_that": )" + so_that +
                      (with.empty() ? "" : R"(, "with": )" + with) + "}}",
                  "study.json"),
      {});
}

const Eigen::ArrayXd kShears = Eigen::ArrayXd::LinSpaced(12, 0.01, 0.4);

TEST(Contributors, TwoEqualSurfacesAreOneOfSqrtTwo) {
  const Specification one = solved(""),
                      two = solved(R"({"surfaces": [{"name": "twin", "psd": )" + kPsd + "}]}");
  ASSERT_EQ(two.status, SolveStatus::kSolved);
  // The twin keeps its 20 nm, so sqrt(sigma^2 + 20^2) is the allowed height of one surface.
  EXPECT_NEAR(std::hypot(two.solutions[0].at[0], 20e-9) / one.solutions[0].at[0], 1, 1e-9);
  ASSERT_EQ(two.uses.size(), 2u);
  EXPECT_EQ(two.uses[0].name, "mirror");
  EXPECT_EQ(two.uses[1].name, "twin");
  EXPECT_DOUBLE_EQ(two.uses[0].alone[0], two.uses[1].without[0]);
  EXPECT_LT(two.uses[0].alone[0], two.budgets[0].limit);
  EXPECT_TRUE(one.uses.empty());
}

Eigen::ArrayXd mean_structure(const RadialPsd& psd, const Eigen::ArrayXd& shears, double incidence) {
  constexpr int kDirections = 90;
  const double cosine = std::cos(incidence);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(shears.size());
  for (int k = 0; k < kDirections; ++k) {
    const double t = 0.5 * pi * (k + 0.5) / kDirections;
    sum += structure_function(psd, shears * std::hypot(std::cos(t) / cosine, std::sin(t)));
  }
  return cosine * cosine * sum / kDirections;
}

// D'(x) = cos^2 D(footprint |(x cos t/cos, x sin t)|), averaged over directions t. A beam of a third of the
// width has a third of the shear, and 1/cos more along the plane of incidence.
TEST(Contributors, BeamOnAnotherSurface) {
  PowerLawPsd by_amplitude;
  by_amplitude.amplitude = 1e-20;
  by_amplitude.exponent = 3;
  by_amplitude.f_min = 2;
  by_amplitude.f_max = 200;
  PowerLawPsd by_rms = by_amplitude;
  by_rms.amplitude.reset();
  by_rms.rms = 10e-9;
  const PsdModel models[] = {UniformPsd{20e-9, 5, 50},
                             KCorrelationPsd{20e-9, 0.1, 2.8, 5, 100},
                             by_amplitude,
                             by_rms,
                             GaussianPsd{20e-9, 0.03},
                             TablePsd{{5, 20, 80}, {1e-20, 3e-21, 1e-23}},
                             SumPsd{{UniformPsd{20e-9, 5, 50}, GaussianPsd{20e-9, 0.03}}}};
  for (const PsdModel& model : models) {
    const OtherSurface surface{"secondary", model, 0.3, 0.5, false};
    const Eigen::ArrayXd ours = structure_function(RadialPsd(in_pupil(surface)), kShears),
                         law = mean_structure(RadialPsd(model), 0.3 * kShears, 0.5);
    EXPECT_LT((ours / law - 1).abs().maxCoeff(), 1e-5) << model.index();
    OtherSurface wavefront = surface;
    wavefront.is_wavefront = true;
    EXPECT_LT((structure_function(RadialPsd(in_pupil(wavefront)), kShears) / ours - 0.25).abs().maxCoeff(),
              1e-9);
  }
}

// Computes encircled energies of a flat pupil with a tilted fold mirror from random realisations. Heights of
// the fold are Gaussian on a grid whose steps along the plane of incidence are 1/cos longer. The path changes
// by 2 h cos, and the Fraunhofer pattern is summed exactly over discs.
class DrawnFold {
 public:
  DrawnFold(const RadialPsd& psd, double incidence, const Eigen::ArrayXd& radii)
      : cosine_(std::cos(incidence)), field_(kSide * kSide), heights_(field_), amplitude_(kSide * kSide) {
    const double step = 1 / (kSide * kPitch), scale = kPitch / (kLambda * 2.8);
    kernel_.resize(radii.size(), kSide * kSide);
    for (int k = 0; k < kSide * kSide; ++k) {
      const int i = signed_index(k / kSide), j = signed_index(k % kSide);
      const double nu = scale * std::hypot(i, j);
      for (Eigen::Index r = 0; r < radii.size(); ++r)
        kernel_(r, k) = scale * scale *
                        (k == 0 ? pi * radii[r] * radii[r] : radii[r] * ::j1(2 * pi * radii[r] * nu) / nu);
      // Averages the PSD over the grid cell of the frequency, one side of which is shorter by the cosine.
      double power = 0;
      for (const double a : {-0.375, -0.125, 0.125, 0.375})
        for (const double b : {-0.375, -0.125, 0.125, 0.375})
          power += psd(std::hypot(cosine_ * step * (i + a), step * (j + b))) / 16;
      amplitude_[std::size_t(k)] = std::sqrt(power * cosine_ * step * step);
    }
  }
  /// Mean change of the encircled energy by roughness over the realisations.
  Eigen::ArrayXd change(int draws) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(kernel_.rows());
    for (int draw = 0; draw < draws; draw += 2) {
      for (std::size_t k = 0; k < heights_.size(); ++k) {
        const double x = normal(random), y = normal(random);
        heights_[k] = amplitude_[k] * std::complex<double>(x, y);
      }
      transform(&heights_);
      sum += light([](const std::complex<double>& h) { return h.real(); });
      sum += light([](const std::complex<double>& h) { return h.imag(); });
    }
    return sum / draws - light([](const std::complex<double>&) { return 0.0; });
  }

 private:
  static constexpr int kCells = 64, kSide = 2 * kCells;
  static constexpr double kPitch = 0.4 / kCells, kLambda = 632.8e-9;
  static int signed_index(int i) { return i < kCells ? i : i - kSide; }
  static void transform(std::vector<std::complex<double>>* values) {
    auto* raw = reinterpret_cast<fftw_complex*>(values->data());
    fftw_plan plan = fftw_plan_dft_2d(kSide, kSide, raw, raw, FFTW_FORWARD, FFTW_ESTIMATE);
    fftw_execute(plan);
    fftw_destroy_plan(plan);
  }
  template <typename Part>
  Eigen::ArrayXd light(const Part& part) {
    std::fill(field_.begin(), field_.end(), 0);
    double total = 0;
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        if (std::hypot(i + 0.5 - kCells / 2, j + 0.5 - kCells / 2) > kCells / 2) continue;
        const auto k = std::size_t(i * kSide + j);
        field_[k] = std::polar(1.0, -4 * pi / kLambda * cosine_ * part(heights_[k]));
        total += 1;
      }
    transform(&field_);
    for (auto& value : field_) value = std::norm(value);
    transform(&field_);
    Eigen::VectorXd lags(kSide * kSide);
    for (Eigen::Index k = 0; k < lags.size(); ++k) lags[k] = field_[std::size_t(k)].real();
    return (kernel_ * lags).array() / (total * kSide * kSide);
  }

  double cosine_;
  std::vector<std::complex<double>> field_, heights_;
  std::vector<double> amplitude_;
  Eigen::MatrixXd kernel_;  // radii x lags
};

double radius_at(const Eigen::ArrayXd& radii, const Eigen::ArrayXd& light, double share) {
  for (Eigen::Index k = 1; k < light.size(); ++k)
    if (light[k] >= share)
      return radii[k - 1] *
             std::pow(radii[k] / radii[k - 1], (share - light[k - 1]) / (light[k] - light[k - 1]));
  return std::nan("");
}

void expect_folds_as_drawn(int draws, double tolerance) {
  const PsdModel models[] = {KCorrelationPsd{50e-9, 0.05, 3, 5, 35}, UniformPsd{45e-9, 5, 30},
                             PowerLawPsd{60e-9, {}, 2.5, 5, 35}};
  const Eigen::ArrayXd radii = Eigen::ArrayXd::LinSpaced(12, std::log(4e-6), std::log(120e-6)).exp();
  for (const double degrees : {45.0, 60.0})
    for (const PsdModel& model : models) {
      const OtherSurface fold{"fold", model, 1, degrees * pi / 180, false};
      const auto mean = [&](const RadialPsd& psd) {
        return Eigen::ArrayXd(radii.unaryExpr(
            [spot = GeneralisedHarveyShack(psd, {2.8, -1, {}}, CircleAperture{0.4}, 632.8e-9).at_plane(0)](
                double radius) { return spot.encircled_energy(radius); }));
      };
      const Eigen::ArrayXd ours = mean(RadialPsd(in_pupil(fold))),
                           perfect = mean(RadialPsd(UniformPsd{1e-14, 5, 40})),
                           drawn = perfect + DrawnFold(RadialPsd(model), fold.incidence, radii).change(draws);
      EXPECT_LT((ours - drawn).abs().maxCoeff(), 0.01) << degrees << " " << model.index();
      EXPECT_NEAR(radius_at(radii, ours, 0.8) / radius_at(radii, drawn, 0.8), 1, tolerance)
          << degrees << " " << model.index();
      const double old = radius_at(radii, mean(RadialPsd(model).scaled(std::cos(fold.incidence))), 0.8);
      std::printf("%g degrees, PSD %zu: ee80 %.4f of the draws, as if the footprint were round %.3f\n",
                  degrees, model.index(), radius_at(radii, ours, 0.8) / radius_at(radii, drawn, 0.8),
                  old / radius_at(radii, drawn, 0.8));
    }
}

TEST(Contributors, AFoldIsItsDraws) { expect_folds_as_drawn(60, 0.03); }
TEST(FullStatistics, AFoldIsAThousandDrawsOfIt) { expect_folds_as_drawn(1000, 0.01); }

// Fried's 6.88 (x/r0)^(5/3) for the phase 4 pi h/lambda.
TEST(Contributors, AtmosphereIsKolmogorovs) {
  const Atmosphere air{0.15, 500e-9};
  const Eigen::ArrayXd phase =
      2 * std::pow(4 * pi / 500e-9, 2) * structure_function(RadialPsd(in_pupil(air)), kShears);
  EXPECT_LT((phase / (6.8838772 * (kShears / 0.15).pow(5.0 / 3)) - 1).abs().maxCoeff(), 1e-4);
}

// A Gaussian blur of the image: exp(-2 pi^2 jitter^2 x^2/lambda^2), at every wavelength.
TEST(Contributors, JitterIsAGaussianBlur) {
  const double jitter = 1e-6, lambda = 632.8e-9;
  const Eigen::ArrayXd exponent =
      std::pow(4 * pi / lambda, 2) * structure_function(RadialPsd(in_pupil_of_jitter(jitter, 0.4)), kShears);
  EXPECT_LT((exponent / (2 * pi * pi * (jitter * kShears / lambda).square()) - 1).abs().maxCoeff(), 1e-4);
}

// Strehl ratios of fine roughness multiply, so the atmosphere leaves less of the budget for the mirror.
TEST(Contributors, TakeTheirPartOfTheBudget) {
  const Specification
      alone = solved(""),
      shaken = solved(R"({"jitter": "0.3 arcsec", "atmosphere": {"r0": "40 cm", "wavelength": "500 nm"}})");
  ASSERT_EQ(shaken.status, SolveStatus::kSolved);
  EXPECT_LT(shaken.solutions[0].at[0], alone.solutions[0].at[0]);
  ASSERT_EQ(shaken.uses.size(), 3u);
  EXPECT_EQ(shaken.uses[1].name, "atmosphere");
  EXPECT_EQ(shaken.uses[2].name, "jitter");
  for (const BudgetUse& use : shaken.uses) {
    EXPECT_LT(use.alone[0], shaken.budgets[0].limit) << use.name;
    EXPECT_LT(use.without[0], shaken.budgets[0].limit) << use.name;
    EXPECT_GT(use.alone[0], shaken.perfect[0].value * (1 - 1e-9)) << use.name;
  }
  const Specification too_much = solved(R"({"jitter": "2 arcsec"})");
  EXPECT_EQ(too_much.status, SolveStatus::kNoSolution);
  EXPECT_THROW(solved(R"({"jitter": "0.3 arcsec"})", R"({"rms_height": "<= 20 nm"})"), InputError);
  // The geometric theory cannot treat turbulence, whose slopes have infinite variance.
  try {
    run_solve(parse_study(
                  R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {"theory": "geometric"}, "roughness": {"psd": )" +
                      kPsd + R"(}, "solve": {"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter":
          "<= 2 arcsec"}, "with": {"jitter": "0.3 arcsec"}}})",
                  "study.json"),
              {});
    ADD_FAILURE() << "geometric";
  } catch (const InputError& error) {
    EXPECT_EQ(error.pointer(), "/target/theory");
  }
}

// Seeing is 0.976 lambda/r0 with r0 proportional to lambda^(6/5). An aperture of 40 r0 changes the transfer
// function of a long exposure only little.
TEST(Contributors, WidthOfTheImageIsTheSeeing) {
  const Specification spec = run_solve(
      parse_study(R"({"aberfit": 1, "mirror": {"focal_length": "40 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "4 m"}, "roughness": {"psd": {"model": "uniform", "rms": "20 nm",
          "f_min": "5 /m", "f_max": "20 /m"}}, "solve": {"for": ["/roughness/psd/rms"], "so_that": {
          "fwhm": "<= 1.5 arcsec"}, "with": {"atmosphere": {"r0": "10 cm", "wavelength": "500 nm"}}}})",
                  "study.json"),
      {});
  ASSERT_EQ(spec.uses.size(), 2u);
  EXPECT_EQ(spec.uses[1].name, "atmosphere");
  const double r0 = 0.1 * std::pow(632.8 / 500, 1.2);
  EXPECT_NEAR(spec.uses[1].alone[0] / (0.976 * 632.8e-9 / r0), 1, 0.02);
  for (const char* of_a_surface : {R"({"bsdf@5deg": "<= 1"})", R"({"rms_slope": "<= 1e-6"})"})
    EXPECT_THROW(solved(R"({"jitter": "0.3 arcsec"})", of_a_surface), InputError) << of_a_surface;
}

}  // namespace
}  // namespace aberfit
