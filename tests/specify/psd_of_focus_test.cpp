// From the light of a focus back to the PSD it was made with.
#include "aberfit/specify/psd_of_focus.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "../../src/specify/focal_bins.h"
#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "theory/drawn_mirrors.h"

namespace aberfit {
namespace {

using std::numbers::pi;

// A mirror whose PSD is looked for, and the curve of a better known one.
struct FocusCase {
  const char* name;
  std::string psd;  // as JSON: where the search starts
  std::vector<std::string> unknowns;
  PsdModel truth;
  std::vector<double> values;  // of the unknowns, true
  double dz;
};

std::string study_text(const FocusCase& of) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "annulus", "diameter": "0.4 m", "inner_diameter": "0.14 m"},
      "roughness": {"psd": )" +
         of.psd + "}}";
}

std::vector<FocusCase> focus_cases() {
  return {{"k-correlation",
           R"({"model": "k-correlation", "rms": "30 nm", "B": "40 mm", "exponent": 3, "f_min": "2.5 /m",
               "f_max": "500 /m"})",
           {"/roughness/psd/rms", "/roughness/psd/B"},
           KCorrelationPsd{45e-9, 0.025, 3, 2.5, 500},
           {45e-9, 0.025},
           0},
          {"power law out of focus",
           R"({"model": "power-law", "rms": "50 nm", "exponent": 2.5, "f_min": "2.5 /m", "f_max": "300 /m"})",
           {"/roughness/psd/rms", "/roughness/psd/exponent"},
           PowerLawPsd{},
           {35e-9, 2.1},
           0.3e-3},
          {"uniform",
           R"({"model": "uniform", "rms": "50 nm", "f_min": "2.5 /m", "f_max": "30 /m"})",
           {"/roughness/psd/rms", "/roughness/psd/f_max"},
           UniformPsd{70e-9, 2.5, 45},
           {70e-9, 45},
           0}};
}

struct Family {
  Study study;
  StudyFamily at;
  std::vector<SolveUnknown> unknowns;

  explicit Family(const FocusCase& of)
      : study(parse_study(study_text(of), "study.json")), at(study, of.unknowns) {
    for (const std::string& pointer : of.unknowns)
      for (const PsdNumber& number : psd_numbers(study))
        if (number.pointer == pointer) unknowns.push_back({pointer, number.value, number.dimension});
  }
};

// The mean light of the true mirror in circles of 2 to 300 um.
EncircledCurve true_curve(const Task& task, double dz, int count = 40) {
  EncircledCurve curve;
  curve.radius.resize(count);
  curve.share.resize(count);
  const GeneralisedHarveyShack mean(RadialPsd(*task.psd), task.mirror, task.aperture, task.wavelength);
  const MeanSpot spot = mean.at_plane(dz);
  for (int k = 0; k < count; ++k) {
    curve.radius[k] = 2e-6 * std::pow(150, k / (count - 1.0));
    curve.share[k] = spot.encircled_energy(curve.radius[k]);
  }
  return curve;
}

struct TrialCounts {
  int trials = 0;
  Eigen::Array2d covered = Eigen::Array2d::Zero(), deviations = Eigen::Array2d::Zero(),
                 squares = Eigen::Array2d::Zero();
  int unidentified = 0, poor = 0;
};

