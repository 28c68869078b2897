// A measured map of a part with a roughness specification: the fitted terms, the rest of the specification as
// scatter, and the verdict by waves. The tests simulate the part on a much finer grid than its map.
#include "aberfit/method/measured_part.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/measured/write_map.h"
#include "aberfit/report/documents.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/realisation_spread.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

constexpr double kDiameter = 50e-3;
constexpr int kFine = 512, kBin = 4;  // points across of the part, and how many a side make one of the map
const std::string kRoughness =
    R"(, "roughness": {"psd": {"model": "k-correlation", "rms": "25 nm", "B": "12 mm", "exponent": 2.6,
                                "f_min": "20 /m", "f_max": "4 /mm"}})";

const std::string kScene =
    R"({"aberfit": 1, "mirror": {"focal_length": "2.5 m"}, "light": {"wavelength": "632.8 nm"},
        "aperture": {"shape": "circle", "diameter": "50 mm"}, "output": {"pictures": "none"})";

// map: further keys of target.map; roughness: further blocks.
std::string study_of(const std::string& map, const std::string& roughness) {
  return kScene + R"(, "target": {"map": {"file": "part.csv", "origin": "file")" + map +
         R"(}}, "terms": {"zernike": {"n_max": 20}}, "equivalence": {"margin": "25 %"})" + roughness + "}";
}

RadialPsd specification() { return RadialPsd(*parse_study(kScene + kRoughness + "}", "scene.json").psd); }

// A realisation on the fine grid, without the piston and tilt of the mount; NaN outside the aperture.
HeightMap drawn_part(std::uint64_t seed) {
  HeightMap part = random_surface(specification(), kFine, kFine, kDiameter / kFine, {.seed = seed});
  std::vector<Eigen::Index> inside;
  for (Eigen::Index row = 0; row < kFine; ++row)
    for (Eigen::Index column = 0; column < kFine; ++column)
      if (std::hypot(part.x(column), part.y(row)) < kDiameter / 2) inside.push_back(row * kFine + column);
  Eigen::MatrixXd plane(Eigen::Index(inside.size()), 3);
  Eigen::VectorXd height(plane.rows());
  for (Eigen::Index k = 0; k < plane.rows(); ++k) {
    const Eigen::Index at = inside[std::size_t(k)];
    plane.row(k) << 1, part.x(at % kFine), part.y(at / kFine);
    height[k] = part.height.data()[at];
  }
  const Eigen::VectorXd fitted = LeastSquares(plane).solve(height);
  for (Eigen::Index row = 0; row < kFine; ++row)
    for (Eigen::Index column = 0; column < kFine; ++column)
      part.height(row, column) -= fitted[0] + fitted[1] * part.x(column) + fitted[2] * part.y(row);
  return part;
}

// The map that an instrument with large pixels measures.
HeightMap measured(const HeightMap& part) {
  constexpr int kPoints = kFine / kBin;
  HeightMap map;
  map.pitch_x = map.pitch_y = kBin * part.pitch_x;
  map.x0 = part.x0 + 0.5 * (kBin - 1) * part.pitch_x;
  map.y0 = part.y0 + 0.5 * (kBin - 1) * part.pitch_y;
  map.height.resize(kPoints, kPoints);
  for (Eigen::Index row = 0; row < kPoints; ++row)
    for (Eigen::Index column = 0; column < kPoints; ++column) {
      const bool inside = std::hypot(map.x(column), map.y(row)) < kDiameter / 2;
      map.height(row, column) =
          inside ? part.height.block(kBin * row, kBin * column, kBin, kBin).mean() : std::nan("");
    }
  return map;
}

struct Part {
  explicit Part(std::uint64_t seed = 1) : part(drawn_part(seed)) {
    folder.write("part.csv", map_csv(measured(part)));
  }
  Study study(const std::string& text) const { return parse_study(text, folder.write("part.json", text)); }
  ScratchFolder folder;
  HeightMap part;
};

double warned(const Warnings& warnings, const std::string& code) {
  return double(
      std::count_if(warnings.begin(), warnings.end(), [&](const Warning& w) { return w.code == code; }));
}

