// Tests outliers on random surfaces of known PSD: none on clean surfaces, all on spoilt ones, and after
// rejection the RMS values of the clean surface.
#include "aberfit/spectrum/outliers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/core/units.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "dabam_loader.h"

namespace aberfit {
namespace {

using Eigen::Index;
using test::DabamOnRealData, test::InstrumentsOnRealData, test::ZygoOnRealData, test::load_dabam;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPitch = 1e-3;

std::vector<RadialPsd> roughnesses() {
  const auto power = [](double exponent) {
    return PowerLawPsd{std::nullopt, 1e-22, exponent, 0.1, kInfinity};
  };
  return {RadialPsd(power(2)),
          RadialPsd(power(3)),
          RadialPsd(power(4)),
          RadialPsd(KCorrelationPsd{1e-9, 0.01, 3}),
          RadialPsd(SumPsd{{KCorrelationPsd{1e-9, 0.012, 4}, UniformPsd{1e-10, 0, 1000}}}),
          RadialPsd(UniformPsd{1e-9, 0, 1000})};
}

void take_out_round(HeightMap* map) {
  for (Index r = 0; r < map->rows(); ++r)
    for (Index c = 0; c < map->columns(); ++c)
      if (std::hypot(map->x(c), map->y(r)) > 0.064 || std::hypot(map->x(c), map->y(r) - 0.01) < 0.012)
        map->height(r, c) = std::nan("");
}

constexpr int kShapes = 5;
// Short and long profiles of heights and slopes; a round map with a hole, a square map.
Measurement surface(const RadialPsd& psd, int shape, int seed) {
  RandomSurfaceOptions draw;
  draw.seed = std::uint64_t(seed);
  if (shape >= 3) {
    HeightMap map = random_surface(psd, 128, 128, kPitch, draw);
    if (shape == 3) take_out_round(&map);
    return map;
  }
  Profile profile = random_profile(psd, shape == 0 ? 200 : 3000, kPitch, draw);
  if (shape == 2) {
    const Index n = profile.size() - 1;
    profile.value = Eigen::ArrayXd((profile.value.tail(n) - profile.value.head(n)) / kPitch);
    profile.x.conservativeResize(n);
    profile.quantity = ProfileQuantity::kSlope;
  }
  return profile;
}

Eigen::Map<Eigen::ArrayXd> values(Profile& p) { return {p.value.data(), p.value.size()}; }
Eigen::Map<Eigen::ArrayXd> values(HeightMap& m) { return {m.height.data(), m.height.size()}; }

// Shifts 1 % of the samples up or down by ten standard deviations of the whole.
Measurement with_spikes(Measurement surface, int seed) {
  std::visit(
      [&](auto& s) {
        auto v = values(s);
        const double size =
            10 * std::sqrt(v.isFinite().select((v - v.isFinite().select(v, 0).mean()).square(), 0).sum() /
                           double(v.isFinite().count()));
        const RandomStream stream(std::uint64_t(seed), "outliers-test spikes");
        for (Index i = 0; i < v.size(); ++i) {
          const auto [chance, sign] = stream.uniform_pair(std::uint64_t(i));
          if (chance < 0.01) v[i] += sign < 0.5 ? -size : size;
        }
      },
      surface);
  return surface;
}

Outliers search(const Measurement& data) {
  return std::visit([](const auto& d) { return find_outliers(d); }, data);
}
SurfaceRms rms_of(const Measurement& data) {
  return std::visit([](const auto& d) { return surface_rms(d, {}); }, data);
}

int false_alarms(int count) {
  const std::vector<RadialPsd> mix = roughnesses();
  int alarms = 0;
  for (int i = 0; i < count; ++i)
    if (search(surface(mix[std::size_t(i) % mix.size()], (i / int(mix.size())) % kShapes, i + 1)).count > 0)
      ++alarms;
  return alarms;
}

// Largest relative error of RMS height and slope after rejection, and the smallest change by the spikes.
struct Restored {
  double height = 0, slope = 0, spoilt = kInfinity;
};
Restored restored(int count) {
  const std::vector<RadialPsd> mix = roughnesses();
  Restored worst;
  for (int i = 0; i < count; ++i) {
    const int shape = 1 + (i / int(mix.size())) % (kShapes - 1);  // 200 samples have two spikes or none
    const Measurement clean = surface(mix[std::size_t(i) % mix.size()], shape, 5000 + i);
    Measurement spoilt = with_spikes(clean, i);
    const SurfaceRms truth = rms_of(clean), with = rms_of(spoilt);
    const Warnings said = screen(&spoilt, OutlierTreatment::kReject, {});
    EXPECT_EQ(said.at(0).code, "outliers-rejected");
    const SurfaceRms without = rms_of(spoilt);
    // Heights are integrated slopes, so a lost slope is missing in all later heights.
    const double height = shape == 2 ? 0 : std::abs(without.height / truth.height - 1),
                 slope = std::abs(without.slope / truth.slope - 1);
    EXPECT_LT(height, 0.02) << i;
    EXPECT_LT(slope, 0.02) << i;
    worst.height = std::max(worst.height, height);
    worst.slope = std::max(worst.slope, slope);
    worst.spoilt = std::min(worst.spoilt, with.slope / truth.slope);
  }
  return worst;
}

// The threshold gives 1 alarm in 200 for Gaussian residuals; the probability of 4 in 60 is 3e-4.
TEST(Outliers, NoneOnCleanSurfaces) { EXPECT_LT(false_alarms(60), 4); }

TEST(FullStatistics, OutliersOnFewerThanOnePercentOfCleanSurfaces) {
  const int alarms = false_alarms(500);
  fmt::print("outliers: {} false alarms on 500 clean surfaces\n", alarms);
  EXPECT_LT(alarms, 5);
}

TEST(Outliers, RejectedSpikesGiveTheRmsOfTheCleanSurfaceBack) {
  const Restored worst = restored(24);
  EXPECT_GT(worst.spoilt, 1.2);
}

TEST(FullStatistics, RejectedSpikesGiveTheRmsOfTheCleanSurfaceBack) {
  const Restored worst = restored(480);
  fmt::print(
      "outliers: RMS height within {:.2g}, slope within {:.2g}; spikes had raised the slope at least {:.3g} "
      "times\n",
      worst.height, worst.slope, worst.spoilt);
}

// A pit of 7 x 7 points and a scratch of 30, inside a map and at its rim.
TEST(Outliers, DamagedRegionsAreFoundWhole) {
  for (const std::size_t kind : {2u, 3u, 4u}) {
    auto map = std::get<HeightMap>(surface(roughnesses()[kind], 4, 11));
    const Grid clean = map.height;
    const double depth = 10 * rms(map);
    Mask damage = Mask::Constant(128, 128, false);
    damage.block(40, 60, 7, 7) = true;
    damage.block(90, 20, 1, 30) = true;
    damage.block(0, 100, 3, 3) = true;
    map.height = damage.select(clean - depth, clean);
    const Outliers outliers = find_outliers(map);
    EXPECT_TRUE((outliers.found || !damage).all()) << kind << ": " << outliers.count;
    EXPECT_LE(outliers.count, damage.count() + 3) << kind;
  }
}

TEST(Outliers, DamageOfAProfileIsFoundWhole) {
  auto profile = std::get<Profile>(surface(roughnesses()[4], 1, 3));
  const double depth = 10 * rms(profile);
  for (Index i = 700; i < 709; ++i) profile.value[i] += depth;
  profile.value[0] += depth, profile.value[2999] -= depth;
  const Outliers outliers = find_outliers(profile);
  for (const Index i : {0, 700, 704, 708, 2999}) EXPECT_TRUE(outliers.found(0, i)) << i;
  EXPECT_LE(outliers.count, 13);
}

// Steps and smooth bends belong to the surface: a turned-down rim, a figure without noise.
TEST(Outliers, StepsAndSmoothShapesAreNone) {
  auto map = std::get<HeightMap>(surface(roughnesses()[4], 4, 12));
  const Grid clean = map.height;
  const double size = rms(map);
  map.height.block(64, 0, 64, 128) += 20 * size;
  EXPECT_EQ(find_outliers(map).count, 0);
  map.height = clean;
  map.height.block(64, 64, 64, 64) += 20 * size;
  EXPECT_LE(find_outliers(map).count, 1);  // the corner
  for (Index r = 0; r < 128; ++r)
    for (Index c = 0; c < 128; ++c) {
      const double x = map.x(c) / 0.064, y = map.y(r) / 0.064;
      map.height(r, c) = clean(r, c) - 30 * size * std::pow(std::max(0.0, std::abs(x) - 0.8) / 0.2, 2);
      if (std::hypot(x, y) > 1) map.height(r, c) = std::nan("");
    }
  EXPECT_EQ(find_outliers(map).count, 0);
  for (Index r = 0; r < 128; ++r)
    for (Index c = 0; c < 128; ++c) {
      const double x = map.x(c) / 0.064, y = map.y(r) / 0.064;
      map.height(r, c) = 1e-6 * (x * x * x * y + std::pow(x * x + y * y, 3)) + 1e-7 * std::cos(20 * x);
    }
  EXPECT_EQ(find_outliers(map).count, 0);
}

// Heights are rounded to steps of twice their roughness, so more than half of the residuals are zero.
TEST(Outliers, RoundedHeightsAreNone) {
  auto map = std::get<HeightMap>(surface(roughnesses()[3], 4, 13));
  const double step = 2 * rms(map);
  map.height = (map.height / step).round() * step;
  EXPECT_EQ(find_outliers(map).count, 0);
}

TEST(Screen, WarnsWithTheEffectAndLeavesTheData) {
  const Measurement clean = surface(roughnesses()[3], 4, 14), spoilt = with_spikes(clean, 14);
  Measurement data = spoilt;
  const Warnings said = screen(&data, OutlierTreatment::kWarn, {});
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].code, "outliers");
  const Outliers outliers = search(spoilt);
  EXPECT_NE(said[0].message.find(fmt::format("{} of 16,384 samples", outliers.count)), std::string::npos)
      << said[0].message;
  Measurement taken = spoilt;
  take_out(&std::get<HeightMap>(taken), outliers.found);
  for (const double slope : {rms_of(spoilt).slope, rms_of(taken).slope})
    EXPECT_NE(said[0].message.find(format_quantity(slope, Dimension::kAngle)), std::string::npos)
        << said[0].message;
  EXPECT_TRUE((std::get<HeightMap>(data).height == std::get<HeightMap>(spoilt).height).all());
  EXPECT_TRUE(screen(&data, OutlierTreatment::kKeep, {}).empty());
  data = clean;
  EXPECT_TRUE(screen(&data, OutlierTreatment::kWarn, {}).empty());
}

