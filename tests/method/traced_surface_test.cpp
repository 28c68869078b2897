// A surface from a file may differ from the study's roughness; its own slopes decide the grid.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/study/read_study.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

constexpr double kFocal = 0.2, kDiameter = 0.1, kWave = 632.8e-9;  // f/2

Study smooth_study(const std::string& rest) {
  return parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "0.2 m"}, "light": {"wavelength": "632.8 nm"},
          "aperture": {"shape": "circle", "diameter": "0.1 m"}, "roughness": {"psd": {"model": "uniform",
          "rms": "5 nm", "f_min": "10 /m", "f_max": "40 /m"}})" +
          rest + "}",
      "study.json");
}

GivenSurface zernikes(const std::vector<ZernikeMode>& modes, double rms) {
  GivenSurface surface;
  surface.terms.radius = kDiameter / 2;
  surface.terms.zernike = modes;
  surface.coefficients.resize(Eigen::Index(modes.size()));
  for (Eigen::Index k = 0; k < surface.coefficients.size(); ++k)
    surface.coefficients[k] = std::cos(2.7 * double(k * k) + 1);
  surface.coefficients *= rms / surface.coefficients.norm();
  return surface;
}

// The first `count` modes of order n.
std::vector<ZernikeMode> of_order(int n, int count) {
  std::vector<ZernikeMode> modes;
  for (int m = -n; m <= n && int(modes.size()) < count; m += 2) modes.push_back({n, m});
  return modes;
}

TEST(TracedSurface, HasTheGridOfItsOwnLight) {
  std::vector<ZernikeMode> high;
  for (int n = 39; n <= 40; ++n)
    for (const ZernikeMode& mode : of_order(n, 40)) high.push_back(mode);
  for (const GivenSurface& surface :
       {zernikes(high, 22e-9), zernikes({{30, 0}, {32, 0}}, 25e-9), zernikes(of_order(24, 9), 40e-9)}) {
    const TraceReport report =
        trace_surface(smooth_study(R"(, "target": {"statistics": {"ee50": {}, "ee90": {}}})"), surface, 1);
    ASSERT_FALSE(report.statistics.empty());
    EXPECT_EQ(report.model, FocusModel::kWaves);
    const DiffractionPupil cells = diffraction_pupil(CircleAperture{kDiameter}, kFocal, kDiameter / 720);
    SurfaceField field;
    SurfaceOperator(surface.terms, cells.sample, focus_operator(FocusModel::kWaves, 1))
        .apply(surface.coefficients, &field);
    std::vector<Statistic> radii;
    std::vector<double> traced;
    for (const TracedStatistic& one : report.statistics) {
      const auto* radius = std::get_if<EncircledEnergyRadius>(&one.statistic);
      if (!radius) continue;
      EXPECT_TRUE(std::isfinite(one.value)) << statistic_name(one.statistic);
      if (radius->dz == 0) radii.push_back(one.statistic), traced.push_back(one.value);
    }
    ASSERT_FALSE(radii.empty());
    Eigen::VectorXd truth;
    ASSERT_TRUE(
        evaluate_diffraction({cells, kFocal, kWave}, field.height, radii, 2, nullptr, &truth, nullptr));
    for (std::size_t k = 0; k < radii.size(); ++k)
      EXPECT_NEAR(traced[k] / truth[Eigen::Index(k)], 1, 0.01) << statistic_name(radii[k]);
  }
}

// All rays miss the focus, so no statistic has a value.
TEST(TracedSurface, WithoutAnyValueIsAnError) {
  for (const double height : {0.2, 1.0, 30.0}) {
    const Study study = smooth_study(
        R"(, "target": {"theory": "geometric", "statistics": {"ee50": {}, "ee90": {}}}, "trace": {"model": "rays"})");
    try {
      trace_surface(study, zernikes({{1, 1}}, height), 1);
      ADD_FAILURE() << height;
    } catch (const ComputationError& error) {
      EXPECT_NE(std::string(error.what()).find("no statistic"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace aberfit