TrialCounts run_trials(const FocusCase& of, int trials, double noise) {
  const Family family(of);
  const EncircledCurve curve = true_curve(family.at(of.values), of.dz);
  TrialCounts counts;
  counts.trials = trials;
  std::vector<PsdOfFocus> found(static_cast<std::size_t>(trials));
  parallel_for(found.size(), available_threads(), [&](std::size_t trial) {
    MeasuredFocus focus;
    EncircledCurve noisy = curve;
    std::mt19937_64 random(trial + 1);
    std::normal_distribution<double> normal(0, noise);
    for (double& share : noisy.share) share += normal(random);
    focus.data = noisy;
    focus.noise = noise;
    focus.dz = of.dz;
    focus.is_one_mirror = false;
    found[trial] = fit_psd_to_focus(family.at, family.unknowns, focus, {});
  });
  for (const PsdOfFocus& one : found) {
    counts.poor += one.status == PsdOfFocusStatus::kNotDescribed;
    counts.unidentified += one.status == PsdOfFocusStatus::kNotIdentified;
    for (Eigen::Index u = 0; u < 2; ++u) {
      const NumberOfFocus& number = one.numbers[std::size_t(u)];
      const double truth = of.values[std::size_t(u)], z = std::log(number.best / truth) / number.log_std;
      counts.covered[u] += number.lower <= truth && truth <= number.upper;
      counts.deviations[u] += z;
      counts.squares[u] += z * z;
    }
  }
  return counts;
}

void expect_honest(const FocusCase& of, const TrialCounts& counts, double least, double most, double bias) {
  const double n = counts.trials;
  for (int u : {0, 1}) {
    std::printf("%s, %s: covered %.3f, mean deviation %.3f and RMS %.3f standard errors\n", of.name,
                of.unknowns[std::size_t(u)].c_str(), counts.covered[u] / n, counts.deviations[u] / n,
                std::sqrt(counts.squares[u] / n));
    EXPECT_GE(counts.covered[u] / n, least) << of.name << " " << u;
    EXPECT_LE(counts.covered[u] / n, most) << of.name << " " << u;
    EXPECT_LT(std::abs(counts.deviations[u] / n), bias) << of.name << " " << u;
  }
  EXPECT_EQ(counts.unidentified, 0) << of.name;
  EXPECT_LE(counts.poor, 1 + n / 100) << of.name;
}

TEST(PsdOfFocus, NumbersOfNoisyCurvesAreWithinTheirIntervals) {
  for (const FocusCase& of : focus_cases()) expect_honest(of, run_trials(of, 2, 0.002), 0.5, 1, 2.2);
}

// Light of a Gaussian spot of standard deviation kSpot: in closed form in circles and on pixels.
constexpr double kSpot = 7e-6;
double gaussian_energy(double radius) { return 1 - std::exp(-radius * radius / (2 * kSpot * kSpot)); }
double gaussian_pixel(double x, double y, double pixel) {
  const auto share = [&](double at) {
    const double scale = 1 / (std::sqrt(2.0) * kSpot);
    return 0.5 * (std::erf((at + 0.5 * pixel) * scale) - std::erf((at - 0.5 * pixel) * scale));
  };
  return share(x) * share(y);
}
FocalImage gaussian_image(double x, double y, double pixel, int side) {
  FocalImage image;
  image.pixel = pixel;
  image.light.resize(side, side);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      image.light(row, column) = gaussian_pixel((column - x) * pixel, (row - y) * pixel, pixel);
  return image;
}
Eigen::ArrayXd expected_light(const internal::FocalBins& bins) {
  return (bins.weights * bins.nodes.unaryExpr(&gaussian_energy).matrix()).array();
}

TEST(FocalBins, RingsOfPixelsHaveTheLightOfTheirPixels) {
  for (const double pixel : {0.5 * kSpot, 1.5 * kSpot}) {
    FocalImage image = gaussian_image(30.3, 29.1, pixel, 61);
    image.light(33, 35) = NAN;  // a dead pixel is in no ring
    const internal::PixelPlace centre = internal::centre_of(image), truth{30.3, 29.1};
    EXPECT_NEAR(centre.x, 30.3, 0.02);
    EXPECT_NEAR(centre.y, 29.1, 0.02);
    const internal::FocalBins bins = internal::rings_of(image, pixel, kSpot, 1, centre, truth);
    EXPECT_GT(bins.radius.size(), 12);
    const Eigen::ArrayXd expected = expected_light(bins);
    std::printf("pixel %.1f sigma: largest difference %.1e\n", pixel / kSpot,
                (bins.measured - expected).abs().maxCoeff());
    EXPECT_LT((bins.measured - expected).abs().maxCoeff(), 1e-6);
  }
}

