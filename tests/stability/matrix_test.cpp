// Checks the matrix of random scenes itself: its scenes are readable and have what they claim, real failures
// are told from others, and second opinions tell a right surface from a wrong one. A few quick rows are run,
// too.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/roughness/psd.h"
#include "aberfit/study/read_study.h"
#include "matrix_report.h"
#include "matrix_row.h"
#include "random_scenes.h"
#include "short_form.h"
#include "study/scratch_folder.h"
#include "sweep/independent_surface.h"
#include "sweep/independent_verdict.h"
#include "sweep/independent_width.h"

namespace aberfit {
namespace {

using nlohmann::json;

constexpr int kRows = 300;

Study study_of(const RandomScene& scene, const test::ScratchFolder& folder) {
  if (!scene.table.empty()) folder.write(kRandomTable, scene.table);
  return parse_study(scene.study, folder.file("study.json"));
}

TEST(RandomScenes, AreReadableAndHaveTheHeightOfTheirClass) {
  const test::ScratchFolder folder;
  const std::map<std::string, std::pair<double, double>> limits = {
      {"below 0.1", {0.02, 0.1}}, {"0.1 to 1", {0.1, 1}}, {"1 to 5", {1, 5}}, {"from 5", {5, 50}}};
  for (int k = 0; k < kRows; ++k) {
    const RandomScene scene = random_scene(1, k);
    SCOPED_TRACE(scene.name);
    const Study study = study_of(scene, folder);
    const auto [least, most] = limits.at(scene.classes.at("g"));
    const double g = 4 * EIGEN_PI * psd_moments(RadialPsd(*study.psd)).rms_height() / study.wavelength;
    EXPECT_GT(g, least / 1.05);  // trapezoids between the points of a table
    EXPECT_LT(g, most * 1.05);
  }
}

TEST(RandomScenes, ReachTheEndsOfTheirRangesAndEveryClass) {
  const test::ScratchFolder folder;
  std::map<std::string, std::set<std::string>> seen;
  double smallest = HUGE_VAL, largest = 0, fastest = HUGE_VAL, slowest = 0, shortest = HUGE_VAL, longest = 0;
  int open = 0;
  for (int k = 0; k < kRows; ++k) {
    const RandomScene scene = random_scene(1, k);
    const Study study = study_of(scene, folder);
    for (const auto& [of, value] : scene.classes) seen[of].insert(value);
    open += scene.all_open;
    shortest = std::min(shortest, double(study.wavelength));
    longest = std::max(longest, double(study.wavelength));
    if (scene.classes.at("aperture") != "circle") continue;
    const double across = 2 * aperture_radius(study.aperture), f_number = study.mirror.focal_length / across;
    smallest = std::min(smallest, across);
    largest = std::max(largest, across);
    fastest = std::min(fastest, f_number);
    slowest = std::max(slowest, f_number);
  }
  EXPECT_EQ(seen["kind"].size(), 9u);
  EXPECT_EQ(seen["psd"].size(), 6u);
  EXPECT_EQ(seen["aperture"].size(), 4u);
  for (const char* of : {"cycles", "light", "f-number"}) EXPECT_EQ(seen[of].size(), 3u) << of;
  EXPECT_EQ(seen["g"].size(), 4u);
  EXPECT_GE(open, kRows * 3 / 5);
  // A tenth of a range, in its logarithm, lies beyond these values.
  EXPECT_LT(smallest, 0.011);
  EXPECT_GT(largest, 4.7);
  EXPECT_LT(fastest, 1.45);
  EXPECT_GT(slowest, 27);
  EXPECT_LT(shortest, 27e-9);
  EXPECT_GT(longest, 5.4e-6);
}

TEST(RandomScenes, AreOthersBySeedAndTheSameAgain) {
  EXPECT_EQ(random_scene(1, 7).study, random_scene(1, 7).study);
  EXPECT_NE(random_scene(1, 7).study, random_scene(2, 7).study);
}

json equivalent_row() {
  return {{"row", 0},
          {"name", "a scene"},
          {"classes", {{"kind", "open"}}},
          {"open", true},
          {"outcome", "equivalent"},
          {"fit_s", 15.0},
          {"check_s", 0.5},
          {"carried", 1.0},
          {"rms_ratio", 1.01},
          {"slope_ratio", 0.98},
          {"remedy", false},
          {"second", {{"of", "waves"}, {"margins", 0.3}}}};
}

// Each change alone turns a sound row into a failure.
TEST(MatrixRows, AreFailuresForEveryReasonThatCounts) {
  EXPECT_EQ(failure_of(equivalent_row()), "");
  for (const char* end : {"crash", "hang", "time-out"}) {
    json row = equivalent_row();
    row["outcome"] = end;
    EXPECT_EQ(failure_of(row), end);
  }
  json refused = equivalent_row();
  refused["outcome"] = "refused";
  EXPECT_EQ(failure_of(refused), "refused without a remedy");
  refused["remedy"] = true;
  EXPECT_EQ(failure_of(refused), "");
  json contradicted = equivalent_row();
  contradicted["second"]["margins"] = 1.01;
  EXPECT_EQ(failure_of(contradicted), "contradicted by waves");
  contradicted["second"]["margins"] = nullptr;  // not a number
  EXPECT_EQ(failure_of(contradicted), "contradicted by waves");
  contradicted["outcome"] = "different";  // nobody was told to rely on it
  EXPECT_EQ(failure_of(contradicted), "");
  json wrong_targets = equivalent_row();
  wrong_targets["second_of_targets"] = {{"of", "waves"}, {"margins", 0.09}};
  EXPECT_EQ(failure_of(wrong_targets), "");
  wrong_targets["second_of_targets"]["margins"] = 0.11;
  EXPECT_EQ(failure_of(wrong_targets), "wrong targets");
  wrong_targets["outcome"] = "different";  // perhaps because of them
  EXPECT_EQ(failure_of(wrong_targets), "wrong targets");
  for (const double ratio : {0.4, 2.1}) {
    json absurd = equivalent_row();
    absurd["rms_ratio"] = ratio;
    EXPECT_EQ(failure_of(absurd), "absurd surface");
    absurd["carried"] = 0.5;  // few terms carry only their part
    EXPECT_EQ(failure_of(absurd), "");
  }
}

TEST(MatrixRows, AreCountedByClassAndHeldToThePromises) {
  std::vector<json> rows(100, equivalent_row());
  const MatrixReport kept = report_on(rows);
  EXPECT_TRUE(kept.sound && kept.promised);
  EXPECT_NE(kept.text.find("open"), std::string::npos);
  for (int k = 0; k < 3; ++k) rows[std::size_t(k)]["outcome"] = "undecided";
  for (int k = 0; k < 3; ++k) rows[std::size_t(k)]["remedy"] = true;
  const MatrixReport few = report_on(rows);
  EXPECT_TRUE(few.sound);
  EXPECT_FALSE(few.promised);  // 97 %, of open scenes
  EXPECT_NE(few.text.find("BROKEN97 of 100 scenes that leave everything open"), std::string::npos)
      << few.text;
  std::vector<json> slow(100, equivalent_row());
  slow[0]["outcome"] = "crash";
  EXPECT_FALSE(report_on(slow).sound);
}

// Compares with low-order polynomials written out, a plane wave and a power, over a sphere.
TEST(IndependentSurface, HasHeightAndSlopesOfItsTerms) {
  TermSet terms{0.1, {{2, 0}, {3, -1}, {4, 4}}, {{30, -20}}, {6}};
  Eigen::VectorXd c(6);
  c << 1e-7, -2e-7, 3e-7, 5e-8, 4e-8, 2e-7;
  Mirror mirror{.focal_length = 1, .conic = 0};
  const IndependentSurface surface(mirror, terms, c);
  const auto written_out = [&](double x, double y) {
    const double u = x / 0.1, v = y / 0.1, r2 = u * u + v * v, turn = 2 * EIGEN_PI * (30 * x - 20 * y);
    return c[0] * std::sqrt(3.0) * (2 * r2 - 1) + c[1] * std::sqrt(8.0) * (3 * r2 - 2) * v +
           c[2] * std::sqrt(10.0) * (u * u * u * u - 6 * u * u * v * v + v * v * v * v) +
           c[3] * std::cos(turn) + c[4] * std::sin(turn) + c[5] * r2 * r2 * r2 +
           (2 - std::sqrt(4 - x * x - y * y)) - (x * x + y * y) / 4;
  };
  constexpr double kRounding = 1e-15;  // of the sag of the sphere, written out
  for (const auto& [x, y] : {std::pair{0.05, 0.02}, {-0.07, 0.06}, {0.0, 0.0999}}) {
    EXPECT_NEAR(surface.height(x, y), written_out(x, y), kRounding);
    const auto [p, q] = surface.slopes(x, y);
    constexpr double kStep = 1e-5;  // central differences: (2 pi 36 kStep)^2/6 of the wave's slopes
    EXPECT_NEAR(p, (written_out(x + kStep, y) - written_out(x - kStep, y)) / (2 * kStep), 2e-10);
    EXPECT_NEAR(q, (written_out(x, y + kStep) - written_out(x, y - kStep)) / (2 * kStep), 2e-10);
  }
}

// A study of a mirror whose encircled energies are known in closed form and given as targets.
Study known_study(const std::map<std::string, double>& radii) {
  json text{{"aberfit", 1},
            {"mirror", {{"focal_length", 2}}},
            {"aperture", {{"shape", "circle"}, {"diameter", 0.1}}},
            {"light", {{"wavelength", 1e-6}}},
            {"terms", {{"zernike", {{"n_max", 2}}}}},
            {"fit", {{"prior", "zero-mean"}}}};
  for (const auto& [key, radius] : radii) text["target"]["statistics"][key]["value"] = radius;
  return parse_study(text.dump(), "study.json");
}
constexpr double kDefocus = 1e-6;  // [m], RMS

Eigen::VectorXd defocus(double height) {
  Eigen::VectorXd c = Eigen::VectorXd::Zero(3);  // (2, -2), (2, 0), (2, 2)
  c[1] = height;
  return c;
}

// Defocus alone gives a uniform disc, of radius 2 f times the slope at the rim, 4 sqrt(3) a/R.
TEST(SecondOpinions, TellARightSurfaceFromAWrongOneByRays) {
  const double disc = 2 * 2 * 4 * std::sqrt(3.0) * kDefocus / 0.05;
  const Study study = known_study({{"ee50", std::sqrt(0.5) * disc}, {"ee90", std::sqrt(0.9) * disc}});
  const TermSet terms{0.05, zernike_modes(2, 2), {}, {}};
  const SecondOpinion right = SecondOpinions(study).of_rays(terms, defocus(kDefocus), {});
  EXPECT_EQ(right.obstacle, "");
  EXPECT_LE(right.worst, 0.1) << right.statistic;
  // The disc is smaller by 1 %, so 0.9 (1.01^2 - 1) more energy is inside. A margin of 1 % of a given radius
  // is judged as for a Gaussian spot: 2 (1 - p) ln(1/(1 - p)) of it. We subtract three standard errors of the
  // rays, 0.3.
  const double margin = 0.01 * 0.2 * std::log(10.0);
  EXPECT_NEAR(SecondOpinions(study).of_rays(terms, defocus(kDefocus / 1.01), {}).worst, 0.9 * 0.0201 / margin,
              0.5);
}

// The Airy pattern has E = 1 - J0^2 - J1^2 of pi D r/(lambda f); the first dark ring, 1.2197 lambda f/D,
// holds 0.8378.
TEST(SecondOpinions, TellARightSurfaceFromAWrongOneByWaves) {
  const double airy = 1e-6 * 2 / 0.1;
  const auto share = [](double x) {
    return 1 - std::pow(std::cyl_bessel_j(0, EIGEN_PI * x), 2) -
           std::pow(std::cyl_bessel_j(1, EIGEN_PI * x), 2);
  };
  double low = 0, high = 1;
  while (high - low > 1e-12) (share(0.5 * (low + high)) < 0.5 ? low : high) = 0.5 * (low + high);
  ASSERT_NEAR(share(1.219669891), 0.8378, 1e-4);
  const Study study = known_study({{"ee50", low * airy}, {"ee83.7785", 1.219669891 * airy}});
  const TermSet terms{0.05, zernike_modes(2, 2), {}, {}};
  EXPECT_LE(SecondOpinions(study).of_waves(terms, defocus(0), {}, {}).worst, 0.1);
  // The Strehl ratio exp(-(4 pi a/lambda)^2) is 0.937 at 20 nm; ee50 loses as much of its half, 0.03 in all.
  EXPECT_GT(SecondOpinions(study).of_waves(terms, defocus(20e-9), {}, {}).worst, 5);
}

// The curve has two Gaussians, the higher one off the middle; bisection gives its half crossings.
TEST(IndependentWidth, IsOfTheHighestPeakBetweenItsNearestHalves) {
  const auto gaussian = [](double z) { return std::exp(-0.5 * z * z); };
  const auto one = independent_width(gaussian, 2.0);
  ASSERT_TRUE(one);
  EXPECT_NEAR(one->fwhm, 2 * std::sqrt(2 * std::log(2)), 5e-4);
  // Each half crossing is wrong by 1/slope times the error of the curve and half of the peak's.
  EXPECT_NEAR(one->per_light, 3 / (0.5 * std::sqrt(2 * std::log(2))), 0.3 * one->per_light);
  const auto two = [&](double z) { return 0.3 * gaussian(4 * (z + 1)) + gaussian(1.5 * (z - 0.7)); };
  double peak = 0;
  for (double z = 0; z < 2; z += 1e-4) peak = std::max(peak, two(z));
  const auto half_from = [&](double inside, double outside) {
    while (std::abs(outside - inside) > 1e-9)
      (two(0.5 * (inside + outside)) > 0.5 * peak ? inside : outside) = 0.5 * (inside + outside);
    return inside;
  };
  const auto skew = independent_width(two, 1.4);
  ASSERT_TRUE(skew);
  EXPECT_NEAR(skew->fwhm, half_from(0.7, 3) - half_from(0.7, -0.5), 1e-3);
  EXPECT_FALSE(independent_width([](double z) { return 1 / (1 + 0.1 * z * z); }, 1.0));  // no half in sight
}

// Without terms, all roughness acts by its mean, which is generalised Harvey-Shack by other means. One
// spectrum begins at zero frequency, one is a thousand cycles wide, and one folds back into the 256 grid
// points.
TEST_WITH_SHORT_FORM(SecondOpinions, AgreeWithTheTheoryWhereAllOfTheRoughnessScatters) {
  const json steep{{"model", "gaussian"}, {"rms", 40e-9}, {"correlation_length", 5e-3}},
      wide{{"model", "k-correlation"}, {"rms", 40e-9}, {"B", 0.02},
           {"exponent", 3.2},          {"f_min", 10},  {"f_max", 1e4}},
      folding{{"model", "k-correlation"}, {"rms", 50e-9}, {"B", 0.02},
              {"exponent", 2.4},          {"f_min", 10},  {"f_max", 2.6e3}};
  for (const json& psd : aberfit::test::all_or_few(whole, std::vector<json>{steep, wide, folding}, {2})) {
    const json text{
        {"aberfit", 1},
        {"mirror", {{"focal_length", 1}}},
        {"aperture", {{"shape", "circle"}, {"diameter", 0.1}}},
        {"light", {{"wavelength", 1e-6}}},
        {"roughness", {{"psd", psd}}},
        {"target",
         {{"statistics",
           {{"ee50", json::object()}, {"ee80", json::object()}, {"ring_fwhm", json::object()}}}}}};
    const Study study = parse_study(text.dump(), "study.json");
    const TermSet none{0.05, {}, {}, {}};
    const int rings = psd == wide;  // seconds each
    const SecondOpinions opinions(study);
    const SecondOpinion right = opinions.of_targets({.most_rings = rings}),
                        wrong = opinions.of_waves(none, {}, 150.0, {.most_rings = 0});
    EXPECT_EQ(right.obstacle, "");
    EXPECT_LE(right.worst, 0.1) << psd << right.statistic;
    EXPECT_EQ(right.rings, rings);
    EXPECT_GT(wrong.worst, 2) << psd;  // the lower part of the band left out
  }
}

// Encircled energy of a perfect mirror: N(u) = int |U|^2 v dv/2, U = 2 int J0(v t) exp(-i u t^2/2) t dt (Born
// and Wolf 8.8, u by the square of the numerical aperture).
double light_in_circle(double u, double widest) {
  constexpr int kNodes = 120;
  double light = 0;
  for (int i = 0; i < kNodes; ++i) {
    const double v = widest * (i + 0.5) / kNodes;
    std::complex<double> field = 0;
    for (int k = 0; k < kNodes; ++k) {
      const double t = (k + 0.5) / kNodes;
      field += 2 * std::cyl_bessel_j(0, v * t) * std::polar(t / kNodes, -0.5 * u * t * t);
    }
    light += 0.5 * std::norm(field) * v * widest / kNodes;
  }
  return light;
}

TEST(SecondOpinions, TellARightRingFromAWrongOne) {
  const auto root = [](const auto& below, double low, double high) {
    while (high - low > 1e-4) (below(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return low;
  };
  const double v50 = root([](double v) { return light_in_circle(0, v) < 0.5; }, 0, 3),
               v90 = root([](double v) { return light_in_circle(0, v) < 0.9; }, 3, 8),
               half = root([&](double u) { return light_in_circle(u, v90) > 0.45; }, 0, 30);
  const double k = 2 * EIGEN_PI / 1e-6, sine = 0.05 / 2;
  const double ee50 = v50 / (k * sine), fwhm = 2 * half / (k * sine * sine);
  const TermSet terms{0.05, zernike_modes(2, 2), {}, {}};
  const auto worst = [&](double width) {
    return SecondOpinions(known_study({{"ee50", ee50}, {"ring_fwhm", width}}))
        .of_waves(terms, defocus(0), {}, {})
        .worst;
  };
  EXPECT_LE(worst(fwhm), 0.1);
  EXPECT_NEAR(worst(1.03 * fwhm), 3 / 1.03, 0.3);  // in margins of 1 %, less its own error
}

TEST(SecondOpinions, SayWhereTheyWouldCostTooMuch) {
  const Study study = parse_study(random_scene(1, 3).study, "study.json");
  TermSet terms{aperture_radius(study.aperture), zernike_modes(2, 60), {}, {}};
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(terms.size());
  EXPECT_NE(SecondOpinions(study).of_rays(terms, none, {.seconds = 1e-3}).obstacle, "");
  EXPECT_NE(SecondOpinions(study).of_waves(terms, none, {}, {.largest_grid = 128}).obstacle, "");
}

// Two scenes name their Zernikes and one names its planes. The program runs each, for one or two seconds.
// Times are not tested, because other tests run beside them.
class RandomMatrixSmoke : public testing::TestWithParam<int> {};
TEST_P(RandomMatrixSmoke, IsEquivalentAndNoFailure) {
  const test::ScratchFolder folder;
  const json row = run_row(1, GetParam(), folder.file(""));
  EXPECT_EQ(failure_of(row), "") << row.dump(1);
  EXPECT_EQ(row["outcome"], "equivalent") << row.dump(1);
  EXPECT_LE(row["second"].value("margins", HUGE_VAL), 1) << row.dump(1);
}
INSTANTIATE_TEST_SUITE_P(Seeded, RandomMatrixSmoke, testing::Values(146));

}  // namespace
}  // namespace aberfit