// The reference has every frequency of the part as a height. The fit has terms and scatter of a map with a
// sixteenth of the points.
TEST(MeasuredPart, HasTheLightOfEveryFrequencyAsAHeightWithinTheSpreadOfItsRest) {
  const Part part;
  const Study study = part.study(study_of("", kRoughness));
  const ResultDocument result = run_map_fit(study, {});
  ASSERT_TRUE(result.band.shares && result.band.shares->rest_rms > 0);
  const double cut = result.band.shares->cut;
  EXPECT_GT(cut, 21 / (2 * EIGEN_PI * kDiameter / 2));

  Eigen::ArrayXd height;
  const DiffractionPupil pupil = diffraction_pupil(part.part, study.aperture, &height);
  const DiffractionProblem problem{pupil, study.mirror.focal_length, study.wavelength};
  SurfaceField terms;
  SurfaceOperator(result.fitted.terms, pupil.sample.x, pupil.sample.y)
      .apply(result.fitted.fit.coefficients, &terms);
  std::vector<FocalDisc> discs;
  std::vector<double> of_part, of_all, of_terms;
  for (std::size_t k = 0; k < result.fitted.targets.size(); ++k) {
    const auto* ee = std::get_if<EncircledEnergyRadius>(&result.fitted.targets[k].statistic);
    if (!ee) continue;
    const double radius = result.fitted.targets[k].value;
    const Eigen::ArrayXd at = Eigen::ArrayXd::Constant(1, radius);
    discs.push_back({radius, ee->dz});
    of_part.push_back(ee->fraction + result.judgement.metrics[k].share_difference);
    of_all.push_back(diffraction_encircled_energy(problem, height, ee->dz, at)[0]);
    of_terms.push_back(diffraction_encircled_energy(problem, terms.height, ee->dz, at)[0]);
  }
  ASSERT_GT(discs.size(), 20u);
  const RadialPsd psd = specification();
  const GeneralisedHarveyShack mean(psd, study.mirror, study.aperture, study.wavelength);
  const Eigen::ArrayXd spread =
      RealisationSpread({psd, study.mirror, study.aperture, study.wavelength, mean}, discs).light(cut);
  double worst = 0, without = 0;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    // The edge of 512 grid points and the grids of the verdict have an error of 1e-4 of the energy.
    const double allowed = spread[Eigen::Index(k)] + 1e-4;
    worst = std::max(worst, std::abs(of_part[k] - of_all[k]) / allowed);
    without = std::max(without, std::abs(of_terms[k] - of_all[k]) / allowed);
  }
  std::cout << "cut " << cut << " /m, " << discs.size() << " discs, spread up to " << spread.maxCoeff()
            << ": part " << worst << " standard deviations from its full resolution, terms alone " << without
            << '\n';
  EXPECT_LT(worst, 4);     // standard deviations
  EXPECT_GT(without, 10);  // the rest is not nothing
}

// Terms and scatter add up to the whole: on average over realisations, the residual of the terms is what
// scatters. We use points of the fine surface, because pixels average a tenth of it away.
TEST(MeasuredPart, CountsNothingTwice) {
  constexpr int kDraws = 8;
  // A residual has some thousand independent points, so its mean square over 8 realisations is good to 2 %.
  // 231 of 12,900 points are fitted by the terms.
  constexpr double kAllowed = 0.05;
  const RadialPsd psd = specification();
  TermSet terms;
  terms.radius = kDiameter / 2;
  terms.zernike = zernike_modes(2, 20);
  double left = 0;
  for (int seed = 1; seed <= kDraws; ++seed) {
    const HeightMap part = drawn_part(std::uint64_t(seed));
    HeightMap map = measured(part);
    for (Eigen::Index row = 0; row < map.rows(); ++row)
      for (Eigen::Index column = 0; column < map.columns(); ++column)
        if (std::isfinite(map.height(row, column)))
          map.height(row, column) = part.height(kBin * row, kBin * column);
    map.x0 = part.x0, map.y0 = part.y0;
    left += std::pow(fit_map(map, terms).rms_residual, 2) / kDraws;
  }
  const auto above = [&](double f) { return psd_moments(psd.band(f, psd.f_max())).height_variance; };
  EXPECT_NEAR(above(terms_end(psd, 20, kDiameter / 2)) / left, 1, kAllowed);
  EXPECT_GT(above(21 / (EIGEN_PI * kDiameter)) / left, 1 + kAllowed);  // would count twice
  std::cout << "what scatters over what the terms leave: " << above(terms_end(psd, 20, kDiameter / 2)) / left
            << ", with a cut at (n + 1)/(2 pi R) " << above(21 / (EIGEN_PI * kDiameter)) / left << '\n';
}

