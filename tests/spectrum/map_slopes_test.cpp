// Tests RMS slopes of maps along x, along y and their mean against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;

// Waves along both axes with whole periods in the map.
HeightMap waves(Eigen::Index columns, Eigen::Index rows, double pitch_x, double pitch_y, double along_x,
                double along_y) {
  HeightMap map;
  map.pitch_x = pitch_x, map.pitch_y = pitch_y;
  map.height.resize(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      map.height(r, c) = along_x * std::sin(2 * kPi * 4 * double(c) / double(columns)) +
                         along_y * std::sin(2 * kPi * 3 * double(r) / double(rows));
  return map;
}

// A central difference of a sine is its slope times sin(x)/x, where x is the phase between points.
double slope_of(double amplitude, double periods, Eigen::Index points, double pitch) {
  return amplitude * std::sin(2 * kPi * periods / double(points)) / pitch / std::sqrt(2.0);
}

TEST(MapSlopes, AreThoseAlongEachAxisAndTheirMean) {
  struct Strip {
    Eigen::Index columns, rows;
    double pitch_x, pitch_y, along_x, along_y;
  };
  for (const Strip& s :
       {Strip{128, 96, 1e-3, 0.25e-3, 10e-9, 40e-9}, Strip{96, 128, 1e-4, 1e-3, 10e-9, 10e-9},
        Strip{100, 100, 1e-3, 1e-3, 30e-9, 1e-9}}) {
    const HeightMap map = waves(s.columns, s.rows, s.pitch_x, s.pitch_y, s.along_x, s.along_y);
    const SurfaceRms rms = surface_rms(map, {DetrendShape::kNone});
    const double x = slope_of(s.along_x, 4, s.columns, s.pitch_x),
                 y = slope_of(s.along_y, 3, s.rows, s.pitch_y);
    // The ends of a line have no central difference, so the mean square lacks two points.
    EXPECT_NEAR(rms.slope_x / x, 1, 3.0 / double(s.columns));
    EXPECT_NEAR(rms.slope_y / y, 1, 3.0 / double(s.rows));
    EXPECT_NEAR(rms.slope, std::sqrt((rms.slope_x * rms.slope_x + rms.slope_y * rms.slope_y) / 2),
                1e-12 * rms.slope);
    PsdEstimatorOptions options;
    options.detrend.shape = DetrendShape::kNone;
    const PsdEstimate estimate = estimate_psd(map, options);
    EXPECT_EQ(estimate.rms_slope_x, rms.slope_x);
    EXPECT_EQ(estimate.rms_slope_y, rms.slope_y);
    EXPECT_EQ(estimate.rms_slope, rms.slope);
  }
}

TEST(MapSlopes, OfProfilesThereAreNone) {
  Profile profile;
  profile.x = Eigen::ArrayXd::LinSpaced(64, 0, 0.063);
  profile.value = 1e-9 * (400 * profile.x).sin();
  EXPECT_TRUE(std::isnan(surface_rms(profile, {}).slope_x));
  EXPECT_TRUE(std::isnan(estimate_psd(profile, {}).rms_slope_y));
}

}  // namespace
}  // namespace aberfit
