// Recovers a PSD from the focus that it produces.
#include "aberfit/specify/psd_of_focus.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
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

// A mirror with an unknown PSD, and the true values.
struct FocusCase {
  const char* name;
  std::string psd;  // JSON of the PSD at which the search starts
  std::vector<std::string> unknowns;
  PsdModel truth;
  std::vector<double> values;  // true values of the unknowns
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

// Mean encircled energy of the true mirror in circles of 2 to 300 um.
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

// A Gaussian spot of standard deviation kSpot, in closed form in circles and on pixels.
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
    EXPECT_NEAR(found[k], sum / (kPhases * kPhases), 2e-3) << k;  // the phases sample the edge of the circle
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

// The knee at 1/B = 0.05 cycles/m is far below the band, so that only the slope beyond it matters.
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
  EXPECT_TRUE(found.numbers[1].lower_found);  // a lower bound exists
  EXPECT_FALSE(found.numbers[1].upper_found);
  EXPECT_LT(found.numbers[1].lower, 20.0);
  EXPECT_TRUE(found.numbers[0].identified());
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_EQ(found.warnings[0].code, "not-identified");
}

// For a curve of another model the residuals are not noise.
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

// Curves of random mirrors by code of the tests. Partly filled grid cells at the rim lose some energy far
// out, as for the perfect mirror.
Eigen::ArrayXXd drawn_curves(const PsdModel& psd, const std::vector<double>& radii, int draws,
                             double dz = 0) {
  const auto drawn = [](const RadialPsd& of) {
    return testing_draws::DrawnScene{of, 2.8, 0.4, 0.14, 632.8e-9, 64};
  };
  const RadialPsd whole(psd), perfect = whole.scaled(1e-9);
  const Eigen::ArrayXd sharp =
      testing_draws::DrawnMirrors(drawn(perfect), {}).light({dz, radii}, 1, 1).col(0);
  Eigen::ArrayXXd light = testing_draws::DrawnMirrors(drawn(whole), {}).light({dz, radii}, draws, 11);
  const GeneralisedHarveyShack mean(perfect, {2.8, -1, {}}, AnnulusAperture{0.4, 0.14}, 632.8e-9);
  for (Eigen::Index k = 0; k < light.rows(); ++k)
    light.row(k) -= sharp[k] - mean.encircled_energy(radii[std::size_t(k)], dz);
  return light;
}

struct MirrorScene {
  FocusCase of;
  double farthest;  // radius [m]
};

// Three mirrors with about ten cycles across the aperture: one with a knee that its own deviation hides, one
// without, and one in a plane where heights contribute linearly.
std::vector<MirrorScene> mirror_scenes() {
  FocusCase knee = focus_cases()[0];
  knee.psd =
      R"({"model": "k-correlation", "rms": "30 nm", "B": "40 mm", "exponent": 3, "f_min": "2.5 /m", "f_max": "60 /m"})";
  knee.truth = KCorrelationPsd{45e-9, 0.025, 3, 2.5, 60};
  FocusCase law = focus_cases()[1];
  law.name = "power law";
  law.psd = R"({"model": "power-law", "rms": "50 nm", "exponent": 2.5, "f_min": "2.5 /m", "f_max": "60 /m"})";
  law.dz = 0;
  FocusCase moved = knee;
  moved.name = "k-correlation out of focus";
  moved.dz = 0.15e-3;
  return {{knee, 100e-6}, {law, 100e-6}, {moved, 100e-6}};
}

struct MirrorCounts {
  std::array<double, 2> covered{}, covered_as_mean{}, squares{};
  int poor = 0;
};