// 1 % of the record's length for heights without their parabola, 1 rad for slopes.
TEST(Screen, WarnsOfValuesThatNoMirrorHas) {
  const auto warned = [](Measurement data) {
    const Warnings said = screen(&data, OutlierTreatment::kKeep, {});
    return said.size() == 1 && said[0].code == "unusual";
  };
  auto profile = std::get<Profile>(surface(roughnesses()[5], 1, 15));
  const Profile flat = [&] {
    Profile p = profile;
    p.value = detrend(profile, {}).value;
    return p;
  }();
  const double length = 2999 * kPitch, span = flat.value.maxCoeff() - flat.value.minCoeff();
  for (const double share : {0.0099, 0.0101}) {
    profile.value = flat.value * (share * length / span) + 3 * flat.x.square();
    EXPECT_EQ(warned(profile), share > 0.01);
  }
  auto slopes = std::get<Profile>(surface(roughnesses()[5], 2, 16));
  const double most = slopes.value.abs().maxCoeff();
  slopes.value *= 0.99 / most;
  EXPECT_FALSE(warned(slopes));
  slopes.value *= 1.02;
  EXPECT_TRUE(warned(slopes));
  auto map = std::get<HeightMap>(surface(roughnesses()[5], 4, 17));
  EXPECT_FALSE(warned(map));
  map.height *= 1e6;
  EXPECT_TRUE(warned(map));
}