TEST(MeasuredPart, AddsHeightsInSquares) {
  const Part part;
  const Study study = part.study(study_of("", kRoughness));
  const ResultDocument result = run_map_fit(study, {});
  const BandShares& shares = *result.band.shares;
  const double whole = psd_moments(specification()).rms_height();
  EXPECT_NEAR(std::hypot(shares.low_rms, shares.rest_rms), whole, 1e-9 * whole);
  const ordered_json split = to_json(result, {})["split"];
  const double terms = split["terms"]["rms_height_m"], rest = split["scatter"]["rms_height_m"];
  EXPECT_NEAR(split["sum"]["rms_height_m"].get<double>(), std::hypot(terms, rest), 1e-15);
  for (const EquivalenceMetric& metric : result.judgement.metrics) {
    if (metric.name != "rms_height_m") continue;
    EXPECT_NEAR(metric.model, std::hypot(terms, rest), 1e-6 * whole);
  }
  // The map is its terms plus the residual; the whole part is the terms plus all that they leave of it.
  const double residual = split["map_residual"]["rms_height_m"];
  EXPECT_NEAR(std::hypot(terms, residual), result.map.fit->rms_map, 2e-3 * whole);
  // The map has few independent points, so its residual is uncertain by some percent.
  EXPECT_NEAR(residual / split["map_residual"]["specified_rms_height_m"].get<double>(), 1, 0.1);
  EXPECT_EQ(warned(result.warnings, "rest-not-as-specified"), 0);
}

TEST(MeasuredPart, IsJudgedAndTheExitCodeSaysSo) {
  const Part part;
  part.folder.write("same.json", study_of("", kRoughness));
  part.folder.write("twice.json", study_of(R"(, "scale": 2)", kRoughness));
  ASSERT_EQ(run_program(part.folder, "fit same.json --json -o same"), 0)
      << read_file(part.folder.file("stderr.txt")) << read_file(part.folder.file("same/summary.txt"));
  const ordered_json same = ordered_json::parse(read_file(part.folder.file("stdout.txt")));
  EXPECT_EQ(same, ordered_json::parse(read_file(part.folder.file("same/result.json"))));
  EXPECT_EQ(same["equivalence"]["verdict"], "equivalent");
  EXPECT_EQ(same["equivalence"]["light"]["decides"], true);
  EXPECT_EQ(same["scene"]["model"], "waves");
  EXPECT_GE(same["equivalence"]["perfect_mirror"]["mismatch_tolerances"].get<double>(), 1);
  EXPECT_TRUE(read_file(part.folder.file("same/summary.txt")).starts_with("EQUIVALENT by wave optics"));
  EXPECT_GT(std::filesystem::file_size(part.folder.file("same/scatter.csv")), 1000u);

  ASSERT_EQ(run_program(part.folder, "fit twice.json --json -o twice"), 1);
  const ordered_json twice = ordered_json::parse(read_file(part.folder.file("stdout.txt")));
  EXPECT_EQ(twice["equivalence"]["verdict"], "different");
  const std::string summary = read_file(part.folder.file("twice/summary.txt"));
  EXPECT_TRUE(summary.starts_with("DIFFERENT from the mean, ")) << summary;
  // A surface of twice the height is no mirror of this specification; it is outside their spread.
  EXPECT_NE(summary.substr(0, summary.find("Worst: ")).find("standard deviations among mirrors"),
            std::string::npos)
      << summary;
  double most = 0;
  for (const auto& metric : twice["equivalence"]["metrics"]) {
    if (!metric.contains("spread")) continue;
    most = std::max(most, std::abs(metric["difference_in_spreads"].get<double>()));
    EXPECT_NEAR(metric["difference_in_spreads"].get<double>() * metric["spread"].get<double>(),
                metric["difference"].get<double>(), 1e-12);
  }
  EXPECT_GT(most, 3);
  EXPECT_NE(summary.find("Worst: "), std::string::npos);
  // The residual of the terms is also twice its specification.
  EXPECT_NE(summary.find("[rest-not-as-specified]"), std::string::npos);
  // The scatter comes from the specification in both cases.
  EXPECT_EQ(twice["split"]["scatter"], same["split"]["scatter"]);
  EXPECT_EQ(read_file(part.folder.file("twice/scatter.csv")),
            read_file(part.folder.file("same/scatter.csv")));
}