TEST(FocalBins, CirclesCountedByPixelsAreTheMeanOverTheirLattice) {
  const double pixel = 1.2 * kSpot;
  EncircledCurve curve;
  curve.radius.resize(3);
  curve.radius << 0.4 * kSpot, kSpot, 2.5 * kSpot;
  curve.share.setZero(3);
  const Eigen::ArrayXd found = expected_light(internal::circles_of(curve, pixel, kSpot));
  for (Eigen::Index k = 0; k < 3; ++k) {
    double sum = 0;
    constexpr int kPhases = 60;
    for (int i = 0; i < kPhases; ++i)
      for (int j = 0; j < kPhases; ++j)
        for (int row = -8; row <= 8; ++row)
          for (int column = -8; column <= 8; ++column) {
            const double x = (column + (i + 0.5) / kPhases) * pixel, y = (row + (j + 0.5) / kPhases) * pixel;
            if (std::hypot(x, y) < curve.radius[k]) sum += gaussian_pixel(x, y, pixel);
          }
    EXPECT_NEAR(found[k], sum / (kPhases * kPhases), 2e-3) << k;  // the edge among the phases
    EXPECT_GT(std::abs(found[k] - gaussian_energy(curve.radius[k])), 0.007) << k;
  }
}

MeasuredFocus noisy_focus(const EncircledCurve& curve, double noise, std::uint64_t seed) {
  MeasuredFocus focus;
  EncircledCurve noisy = curve;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, noise);
  for (double& share : noisy.share) share += normal(random);
  focus.data = noisy;
  focus.noise = noise;
  focus.is_one_mirror = false;
  return focus;
}

// Knee at 1/B = 0.05 cycles/m, far below the lowest of the band: only the slope beyond it spreads light.
TEST(PsdOfFocus, AKneeOutsideTheDataIsNotIdentified) {
  FocusCase of = focus_cases()[0];
  of.values = {45e-9, 20.0};
  const Family family(of);
  const PsdOfFocus found = fit_psd_to_focus(family.at, family.unknowns,
                                            noisy_focus(true_curve(family.at(of.values), 0), 0.002, 1), {});
  for (const NumberOfFocus& number : found.numbers)
    std::printf("%s %.4g (%.4g to %.4g)\n", number.unknown.pointer.c_str(), number.best, number.lower,
                number.upper);
  EXPECT_EQ(found.status, PsdOfFocusStatus::kNotIdentified) << found.message;
  EXPECT_FALSE(found.numbers[1].identified());
  EXPECT_TRUE(found.numbers[1].lower_found);  // it is above something
  EXPECT_FALSE(found.numbers[1].upper_found);
  EXPECT_LT(found.numbers[1].lower, 20.0);
  EXPECT_TRUE(found.numbers[0].identified());
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_EQ(found.warnings[0].code, "not-identified");
}

// A curve of another model: what is left is no noise.
TEST(PsdOfFocus, AnotherModelIsAPoorFit) {
  const FocusCase of = focus_cases()[2];
  const Family family(of);
  Task task = family.at({60e-9, 40});
  task.psd = KCorrelationPsd{60e-9, 0.05, 3, 2.5, 500};
  const PsdOfFocus found =
      fit_psd_to_focus(family.at, family.unknowns, noisy_focus(true_curve(task, 0), 0.002, 1), {});
  EXPECT_EQ(found.status, PsdOfFocusStatus::kNotDescribed);
  EXPECT_LT(found.goodness, 1e-3);
  EXPECT_EQ(found.warnings.back().code, "poor-fit");
}

Eigen::ArrayXd array_of_radii(const std::vector<double>& radii) {
  return Eigen::Map<const Eigen::ArrayXd>(radii.data(), Eigen::Index(radii.size()));
}