MirrorCounts numbers_of_one_mirror(const MirrorScene& scene, int draws, bool as_mean) {
  const FocusCase& of = scene.of;
  const Family family(of);
  std::vector<double> radii;
  for (int k = 0; k < 24; ++k) radii.push_back(4e-6 * std::pow(scene.farthest / 4e-6, k / 23.0));
  const Eigen::ArrayXXd curves = drawn_curves(*family.at(of.values).psd, radii, draws, of.dz);
  std::vector<PsdOfFocus> with_spread(static_cast<std::size_t>(draws)), without = with_spread;
  parallel_for(with_spread.size(), available_threads(), [&](std::size_t draw) {
    MeasuredFocus focus;
    focus.data = EncircledCurve{array_of_radii(radii), curves.col(Eigen::Index(draw)), {}, false};
    focus.dz = of.dz;
    with_spread[draw] = fit_psd_to_focus(family.at, family.unknowns, focus, {});
    focus.is_one_mirror = false;
    focus.noise = 1e-3;
    if (as_mean) without[draw] = fit_psd_to_focus(family.at, family.unknowns, focus, {});
  });
  MirrorCounts counts;
  const auto covers = [&](const PsdOfFocus& one, std::size_t u) {
    return one.numbers[u].lower <= of.values[u] && of.values[u] <= one.numbers[u].upper;
  };
  for (const PsdOfFocus& one : with_spread) {
    counts.poor += one.status == PsdOfFocusStatus::kNotDescribed;
    for (const std::size_t u : {0, 1}) {
      counts.covered[u] += covers(one, u) / double(draws);
      counts.squares[u] +=
          std::pow(std::log(one.numbers[u].best / of.values[u]) / one.numbers[u].log_std, 2) / draws;
    }
  }
  if (as_mean)
    for (const PsdOfFocus& one : without)
      for (const std::size_t u : {0, 1}) counts.covered_as_mean[u] += covers(one, u) / double(draws);
  for (const std::size_t u : {0, 1})
    std::printf("%s, %s: covered %.3f (RMS deviation %.2f); poor fits %d\n", of.name, of.unknowns[u].c_str(),
                counts.covered[u], std::sqrt(counts.squares[u]), counts.poor);
  std::fflush(stdout);
  return counts;
}

// One mirror differs from the mean of its specification, and the intervals must include that.
TEST(PsdOfFocus, OfOneMirrorAllowsForItsOwnDeparture) {
  const MirrorCounts counts = numbers_of_one_mirror(mirror_scenes()[0], 6, true);
  for (const std::size_t u : {0, 1}) {
    EXPECT_GE(counts.covered[u], 0.6) << u;
    EXPECT_LT(counts.covered_as_mean[u], 0.4) << u;
  }
}

TEST(FullStatistics, IntervalsOfOneMirrorAllowForItsOwnDeparture) {
  for (const MirrorScene& scene : mirror_scenes()) {
    const MirrorCounts counts = numbers_of_one_mirror(scene, 200, false);
    for (const std::size_t u : {0, 1}) {
      EXPECT_GE(counts.covered[u], 0.92) << scene.of.name << " " << u;
      EXPECT_LE(counts.covered[u], 0.98) << scene.of.name << " " << u;
    }
    EXPECT_LE(counts.poor, 10) << scene.of.name;
  }
}

// Possible errors of a curve, each with a size between 0 and 1.
enum class Wrong { kNothing, kCropped, kDefocused, kShifted, kAberrated, kScaled };
constexpr Wrong kAllWrong[] = {Wrong::kCropped, Wrong::kDefocused, Wrong::kShifted, Wrong::kAberrated,
                               Wrong::kScaled};
const char* remedy_of(Wrong wrong) {
  constexpr const char* kWords[] = {"",
                                    "not of the total energy",
                                    "another plane",
                                    "not centred on the image",
                                    "aberration",
                                    "another scale"};
  return kWords[int(wrong)];
}

std::string circle_study(const std::string& focus) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "roughness": {"psd": {"model": "k-correlation",
      "rms": "40 nm", "B": "20 mm", "exponent": 3, "f_min": "2.5 /m", "f_max": "250 /m"}})" +
         focus + "}";
}

// Energy of a mean spot in a disc whose centre is off the axis: (1/2 pi) oint E(rho)/rho^2 (X . n) ds.
double shifted_disc(const MeanSpot& spot, double radius, double shift) {
  constexpr int kAngles = 128;
  double sum = 0;
  for (int k = 0; k < kAngles; ++k) {
    const double t = 2 * pi * (k + 0.5) / kAngles, x = shift + radius * std::cos(t), y = radius * std::sin(t);
    const double square = x * x + y * y;
    sum += spot.encircled_energy(std::sqrt(square)) / square * (x * std::cos(t) + y * std::sin(t)) * radius;
  }
  return sum / kAngles;
}

