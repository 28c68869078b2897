// The reference studies on measured parts must give what their READMEs claim. The truth is the surface in the
// example what_would_an_instrument_write_of_my_mirror.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <iostream>
#include <map>

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

TEST(MapZygo, LeavesATenthAsRoughAsTheRestAndShowsTheTermsInLight) {
  const ResultDocument result = run_map_fit(read_study(kFits + "map-zygo/study.json"), {});
  ASSERT_TRUE(result.map.fit.has_value());
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged);
  EXPECT_EQ(result.map.fit->rank, 228);
  EXPECT_LT(result.map.fit->rms_residual, 0.25 * result.map.fit->rms_map);
  EXPECT_NEAR(result.map.fit->rms_held_out / result.map.fit->rms_residual, 1, 0.1);
  // At f/10 rays are no model of so small a spot, so the terms' spot is by wave optics.
  EXPECT_EQ(result.scene.model, "waves");
  ASSERT_TRUE(result.map.light && result.map.light->terms.obstacle.empty());
  EXPECT_EQ(result.fitted.values[2], result.map.light->terms.ee90);
  EXPECT_LT(result.map.light->filled_share, 0.05);
  // The Strehl ratio of the map is close to that of its terms, because the residual scatters little.
  EXPECT_NEAR(result.map.light->measured.strehl / result.map.light->terms.strehl, 1, 0.05);
  // We evaluate the terms at the points of the map; the difference must be the reported residual.
  MeasuredSource source;
  source.path = kFits + "map-zygo/interferogram.dat";
  HeightMap map = std::get<HeightMap>(read_measurement(source));
  const Circle circle = enclosing_circle(map);
  EXPECT_NEAR(std::hypot(circle.x, circle.y), 0, 1e-9);  // bites and dropouts do not move it
  move_origin(&map, circle.x, circle.y);
  std::vector<double> x, y, h;
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column)
      if (std::isfinite(map.height(row, column)) &&
          std::hypot(map.x(column), map.y(row)) <= result.fitted.radius) {
        x.push_back(map.x(column)), y.push_back(map.y(row)), h.push_back(map.height(row, column));
      }
  const auto array = [](std::vector<double>& v) -> Eigen::ArrayXd {
    return Eigen::Map<Eigen::ArrayXd>(v.data(), Eigen::Index(v.size()));
  };
  SurfaceField field;
  SurfaceOperator(result.fitted.terms, array(x), array(y)).apply(result.fitted.fit.coefficients, &field);
  // Piston and tilt were fitted, too, and dropped, so we subtract them from the difference.
  const Eigen::ArrayXd rest = array(h) - field.height;
  Eigen::MatrixXd plane(rest.size(), 3);
  plane << Eigen::VectorXd::Ones(rest.size()), array(x).matrix(), array(y).matrix();
  const Eigen::VectorXd left = rest.matrix() - plane * LeastSquares(plane).solve(rest.matrix());
  EXPECT_NEAR(std::sqrt(left.squaredNorm() / double(left.size())) / result.map.fit->rms_residual, 1, 0.02);
}

TEST(MapZygo, GivesBackTheTermsAndTheRoughnessThatWerePutIn) {
  const ResultDocument result = run_map_fit(read_study(kFits + "map-zygo/study.json"), {});
  const std::map<int, double> truth = {{4, 12e-9}, {5, -18e-9}, {6, 22e-9},  {7, 9e-9}, {8, -6e-9},
                                       {9, 4e-9},  {10, -5e-9}, {11, 10e-9}, {22, 4e-9}};
  constexpr double kLooks = 4.5;  // standard deviations: 2e-3 that one of 228 exceeds it
  double squares = 0;
  for (int noll = 4; noll <= 231; ++noll) {
    const auto& modes = result.fitted.terms.zernike;
    const auto at = std::find(modes.begin(), modes.end(), zernike_from_noll(noll)) - modes.begin();
    ASSERT_LT(std::size_t(at), modes.size());
    const auto known = truth.find(noll);
    const double miss = (result.fitted.fit.coefficients[at] - (known == truth.end() ? 0 : known->second)) /
                        result.fitted.fit.coefficient_std[at];
    EXPECT_LT(std::abs(miss), kLooks) << noll;
    squares += miss * miss / 228;
  }
  EXPECT_LT(std::sqrt(squares), 1.2);  // the reported deviations are not too small
  // The residual is 8 nm without the variance of 228 of the band's 5,260 modes; its own spread is 1 %.
  EXPECT_NEAR(result.map.fit->rms_residual / (8e-9 * std::sqrt(1 - 228. / 5260)), 1, 0.03);
}

