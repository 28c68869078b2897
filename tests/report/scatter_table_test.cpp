#include "aberfit/report/scatter_table.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "aberfit/report/documents.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/roughness/psd_table.h"

using namespace aberfit;

namespace {

constexpr double kLambda = 550e-9;
const double kInf = std::numeric_limits<double>::infinity();

ScatterExport export_of(const PsdModel& rest) {
  ScatterExport result;
  result.title = "a mirror\nof two lines";
  const ScatterFunction scatter(RadialPsd(rest), kLambda);
  result.table = scatter_table(scatter);
  result.abg = {fit_abg(scatter)};
  result.rest = rest;
  return result;
}

// The number after a text; the text must be there.
double number_after(const std::string& text, const std::string& what) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? 0 : std::stod(text.substr(at + what.size()));
}

}  // namespace

TEST(ScatterCsv, ReadsBackToTheTable) {
  const ScatterExport scatter = export_of(KCorrelationPsd{11e-9, 0.3, 2.8, 6, 200});
  std::istringstream in(scatter_csv(scatter));
  std::string line;
  while (std::getline(in, line) && line.starts_with('#')) {
  }
  EXPECT_EQ(line, "theta_rad,asf_per_sr,bsdf_per_sr,tis_within");
  Eigen::Index row = 0;
  double light = 0, last = 0;
  for (; std::getline(in, line); ++row) {
    std::array<double, 4> cell{};
    std::istringstream cells(line);
    for (double& c : cell) {
      std::string text;
      ASSERT_TRUE(std::getline(cells, text, ','));
      c = std::stod(text);
    }
    ASSERT_LT(row, scatter.table.theta.size());
    EXPECT_NEAR(cell[0], scatter.table.theta[row], 1e-11 * cell[0]);
    EXPECT_NEAR(cell[1], scatter.table.asf_per_sr[row], 1e-8 * cell[1]);
    EXPECT_NEAR(cell[2], scatter.table.bsdf_per_sr[row], 1e-8 * cell[2]);
    EXPECT_NEAR(cell[3], scatter.table.tis_within[row], 1e-11);
    EXPECT_GE(cell[3], last);
    light = last = cell[3];
  }
  EXPECT_EQ(row, scatter.table.theta.size());
  EXPECT_NEAR(light, scatter.table.tis, 1e-11);
}

TEST(ScatterCsv, SaysWhatItIsOf) {
  const KCorrelationPsd long_waves{11e-9, 0.3, 2.8, 6, 200};
  ScatterExport scatter = export_of(long_waves);
  AbgOptions free;  // without a fixed knee of 0.3 m
  free.least_b = 1e-30;
  scatter.abg = {fit_abg(ScatterFunction(RadialPsd(long_waves), kLambda), free)};
  const std::string text = scatter_csv(scatter);
  EXPECT_NE(text.find("# a mirror of two lines\n"), std::string::npos);
  EXPECT_DOUBLE_EQ(number_after(text, "wavelength_m = "), kLambda);
  EXPECT_NEAR(number_after(text, "rms_height_m = "), 11e-9, 1e-16);
  EXPECT_NEAR(number_after(text, "rms_slope = ") / scatter.table.rms_slope, 1, 1e-8);
  EXPECT_NEAR(number_after(text, "exp(-g^2) = ") / scatter.table.tis, 1, 1e-8);
  EXPECT_NE(text.find("roughness of 6 to 200 /m"), std::string::npos);
  const AbgFit fit = scatter.abg[0];
  EXPECT_NEAR(number_after(text, "A = ") / fit.model.a, 1, 1e-8);
  EXPECT_NEAR(number_after(text.substr(text.find("# ABg")), ", g = ") / fit.model.g, 1, 1e-8);
  EXPECT_NEAR(number_after(text, "where its error is at most ") / (100 * fit.largest_error), 1, 5e-3);
  EXPECT_NE(text.find("counts their energy twice"), std::string::npos);
  // The fitted model extends beyond 200 /m.
  ASSERT_GT(std::abs(fit.tis / scatter.table.tis - 1), 0.1);
  EXPECT_NE(text.find("the model continues outside the range"), std::string::npos);
  ASSERT_FALSE(fit.at_least_b);
  free.least_b = 1.5 * fit.model.b;
  scatter.abg = {fit_abg(ScatterFunction(RadialPsd(long_waves), kLambda), free)};
  ASSERT_TRUE(scatter.abg[0].at_least_b && scatter.abg[0].describes());
  EXPECT_NE(scatter_csv(scatter).find("B has the least allowed value"), std::string::npos);
  EXPECT_EQ(text.find("orders beyond 90 degrees"), std::string::npos);

  scatter.has_terms = false;
  scatter.abg.clear();
  scatter.rest.reset();
  const std::string alone = scatter_csv(scatter);
  EXPECT_EQ(alone.find("twice"), std::string::npos);
  EXPECT_NE(alone.find("there are no terms beside it"), std::string::npos);
  EXPECT_EQ(alone.find("ABg"), std::string::npos);
  EXPECT_EQ(alone.find("PSD:"), std::string::npos);
  EXPECT_NE(scatter_csv(export_of(UniformPsd{5e-8, 0, 1.5e6})).find("orders beyond 90 degrees"),
            std::string::npos);
}

