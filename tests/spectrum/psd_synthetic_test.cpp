#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "spectrum/random_line.h"

// The complete processing of a measurement: a random surface of known PSD, its estimate, the fit.

namespace aberfit {
namespace {

using Eigen::Index;
constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr int kAllSurfaces = 500, kFewSurfaces = 25;
constexpr Index kRows = 120, kColumns = 128, kPoints = 2048;
constexpr double kPitch = test::kLinePitch;  // [m]: 0.5 to 500 cycles/m
// 120 cycles/m is not an ordinate of the maps or the profiles.
constexpr double kLineFrequency = 120.3, kAngle = 0.3;
constexpr double kStrength = 10;  // amplitude over the RMS of the continuum in the bin around it
constexpr double kHoleShare = 0.1;

enum class Condition { kClean, kHoles, kLine };
const Condition kConditions[] = {Condition::kClean, Condition::kHoles, Condition::kLine};
const char* const kConditionNames[] = {"clean", "10 % holes", "one line"};

struct Model {
  std::string name;
  PsdFamily family;
  PsdModel roughness;                   // the first part of a sum is reported as rms, the second is the floor
  std::function<double(double)> along;  // profiles: one-sided S1 [m^3], in closed form
  std::map<std::string, double> truth;  // apart from the RMS values, which depend on the band used
  bool profile() const { return bool(along); }
};

std::vector<Model> models() {
  // Unit-exponent Lorentzian: int_0^inf A / (1 + (Bf)^2) df = pi A / (2 B) = variance.
  const double B = 0.02, variance = 1e-18, lorentzian = 2 * B * variance / kPi;
  // int S2 dfy of a f^-b: a sqrt(pi) Gamma((b-1)/2) / Gamma(b/2) f^(1-b); twice that is one-sided.
  const double a = 1e-22, b = 2.5;
  const double line_level = 2 * a * std::sqrt(kPi) * std::tgamma(0.5 * (b - 1)) / std::tgamma(0.5 * b);
  return {
      {"uniform map", PsdFamily::kUniform, UniformPsd{1e-9, 0, 1000}, {}, {}},
      {"power law map",
       PsdFamily::kPowerLaw,
       PowerLawPsd{std::nullopt, a, b, 0.1, kInfinity},
       {},
       {{"exponent", b}}},
      {"k-correlation map",
       PsdFamily::kKCorrelation,
       KCorrelationPsd{1e-9, 0.01, 3},
       {},
       {{"B", 0.01}, {"exponent", 3}}},
      {"k-correlation and floor map",
       PsdFamily::kKCorrelationAndFloor,
       SumPsd{{KCorrelationPsd{1e-9, 0.012, 4}, UniformPsd{6.5e-10, 0, 1000}}},
       {},
       {{"B", 0.012}, {"exponent", 4}}},
      {"power law profile",
       PsdFamily::kPowerLaw,
       PowerLawPsd{std::nullopt, a, b, 0.01, kInfinity},
       [=](double f) { return line_level * std::pow(f, 1 - b); },
       {{"exponent", b}}},
      {"k-correlation profile",
       PsdFamily::kKCorrelation,
       KCorrelationPsd{std::sqrt(variance), B, 3},
       [=](double f) { return lorentzian / (1 + B * B * f * f); },
       {{"B", B}, {"exponent", 3}}},
  };
}

// Amplitude of the sine: kStrength times the RMS of the continuum between kLineFrequency 10^(-+1/24).
double line_amplitude(const Model& model) {
  const double low = kLineFrequency * std::pow(10, -1.0 / 24), high = kLineFrequency * std::pow(10, 1.0 / 24);
  const double variance = model.profile()
                              ? model.along(kLineFrequency) * (high - low)
                              : RadialPsd(model.roughness)(kLineFrequency) * kPi * (high * high - low * low);
  return kStrength * std::sqrt(variance);
}

// Profiles and maps have the same interface: create, spoil, estimate.
struct ProfileWay {
  using Data = Profile;
  static Data draw(const Model& model, int seed) {
    return test::random_line(model.along, ProfileQuantity::kHeight, kPoints,
                             RandomStream(std::uint64_t(seed), "psd-synthetic " + model.name));
  }
  static void add_line(double amplitude, double phase, Data* data) {
    data->value += amplitude * (2 * kPi * kLineFrequency * data->x + phase).cos();
  }
  static double* values(Data* data) { return data->value.data(); }
  static Index size(const Data& data) { return data.size(); }
};

struct MapWay {
  using Data = HeightMap;
  static Data draw(const Model& model, int seed) {
    RandomSurfaceOptions options;
    options.seed = std::uint64_t(seed) + 10000;
    options.oversize = model.family == PsdFamily::kPowerLaw ? 8 : 2;
    // Four parameters need a wider band for the asymptotics to hold.
    const Index more = model.family == PsdFamily::kKCorrelationAndFloor ? 64 : 0;
    return random_surface(RadialPsd(model.roughness), kRows + more, kColumns + more, kPitch, options);
  }
  static void add_line(double amplitude, double phase, Data* data) {
    for (Index r = 0; r < data->rows(); ++r)
      for (Index c = 0; c < data->columns(); ++c)
        data->height(r, c) +=
            amplitude * std::cos(2 * kPi * kLineFrequency *
                                     (std::cos(kAngle) * data->x(c) + std::sin(kAngle) * data->y(r)) +
                                 phase);
  }
  static double* values(Data* data) { return data->height.data(); }
  static Index size(const Data& data) { return data.height.size(); }
};

using Fits = std::array<std::vector<PsdModelFit>, 3>;

template <class Way>
Fits fits_of(const Model& model, int surfaces) {
  const RandomStream holes(1, "psd-synthetic holes " + model.name);
  const auto spoil = [&](Condition condition, const RandomStream& stream, typename Way::Data* data) {
    if (condition == Condition::kLine)
      Way::add_line(line_amplitude(model), 2 * kPi * stream.uniform(0), data);
    if (condition == Condition::kHoles)
      for (Index i = 0; i < Way::size(*data); ++i)
        if (holes.uniform(std::uint64_t(i)) < kHoleShare)
          Way::values(data)[i] = std::numeric_limits<double>::quiet_NaN();
  };
  // There is one geometry per condition, so each estimator is made once.
  std::vector<PsdEstimator> estimators;
  for (const Condition condition : kConditions) {
    typename Way::Data data = Way::draw(model, 0);
    spoil(condition, RandomStream(0, "phase"), &data);
    estimators.emplace_back(data, PsdEstimatorOptions{}, available_threads());
  }
  Fits fits;
  for (auto& of_condition : fits) of_condition.resize(std::size_t(surfaces));
  PsdFitOptions options;
  options.family = model.family;
  parallel_for(std::size_t(surfaces), available_threads(), [&](std::size_t s) {
    const typename Way::Data surface = Way::draw(model, int(s) + 1);
    for (std::size_t c = 0; c < 3; ++c) {
      typename Way::Data data = surface;
      spoil(kConditions[c], RandomStream(s + 1, "psd-synthetic phase"), &data);
      const PsdEstimate estimate = estimators[c](data);
      fits[c][s] = fit_psd_model(estimate, options);
      // Ensures that the line condition has a line.
      if (kConditions[c] == Condition::kLine && estimate.lines.empty())
        fits[c][s].warnings.push_back({"no-line", ""});
    }
  });
  return fits;
}

// True values of the parameters of a fit, in its band.
std::map<std::string, double> truth_of(const Model& model, const PsdModelFit& fit) {
  std::map<std::string, double> truth = model.truth;
  const auto rms = [&](const PsdModel& part) {
    return psd_moments(RadialPsd(part).band(fit.f_min, fit.f_max)).rms_height();
  };
  if (const SumPsd* sum = std::get_if<SumPsd>(&model.roughness)) {
    truth["rms"] = rms(sum->parts[0]);
    truth["floor"] = rms(sum->parts[1]);
  } else {
    truth["rms"] = rms(model.roughness);
  }
  return truth;
}

// With 500 surfaces per model the sampling error of a coverage is 1 %, of a bias 0.045 standard errors. The
// conditions share their surfaces, so the pooled coverage (7,500 intervals, correlated within a surface) is
// known to 0.4 %. With fewer surfaces every tolerance is larger by the square root of their ratio.
void expect_unbiased_fits_and_covering_intervals(int surfaces) {
  const double wider = std::sqrt(double(kAllSurfaces) / surfaces);
  double covered = 0, looks = 0, poor = 0, fitted = 0;
  fmt::print("{:28} {:10} {:9} {:>8} {:>9} {:>9} {:>8}\n", "model", "condition", "parameter", "bias/SE",
             "SE/truth", "std/SE", "cover %");
  for (const Model& model : models()) {
    const Fits fits =
        model.profile() ? fits_of<ProfileWay>(model, surfaces) : fits_of<MapWay>(model, surfaces);
    for (std::size_t c = 0; c < 3; ++c) {
      struct Sums {
        double n = 0, error = 0, square = 0, covered = 0, std = 0;
      };
      std::map<std::string, Sums> sums;
      const std::map<std::string, double> truth = truth_of(model, fits[c][0]);
      for (const PsdModelFit& fit : fits[c]) {
        ASSERT_EQ(fit.status, PsdFitStatus::kConverged) << model.name << fit.message;
        ASSERT_EQ(fit.family, model.family) << model.name << " " << kConditionNames[c];
        fitted += 1;
        poor += fit.goodness < 0.01;
        for (const Warning& warning : fit.warnings) ASSERT_NE(warning.code, "no-line") << model.name;
        for (const PsdParameter& p : fit.parameters) {
          if (!truth.contains(p.name)) continue;
          ASSERT_TRUE(p.identified) << model.name << " " << p.name;
          const double at = truth.at(p.name), error = (p.value - at) / at;
          Sums& sum = sums[p.name];
          sum.n += 1, sum.error += error, sum.square += error * error, sum.std += p.std / at;
          sum.covered += p.lower <= at && at <= p.upper;
        }
      }
      ASSERT_EQ(sums.size(), truth.size());
      for (const auto& [name, sum] : sums) {
        const double bias = sum.error / sum.n, se = std::sqrt(sum.square / sum.n - bias * bias);
        const double coverage = sum.covered / sum.n;
        fmt::print("{:28} {:10} {:9} {:+8.3f} {:9.4f} {:9.3f} {:8.1f}\n", model.name, kConditionNames[c],
                   name, bias / se, se, sum.std / sum.n / se, 100 * coverage);
        const std::string where = model.name + ", " + kConditionNames[c] + ", " + name;
        EXPECT_EQ(sum.n, surfaces) << where;
        EXPECT_LT(std::abs(bias), wider * 0.2 * se) << where;
        EXPECT_GE(coverage, 0.95 - wider * 0.04) << where;
        // A hundred surfaces may all be covered by chance; the pooled bound below detects too wide intervals.
        if (surfaces >= 500) {
          EXPECT_LE(coverage, 0.98) << where;
        }
        covered += sum.covered, looks += sum.n;
      }
    }
  }
  fmt::print("pooled: {:.2f} % of {:.0f}; p-values below 0.01: {:.2f} %\n", 100 * covered / looks, looks,
             100 * poor / fitted);
  EXPECT_GE(covered / looks, 0.95 - wider * 0.01);
  EXPECT_LE(covered / looks, 0.95 + wider * 0.01);
  // 1 % of correct p-values are below 0.01; twice that is allowed, because scores are not exactly normal.
  EXPECT_LT(poor / fitted, 0.02);
}

TEST(PsdSynthetic, FitsAreUnbiasedAndIntervalsCoverCleanWithHolesAndWithALine) {
  expect_unbiased_fits_and_covering_intervals(kFewSurfaces);
}

// Takes minutes: only with `ctest -C statistics -L statistics`.
TEST(FullStatistics, PsdFitsAreUnbiasedAndIntervalsCoverCleanWithHolesAndWithALine) {
  expect_unbiased_fits_and_covering_intervals(kAllSurfaces);
}

}  // namespace
}  // namespace aberfit