TEST(MapZygo, TracesToTheSameEe90FromItsGridSag) {
  constexpr double kAllowed = 1e-3;
  const Study study = read_study(kFits + "map-zygo/study.json");
  const ResultDocument result = run_map_fit(study, {});
  const ExportInput input{result.fitted.terms, result.fitted.fit.coefficients, study.aperture,
                          study.wavelength,    study.output.export_grid,       study.title};
  const test::SagFile file = test::parse_sag_file(export_file(ExportFormat::kZemaxGridSag, input).second);
  const PupilSample pupil = make_pupil(study.aperture, {PupilLayout::kPolar, 65536, 1});
  SurfaceField truth, read;
  SurfaceOperator(result.fitted.terms, pupil.x, pupil.y).apply(result.fitted.fit.coefficients, &truth);
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
  // The RMS height of the model in its band must agree with the sum over the bins within chance. A steep
  // spectrum has most of it in its first ordinates (Welch and Satterthwaite).
  const RadialPsd model(measured.result.model);
  double in_bins = 0, in_model = 0, variance = 0;
  for (Eigen::Index b = 0; b < measured.estimate.psd.size(); ++b) {
    const double low = measured.estimate.low[b], high = measured.estimate.high[b];
    if (low < model.f_min() || high > model.f_max()) continue;
    in_bins += measured.estimate.psd[b] * (high - low);
    const double expected = measured.result.expected[b] * (high - low);
    in_model += expected;
    variance += 2 / measured.estimate.dof[b] * expected * expected;
  }
  const double dof = 2 * in_model * in_model / variance;
  const boost::math::chi_squared chance(dof);
  EXPECT_GT(in_bins / in_model, boost::math::quantile(chance, 0.001) / dof) << dof;
  EXPECT_LT(in_bins / in_model, boost::math::quantile(chance, 0.999) / dof) << dof;

  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged) << result.fitted.fit.message;
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent);
  const double rest = result.band.shares ? result.band.shares->rest_rms : 0;
  EXPECT_NEAR(std::hypot(result.fitted.surface.rms_height, rest) / rms_height_on(study.aperture, model), 1,
              2e-3);
  if (result.band.shares) {
    EXPECT_GE(result.judgement.perfect->mismatch, 5);  // a margin that sees the roughness
  } else {
    EXPECT_TRUE(result.scene.numbers.kappa_rule_allows_rays) << result.scene.numbers.reason;
  }
}

INSTANTIATE_TEST_SUITE_P(Fits, MeasuredProfile, testing::Values("measured-turning-lines", "measured-smooth"),
                         [](const auto& study) {
                           std::string name = study.param;
                           std::erase(name, '-');
                           return name;
                         });

// Expects amplitude [m^4] (f m)^-exponent of the file, with heights multiplied by `scale`.
void expect_power_law(const MeasuredPsd& measured, double amplitude, double exponent, double scale) {
  const PsdModelFit& fit = measured.result;
  EXPECT_EQ(fit.family, PsdFamily::kPowerLaw);
  const std::map<std::string, double> truth = {{"amplitude", amplitude * scale * scale},
                                               {"exponent", exponent}};
  for (const PsdParameter& parameter : fit.parameters)
    if (const auto known = truth.find(parameter.name); known != truth.end()) {
      EXPECT_LT(parameter.lower, known->second) << parameter.name;
      EXPECT_GT(parameter.upper, known->second) << parameter.name;
    }
  // 2 pi int A f^(1 - exponent) df over the band of the fit agrees within the interval of the parameter.
  const auto integral = [&](double f) { return std::pow(f, 2 - exponent) / (exponent - 2); };
  const double rms =
      scale * std::sqrt(2 * EIGEN_PI * amplitude * (integral(fit.f_min) - integral(fit.f_max)));
  EXPECT_EQ(fit.parameters.front().name, "rms");
  EXPECT_LT(fit.parameters.front().lower, rms);
  EXPECT_GT(fit.parameters.front().upper, rms);
  EXPECT_LT(fit.parameters.front().upper / fit.parameters.front().lower, 2.5);  // and the interval is narrow
  for (const Warning& warning : fit.warnings) EXPECT_NE(warning.code, "poor-fit");
}

TEST(MeasuredSmooth, FindsTheLawThatWasPutInUnderTheEllipse) {
  const MeasuredPsd measured = measured_psd_of(read_study(kFits + "measured-smooth/study.json"));
  expect_power_law(measured, 2.5e-17, 4.5, 40);
  EXPECT_TRUE(measured.estimate.lines.empty());
  // Raw slopes of 100 urad and more belong to the ellipse; the rest is 40 times the roughness.
  const Profile& raw = std::get<Profile>(measured.data.front());
  EXPECT_LT(measured.estimate.rms_slope, 0.1 * raw.value.abs().maxCoeff());
}

TEST(MeasuredTurningLines, FindsTheLineAndLeavesItOutOfTheModel) {
  const Study study = read_study(kFits + "measured-turning-lines/study.json");
  const MeasuredPsd& measured = measured_psd_of(study);
  expect_power_law(measured, 4e-18, 3, 80);
  ASSERT_EQ(measured.estimate.lines.size(), 1u);
  const SpectralLine& line = measured.estimate.lines.front();
  EXPECT_NEAR(line.frequency, 125, 0.3 * measured.estimate.resolution);
  // The line has 80 times 0.3 nm, of which the trapezoid rule over the slopes leaves x/tan(x), x = pi/8. The
  // continuum adds an amplitude of 1/sqrt(2 strength); we allow three times that.
  EXPECT_NEAR(line.rms / (80 * 0.3e-9 * (EIGEN_PI / 8) / std::tan(EIGEN_PI / 8)), 1,
              3 / std::sqrt(2 * line.strength));
  // Without the search the line stays in its bin.
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
