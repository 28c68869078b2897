// The reference studies on measured parts: what their READMEs claim.
#include <gtest/gtest.h>

#include <iostream>

#include "aberfit/commands/run.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/report/exports.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/height_on_aperture.h"
#include "report/bicubic_reader.h"

namespace aberfit {
namespace {

const std::string kFits = ABERFIT_SOURCE_DIR "/fits/";

double ee90(const Study& study, const PupilSample& pupil, const SurfaceField& field) {
  const RayBundle rays = trace(study.mirror, pupil, field), nominal = trace_nominal(study.mirror, pupil);
  return evaluate_exact({rays, nominal, field.height}, {EncircledEnergyRadius{0.9, 0}}, 1)[0];
}

TEST(MapZygo, LeavesATenthAsRoughAsTheRestAndSaysThatRaysAreNotEnough) {
  const ResultDocument result = run_map_fit(read_study(kFits + "map-zygo/study.json"), {});
  ASSERT_TRUE(result.map.has_value());
  EXPECT_EQ(result.fit.status, FitStatus::kConverged);
  EXPECT_EQ(result.map->rank, 228);
  EXPECT_LT(result.map->rms_residual, 0.25 * result.map->rms_map);
  EXPECT_NEAR(result.map->rms_held_out / result.map->rms_residual, 1, 0.1);
  bool warned = false;
  for (const Warning& warning : result.warnings) warned = warned || warning.code == "rays-not-valid";
  EXPECT_TRUE(warned);
  // The terms at the points of the map itself: what they leave is the residual that is stated.
  MeasuredSource source;
  source.path = ABERFIT_TEST_DATA "/prysm-zygo/valid_zygo_dat_file.dat";
  HeightMap map = std::get<HeightMap>(read_measurement(source));
  const Circle circle = enclosing_circle(map);
  move_origin(&map, circle.x, circle.y);
  std::vector<double> x, y, h;
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      if (std::isfinite(map.height(row, column)) && std::hypot(map.x(column), map.y(row)) <= result.radius) {
        x.push_back(map.x(column)), y.push_back(map.y(row)), h.push_back(map.height(row, column));
      }
  const auto array = [](std::vector<double>& v) -> Eigen::ArrayXd {
    return Eigen::Map<Eigen::ArrayXd>(v.data(), Eigen::Index(v.size()));
  };
  SurfaceField field;
  SurfaceOperator(result.terms, array(x), array(y)).apply(result.fit.coefficients, &field);
  // Piston and tilt were fitted along and dropped: take them off the difference.
  const Eigen::ArrayXd rest = array(h) - field.height;
  Eigen::MatrixXd plane(rest.size(), 3);
  plane << Eigen::VectorXd::Ones(rest.size()), array(x).matrix(), array(y).matrix();
  const Eigen::VectorXd left = rest.matrix() - plane * LeastSquares(plane).solve(rest.matrix());
  EXPECT_NEAR(std::sqrt(left.squaredNorm() / double(left.size())) / result.map->rms_residual, 1, 0.02);
}

TEST(MapZygo, TracesToTheSameEe90FromItsGridSag) {
  constexpr double kAllowed = 1e-3;
  const Study study = read_study(kFits + "map-zygo/study.json");
  const ResultDocument result = run_map_fit(study, {});
  const ExportInput input{result.terms,     result.fit.coefficients,  study.aperture,
                          study.wavelength, study.output.export_grid, study.title};
  const test::SagFile file = test::parse_sag_file(export_file(ExportFormat::kZemaxGridSag, input).second);
  const PupilSample pupil = make_pupil(study.aperture, {PupilLayout::kPolar, 65536, 1});
  SurfaceField truth, read;
  SurfaceOperator(result.terms, pupil.x, pupil.y).apply(result.fit.coefficients, &truth);
  read.resize(pupil.size());
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const test::SagPoint point = test::evaluate(file, pupil.x[i], pupil.y[i], test::Interpolation::kBicubic);
    ASSERT_TRUE(point.valid) << pupil.x[i] << ' ' << pupil.y[i];
    read.height[i] = point.z, read.slope_x[i] = point.zx, read.slope_y[i] = point.zy;
  }
  const double exact = ee90(study, pupil, truth), again = ee90(study, pupil, read);
  std::cout << "EE90 " << exact * 1e6 << " um, from the grid sag " << again / exact - 1 << " off\n";
  EXPECT_NEAR(again / exact, 1, kAllowed);
}

class MeasuredProfile : public testing::TestWithParam<const char*> {};

TEST_P(MeasuredProfile, GivesAModelOfItsBinsAndTermsWithThatFocus) {
  const Study study = read_study(kFits + GetParam() + "/study.json");
  const MeasuredPsd& measured = measured_psd_of(study);
  ASSERT_EQ(measured.result.status, PsdFitStatus::kConverged);
  // The model's profile PSD holds as much height in its band as the bins themselves, summed without any
  // model. A band of a few tens of independent ordinates with a steep spectrum scatters by tens of percent.
  const RadialPsd model(measured.result.model);
  double in_bins = 0, in_model = 0;
  for (Eigen::Index b = 0; b < measured.estimate.psd.size(); ++b) {
    const double low = measured.estimate.low[b], high = measured.estimate.high[b];
    if (low < model.f_min() || high > model.f_max()) continue;
    in_bins += measured.estimate.psd[b] * (high - low);
    in_model += measured.result.expected[b] * (high - low);
  }
  EXPECT_GT(in_bins, 0);
  EXPECT_NEAR(std::log(in_model / in_bins), 0, std::log(2.0));

  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.fit.status, FitStatus::kConverged) << result.fit.message;
  EXPECT_EQ(result.verdict, Verdict::kEquivalent);
  const double rest = result.shares ? result.shares->rest_rms : 0;
  EXPECT_NEAR(std::hypot(result.surface.rms_height, rest) / rms_height_on(study.aperture, model), 1, 2e-3);
  if (result.shares) {
    EXPECT_GE(result.perfect->mismatch, 5);  // a margin that sees the roughness
  } else {
    EXPECT_TRUE(result.scene.rays_are_valid) << result.scene.reason;
  }
}

INSTANTIATE_TEST_SUITE_P(Fits, MeasuredProfile, testing::Values("measured-turning-lines", "measured-smooth"),
                         [](const auto& study) {
                           std::string name = study.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(MeasuredTurningLines, FindsTheLineAndLeavesItOutOfTheModel) {
  const Study study = read_study(kFits + "measured-turning-lines/study.json");
  const MeasuredPsd& measured = measured_psd_of(study);
  bool found = false;  // the README of the data: period 8 mm
  for (const SpectralLine& line : measured.estimate.lines)
    found = found || std::abs(line.frequency - 125) < measured.estimate.resolution;
  EXPECT_TRUE(found);
  EXPECT_EQ(measured.result.status, PsdFitStatus::kConverged);
  // Without the search the line stands in its bin.
  PsdEstimatorOptions options = measured.estimator;
  options.find_lines = false;
  const PsdEstimate with_line = estimate_psd(std::get<Profile>(measured.data.front()), options);
  const auto near_line = [](const PsdEstimate& e) {
    double psd = 0;
    for (Eigen::Index b = 0; b < e.psd.size(); ++b)
      if (e.low[b] <= 125.2 && e.high[b] > 125.2) psd = e.psd[b];
    return psd;
  };
  EXPECT_GT(near_line(with_line), 3 * near_line(measured.estimate));
}

}  // namespace
}  // namespace aberfit