// A pitch or unit that gives lengths outside 0.1 um (diagonal of a map) to 50 m is probably wrong.
TEST(Screen, WarnsOfLengthsThatNobodyMeasures) {
  const auto said = [](Measurement data) {
    const Warnings warnings = screen(&data, OutlierTreatment::kKeep, {});
    return warnings.empty() ? "" : warnings[0].code + ": " + warnings[0].message;
  };
  auto map = std::get<HeightMap>(surface(roughnesses()[5], 4, 17));
  const auto diagonal = [&](double length) {
    const double across = std::hypot(double(map.columns()), double(map.rows()));
    map.pitch_x = map.pitch_y = length / across;
    HeightMap scaled = map;
    scaled.height *= 1e-3 * length / (map.height.maxCoeff() - map.height.minCoeff());
    return said(scaled);
  };
  EXPECT_EQ(diagonal(49.9), "");
  EXPECT_EQ(diagonal(1.01e-7), "");
  EXPECT_NE(diagonal(100).find("unusual: the map's diagonal is 100 m"), std::string::npos) << diagonal(100);
  EXPECT_NE(diagonal(100).find("100 mm for example"), std::string::npos);
  EXPECT_NE(diagonal(9e-8).find("the map's diagonal is 90 nm"), std::string::npos);
  for (const int axes : {1, 2}) {  // heights and slopes
    auto profile = std::get<Profile>(surface(roughnesses()[5], axes, 15));
    EXPECT_EQ(said(profile), "");
    profile.x *= 60 / (profile.x[profile.size() - 1] - profile.x[0]);
    EXPECT_NE(said(profile).find("the record's length is 60 m"), std::string::npos) << said(profile);
  }
}

// Mirrors for synchrotrons, an interferogram, and two microscope maps.
TEST_F(DabamOnRealData, HasOrdinaryLengthsHeightsAndSlopes) {
  int profiles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(file(""))) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".dat" || !stem.starts_with("dabam-")) continue;
    Measurement data = load_dabam(stem.substr(6));
    for (const Warning& warning : screen(&data, OutlierTreatment::kKeep, {}))
      ADD_FAILURE() << stem << ": " << warning.message;
    ++profiles;
  }
  EXPECT_GE(profiles, 14);
}

void expect_ordinary(const std::string& path) {
  MeasuredSource source;
  source.path = path;
  source.wavefront = false;
  Measurement data = read_measurement(source);
  for (const Warning& warning : screen(&data, OutlierTreatment::kKeep, {}))
    ADD_FAILURE() << path << ": " << warning.message;
}

TEST_F(ZygoOnRealData, HasAnOrdinarySize) { expect_ordinary(file("valid_zygo_dat_file.dat")); }

TEST_F(InstrumentsOnRealData, HaveOrdinarySizes) {
  for (const char* name : {"opd-1.opd", "sdf-1.sdf", "x3p-2.x3p"}) expect_ordinary(file(name));
}

}  // namespace
}  // namespace aberfit