// A curve of 24 circles for RMS height `rms`, with a noise of 0.002 that the file does not state.
EncircledCurve curve_with(Wrong wrong, double rms, double size, double sign, std::mt19937_64* random) {
  constexpr int kCircles = 24;
  Mirror mirror{2.8, -1, {}};
  if (wrong == Wrong::kAberrated) mirror.conic += sign * (0.03 + 0.3 * size);  // up to 0.5 waves at the rim
  const GeneralisedHarveyShack mean(RadialPsd(KCorrelationPsd{rms, 0.02, 3, 2.5, 250}), mirror,
                                    CircleAperture{0.4}, 632.8e-9);
  const double dz = wrong == Wrong::kDefocused ? sign * (0.03e-3 + 0.3e-3 * size) : 0;
  const MeanSpot spot = mean.at_plane(dz);
  const double last = wrong == Wrong::kCropped ? 30e-6 * std::pow(6, size) : 100e-6;
  std::normal_distribution<double> noise(0, 0.002);
  EncircledCurve curve;
  curve.radius.resize(kCircles);
  curve.share.resize(kCircles);
  for (int k = 0; k < kCircles; ++k) {
    const double radius = curve.radius[k] = 3e-6 * std::pow(last / 3e-6, k / (kCircles - 1.0));
    const double scale = wrong == Wrong::kScaled ? 1 + sign * (0.01 + 0.2 * size) : 1;
    curve.share[k] = (wrong == Wrong::kShifted ? shifted_disc(spot, radius, 0.5e-6 + 5e-6 * size)
                                               : spot.encircled_energy(scale * radius)) +
                     noise(*random);
  }
  if (wrong == Wrong::kCropped) curve.share /= curve.share[kCircles - 1];
  return curve;
}

struct VerdictCounts {
  int fitted = 0, misled = 0, named = 0;  // misled: fitted, with a parameter more than three deviations off
};

VerdictCounts verdicts_of(Wrong wrong, int curves, bool of_mirror, double least_size = 0) {
  const Study study = parse_study(circle_study(""), "study.json");
  const std::vector<std::string> pointers{"/roughness/psd/rms"};
  const StudyFamily at(study, pointers);
  const std::vector<SolveUnknown> unknowns{{pointers[0], 40e-9, Dimension::kLength}};
  std::vector<std::array<bool, 3>> found(static_cast<std::size_t>(curves));
  parallel_for(found.size(), available_threads(), [&](std::size_t curve) {
    std::mt19937_64 random(1000 * std::uint64_t(wrong) + curve);
    std::uniform_real_distribution<double> uniform;
    const double rms = 20e-9 + 40e-9 * uniform(random), size = std::max(least_size, uniform(random));
    const double sign = uniform(random) < 0.5 ? -1 : 1;
    MeasuredFocus focus;
    focus.data = curve_with(wrong, rms, size, sign, &random);
    focus.is_one_mirror = of_mirror;
    const PsdOfFocus fit = fit_psd_to_focus(at, unknowns, focus, {});
    const bool fitted = fit.status == PsdOfFocusStatus::kFitted;
    const double off = std::abs(std::log(fit.numbers[0].best / rms)) / fit.numbers[0].log_std;
    found[curve] = {fitted, fitted && off > 3, fit.message.find(remedy_of(wrong)) != std::string::npos};
  });
  VerdictCounts counts;
  for (const auto& [fitted, misled, named] : found)
    counts.fitted += fitted, counts.misled += misled, counts.named += !fitted && named;
  std::printf("wrongness %d, of %s: %d of %d fitted, %d of them more than three deviations off; %d named\n",
              int(wrong), of_mirror ? "mirror" : "mean", counts.fitted, curves, counts.misled, counts.named);
  std::fflush(stdout);
  return counts;
}

TEST(PsdOfFocus, WithoutNoiseTheFormOfTheResidualsIsTheVerdict) {
  EXPECT_GE(verdicts_of(Wrong::kNothing, 3, false).fitted, 2);
  for (const Wrong wrong : kAllWrong) EXPECT_EQ(verdicts_of(wrong, 1, false, 0.5).fitted, 0) << int(wrong);
  EXPECT_EQ(verdicts_of(Wrong::kCropped, 1, true, 0.1).named, 1);
}

TEST(FullStatistics, NoWrongCurveWithoutNoiseIsFittedFarOff) {
  for (const bool of_mirror : {false, true}) {
    EXPECT_GE(verdicts_of(Wrong::kNothing, 200, of_mirror).fitted, 190);
    for (const Wrong wrong : kAllWrong) EXPECT_EQ(verdicts_of(wrong, 200, of_mirror).misled, 0);
  }
}

TEST(FullStatistics, CoverageAndBiasOfFiveHundredCurves) {
  for (const FocusCase& of : focus_cases()) expect_honest(of, run_trials(of, 500, 0.002), 0.93, 0.97, 0.2);
}

}  // namespace
}  // namespace aberfit