TEST(MeasuredPart, IsCheckedWithTheSameCut) {
  const Part part;
  const Study study = part.study(study_of("", kRoughness));
  const ordered_json checked = to_json(run_map_check(study, {}), {}),
                     fitted = to_json(run_map_fit(study, {}), {});
  for (const char* key : {"cut_per_m", "reason", "specified_terms", "spread_in_tolerances"})
    EXPECT_EQ(checked["split"][key], fitted["split"][key]) << key;
  for (const char* key : {"rms_height_m", "rms_slope_per_axis", "rest_tis"})
    EXPECT_EQ(checked["split"]["scatter"][key], fitted["split"]["scatter"][key]) << key;
  EXPECT_NE(text_of(page_of(run_map_check(study, {}))).find("A measured part"), std::string::npos);
}

TEST(MeasuredPart, HasNoRestWhereItsSpecificationEndsBelowTheTerms) {
  const Part part;
  const std::string low =
      R"(, "roughness": {"psd": {"model": "uniform", "rms": "25 nm", "f_min": "20 /m", "f_max": "100 /m"}})";
  const ResultDocument result = run_map_fit(part.study(study_of("", low)), {});
  ASSERT_TRUE(result.band.shares.has_value());
  EXPECT_EQ(result.band.shares->rest_rms, 0);
  EXPECT_FALSE(result.band.scatter.has_value());
  EXPECT_FALSE(result.judgement.metrics.empty());
  EXPECT_NE(result.band.shares->reason.find("nothing is left to scatter"), std::string::npos)
      << result.band.shares->reason;
  EXPECT_FALSE(to_json(result, {})["split"].contains("use"));
}

TEST(MeasuredPart, TakesANamedCutAndSaysWhatItLeaves) {
  const Part part;
  const std::string text = study_of("", kRoughness);
  const auto with_band = [&](const std::string& terms) {
    std::string changed = text;
    changed.replace(changed.find(R"({"zernike": {"n_max": 20}})"), 26, terms);
    return part.study(changed);
  };
  const ordered_json high =
      to_json(run_map_check(with_band(R"({"zernike": {"n_max": 20}, "band": "250 /m"})"), {}), {});
  EXPECT_EQ(high["split"]["cut_per_m"], 250.0);
  EXPECT_EQ(high["terms"]["count"], 228);
  // Without a given order, the terms end at the cut.
  const ResultDocument own = run_map_fit(with_band(R"({"band": "80 /m"})"), {});
  const int order = own.fitted.terms.zernike.back().n;
  EXPECT_LE(terms_end(specification(), order, kDiameter / 2), 80);
  EXPECT_GT(terms_end(specification(), order + 1, kDiameter / 2), 80);
  EXPECT_EQ(own.band.shares->cut, 80.0);
  EXPECT_EQ(warned(own.warnings, "cut-off-the-terms"), 0);
  const ResultDocument gap = run_map_fit(with_band(R"({"zernike": {"n_max": 4}, "band": "80 /m"})"), {});
  EXPECT_EQ(warned(gap.warnings, "cut-off-the-terms"), 1);
}

TEST(MeasuredPart, NeedsATheoryOfLight) {
  const Part part;
  std::string text = study_of("", kRoughness);
  text.replace(text.find(R"("target": {)"), 11, R"("target": {"theory": "geometric", )");
  part.folder.write("rays.json", text);
  EXPECT_EQ(run_program(part.folder, "fit rays.json"), 2);
  EXPECT_NE(read_file(part.folder.file("stderr.txt")).find("/target/theory"), std::string::npos);
}

TEST(MeasuredPart, IsNotJudgedWithoutASpecification) {
  const Part part;
  part.folder.write("map.json", study_of("", ""));
  ASSERT_EQ(run_program(part.folder, "fit map.json --json -o out"), 0);
  const ordered_json result = ordered_json::parse(read_file(part.folder.file("stdout.txt")));
  EXPECT_TRUE(result["scene"].is_null());
  EXPECT_FALSE(result.contains("split"));
  EXPECT_EQ(result["equivalence"], ordered_json::parse(R"({"verdict": "undecided", "metrics": []})"));
  EXPECT_FALSE(std::filesystem::exists(part.folder.file("out/scatter.csv")));
  EXPECT_TRUE(read_file(part.folder.file("out/summary.txt")).starts_with("NOT JUDGED"));
}

}  // namespace
}  // namespace aberfit