// Curves of drawn mirrors, by a code of the tests. Their cells, grey at the rim, lose some of the light that
// a sharp rim sends far out: as much as of the perfect mirror.
Eigen::ArrayXXd drawn_curves(const PsdModel& psd, const std::vector<double>& radii, int draws) {
  const auto drawn = [](const RadialPsd& of) {
    return testing_draws::DrawnScene{of, 2.8, 0.4, 0.14, 632.8e-9, 64};
  };
  const RadialPsd whole(psd), perfect = whole.scaled(1e-9);
  const Eigen::ArrayXd sharp = testing_draws::DrawnMirrors(drawn(perfect), {}).light({0, radii}, 1, 1).col(0);
  Eigen::ArrayXXd light = testing_draws::DrawnMirrors(drawn(whole), {}).light({0, radii}, draws, 11);
  const GeneralisedHarveyShack mean(perfect, {2.8, -1, {}}, AnnulusAperture{0.4, 0.14}, 632.8e-9);
  for (Eigen::Index k = 0; k < light.rows(); ++k)
    light.row(k) -= sharp[k] - mean.encircled_energy(radii[std::size_t(k)], 0);
  return light;
}

// One mirror is not the mean of its specification: intervals have to allow for that.
void expect_numbers_of_one_mirror(int draws, double least, double most, double narrow) {
  FocusCase of = focus_cases()[0];
  of.psd =
      R"({"model": "k-correlation", "rms": "30 nm", "B": "40 mm", "exponent": 3, "f_min": "2.5 /m", "f_max": "60 /m"})";
  const Family family(of);
  std::vector<double> radii;
  for (int k = 0; k < 24; ++k) radii.push_back(4e-6 * std::pow(25, k / 23.0));
  const Eigen::ArrayXXd curves = drawn_curves(*family.at(of.values).psd, radii, draws);
  std::vector<PsdOfFocus> with_spread(static_cast<std::size_t>(draws)), without = with_spread;
  parallel_for(with_spread.size(), available_threads(), [&](std::size_t draw) {
    MeasuredFocus focus;
    focus.data = EncircledCurve{array_of_radii(radii), curves.col(Eigen::Index(draw)), {}, false};
    with_spread[draw] = fit_psd_to_focus(family.at, family.unknowns, focus, {});
    focus.is_one_mirror = false;
    focus.noise = 1e-3;
    without[draw] = fit_psd_to_focus(family.at, family.unknowns, focus, {});
  });
  const auto covered = [&](const std::vector<PsdOfFocus>& found, std::size_t number) {
    double sum = 0;
    for (const PsdOfFocus& one : found)
      sum += one.numbers[number].lower <= of.values[number] && of.values[number] <= one.numbers[number].upper;
    return sum / draws;
  };
  for (const std::size_t number : {0, 1}) {
    double squares = 0, mean = 0;
    for (const PsdOfFocus& one : with_spread) {
      const double z = std::log(one.numbers[number].best / of.values[number]) / one.numbers[number].log_std;
      squares += z * z / draws, mean += z / draws;
    }
    std::printf("%s: covered %.3f (RMS deviation %.2f, mean %.2f), as if it were the mean %.3f\n",
                of.unknowns[number].c_str(), covered(with_spread, number), std::sqrt(squares), mean,
                covered(without, number));
    EXPECT_GE(covered(with_spread, number), least);
    EXPECT_LE(covered(with_spread, number), most);
    EXPECT_LT(covered(without, number), narrow);
  }
}

TEST(PsdOfFocus, OfOneMirrorAllowsForItsOwnDeparture) { expect_numbers_of_one_mirror(6, 0.6, 1, 0.4); }

TEST(FullStatistics, IntervalsOfOneMirrorAllowForItsOwnDeparture) {
  expect_numbers_of_one_mirror(100, 0.85, 1, 0.6);
}

TEST(FullStatistics, CoverageAndBiasOfFiveHundredCurves) {
  for (const FocusCase& of : focus_cases()) expect_honest(of, run_trials(of, 500, 0.002), 0.93, 0.97, 0.2);
}

}  // namespace
}  // namespace aberfit