// Two knees, two bands, two Gaussians, or a knee at a smaller sine than B allows: none is described by one
// knee and exponent.
TEST(ScatterCsv, AModelThatDescribesNothingIsNotPrintedAsOne) {
  const std::vector<PsdModel> models{
      SumPsd{{KCorrelationPsd{10e-9, 1e-2, 6, 1, 1e6}, KCorrelationPsd{3e-10, 1e-5, 6, 1, 1e6}}},
      SumPsd{{UniformPsd{20e-9, 100, 1e3}, UniformPsd{1e-9, 1e3, 2e5}}},
      SumPsd{{GaussianPsd{10e-9, 1e-2}, GaussianPsd{10e-9, 1e-4}}}, KCorrelationPsd{11e-9, 0.3, 2.8, 6, 200}};
  for (const PsdModel& model : models) {
    const ScatterExport scatter = export_of(model);
    const AbgFit& fit = scatter.abg[0];
    ASSERT_TRUE(fit.found);
    ASSERT_GT(fit.largest_error, kUsableAbg) << model.index();
    EXPECT_FALSE(fit.describes());
    const std::string text = scatter_csv(scatter);
    EXPECT_NE(text.find("# No ABg model"), std::string::npos);
    EXPECT_NE(text.find("use the table"), std::string::npos);
    EXPECT_EQ(text.find("BSDF = A"), std::string::npos);
    ResultDocument result;
    result.band.shares = BandShares();
    result.band.scatter = ScatterOfRest{scatter.table, {fit}, {}};
    const nlohmann::ordered_json json = to_json(result, {})["split"]["scatter"]["abg"][0];
    EXPECT_EQ(json["describes"], false);
    for (const char* key : {"a_per_sr", "b", "g", "abg_tis"}) EXPECT_TRUE(json[key].is_null()) << key;
    EXPECT_NEAR(json["largest_error"].get<double>(), fit.largest_error, 1e-9);
  }
  EXPECT_TRUE(export_of(KCorrelationPsd{1e-9, 1e-4, 2.5, 1, 1e6}).abg[0].describes());
}

TEST(ScatterCsv, ParametersAreThoseOfThePsd) {
  const KCorrelationPsd rest{11e-9, 0.3, 2.8, 6, 200};
  const std::string text = scatter_csv(export_of(rest));
  const std::string psd = text.substr(text.find("# PSD:"));
  const double a = number_after(psd, "A = "), b = number_after(psd, "B = "), c = number_after(psd, "C = ");
  // Units: A [um^4], B [um], f [1/um].
  for (const double f : {6.0, 30.0, 200.0})
    EXPECT_NEAR(a * std::pow(1 + std::pow(b * f * 1e-6, 2), -0.5 * c) * 1e-24 / RadialPsd(rest)(f), 1, 1e-7);
  // sigma^2 of the band 0..1/lambda of this model is pi A/B^2 (1 - (1 + (B/lambda)^2)^(1 - c/2))/(c/2 - 1).
  const double sigma = number_after(psd, "1/wavelength, sigma = ");
  const double whole =
      std::numbers::pi * a * 1e-12 / (b * b) * (1 - std::pow(1 + std::pow(0.3 / kLambda, 2), -0.4)) / 0.4;
  EXPECT_NEAR(sigma * sigma / whole, 1, 1e-6);
  EXPECT_NEAR(number_after(psd, "the band above has "), 11e-9, 1e-16);
  const std::string power = scatter_csv(export_of(PowerLawPsd{1e-9, {}, 2.5, 10, 1e4}));
  EXPECT_NEAR(number_after(power, "S2(f) = ") / RadialPsd(PowerLawPsd{1e-9, {}, 2.5, 10, 1e4})(100.0) *
                  std::pow(100.0, -2.5),
              1, 1e-7);
}

TEST(ScatterPsdCsv, IsReadAsTheSamePsd) {
  const std::string path =
      (std::filesystem::path(::testing::TempDir()) / "scatter_psd_csv_test.csv").string();
  const std::vector<PsdModel> models{
      KCorrelationPsd{11e-9, 0.3, 2.8, 6, kInf}, GaussianPsd{1e-9, 1e-4},
      SumPsd{{UniformPsd{1e-9, 10, 100}, UniformPsd{1e-9, 1000, 3000}, PowerLawPsd{1e-9, {}, 2.0, 20, 1e4}}},
      TablePsd{{1, 10, 100, 1000}, {1e-18, 1e-19, 3e-22, 1e-24}}};
  for (const PsdModel& model : models) {
    std::ofstream(path) << scatter_psd_csv(model, kLambda);
    const PsdTableResult read = read_psd_table(path, {});
    const RadialPsd expected(model), got(read.psd);
    const double top = std::min(1 / kLambda, expected.f_max());
    EXPECT_NEAR(got.f_max() / top, 1, 1e-9);
    EXPECT_LT(read.psd.frequency.size(), 5000u);
    for (double f = got.f_min() * 1.001; f < 0.999 * top; f *= 1.013)
      if (expected(f) > 1e-280) {
        EXPECT_NEAR(got(f) / expected(f), 1, 1e-3) << model.index() << " " << f;
      }
    EXPECT_NEAR(radial_moment(got, 0) / radial_moment(expected, 0, 0, 1 / kLambda), 1, 1e-3) << model.index();
  }
  std::filesystem::remove(path);
  const std::string none = scatter_psd_csv(UniformPsd{1e-9, 2e6, 3e6}, kLambda);
  EXPECT_TRUE(none.ends_with("frequency_per_m,psd_2d_m4\n"));
}
