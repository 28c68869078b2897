// Tests solutions against closed laws of PHYSICS 5, and against the targets of the same study.
#include "aberfit/specify/solve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using std::numbers::pi;

constexpr double kArcsec = pi / 648000;
// Tolerance of a solution; the largest deviation is the paraxial error of the closed laws, 1.3e-7.
constexpr double kSolved = 1e-6;

// At f/500 the paraxial error of the laws is 1/(32 N^2) = 1.3e-7.
std::string slow_mirror(const std::string& psd, const std::string& target, const std::string& solve) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "100 m"}, "light": {"wavelength": "500 nm"},
    "aperture": {"shape": "circle", "diameter": "0.2 m"}, "roughness": {"psd": )" +
         psd + R"(}, "target": {)" + target + R"(}, "solve": )" + solve + "}";
}
const std::string kUniform = R"({"model": "uniform", "rms": "50 nm", "f_min": "20 /m", "f_max": "60 /m"})";
const std::string kGeometric = R"("theory": "geometric")";

Specification solved(const std::string& text) { return run_solve(parse_study(text, "study.json"), {}); }

// RMS height of a uniform PSD with per-axis slope s: s^2 = (2 pi sigma)^2 (f_min^2 + f_max^2)/4.
double rms_of_slope(double slope, double f_min, double f_max) {
  return slope / (pi * std::hypot(f_min, f_max));
}
// Slope for an EE diameter on the sky: 4 s sqrt(-2 ln(1 - p)).
double slope_of_diameter(double angle, double share) {
  return angle / (4 * std::sqrt(-2 * std::log(1 - share)));
}

// The statistic as a target of the study with the solved values.
double target_of(const std::string& text, const SolvePoint& point, const std::string& key) {
  nlohmann::ordered_json study = nlohmann::ordered_json::parse(text);
  std::size_t k = 0;
  for (const std::string pointer : study["solve"]["for"])
    study[nlohmann::ordered_json::json_pointer(pointer)] = point.at[k++];
  study.erase("solve");
  study["target"]["statistics"][key] = nlohmann::ordered_json::object();
  const Study changed = parse_study(study.dump(), "study.json");
  return make_targets(changed, lay_groundwork(changed), 1).fitted.front().value;
}

TEST(Solve, LargestRmsIsThatOfTheClosedLaw) {
  const Specification spec =
      solved(slow_mirror(kUniform, kGeometric,
                         R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter": "<= 6 arcsec"}})"));
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  EXPECT_EQ(spec.theory, Theory::kGeometric);
  ASSERT_EQ(spec.solutions.size(), 1u);
  const SolvePoint& solution = spec.solutions.front();
  EXPECT_TRUE(solution.holds_below);
  EXPECT_NEAR(solution.at[0] / rms_of_slope(slope_of_diameter(6 * kArcsec, 0.8), 20, 60), 1, kSolved);
  EXPECT_NEAR(solution.budgets[0].margin, 0, 1e-9);
  EXPECT_NEAR(solution.budgets[0].sensitivity[0], 1, kSolved) << "a blur is proportional to the height";
  EXPECT_LE(solution.bracket[0], solution.at[0]);
  EXPECT_GE(solution.bracket[1], solution.at[0]);
}

TEST(Solve, OfSeveralBudgetsTheStrictestBindsAndEachHasItsOwnAnswer) {
  const Specification spec = solved(slow_mirror(
      kUniform, kGeometric,
      R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter": "<= 6 arcsec", "scatter_rms": "<= 7 urad",
          "rms_height": ">= 10 nm"}})"));
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  const double by_light = rms_of_slope(slope_of_diameter(6 * kArcsec, 0.8), 20, 60);
  const double by_angle = rms_of_slope(7e-6 / std::sqrt(8.0), 20, 60);  // 2 sqrt2 s
  ASSERT_LT(by_angle, by_light);
  // The start of 50 nm violates both upper limits. The solution nearest to it comes first.
  ASSERT_EQ(spec.solutions.size(), 2u);
  EXPECT_NEAR(spec.solutions[0].at[0] / by_angle, 1, kSolved);
  EXPECT_EQ(spec.solutions[0].binding, 1u);
  EXPECT_NEAR(spec.solutions[0].budgets[0].margin, 1 - by_angle / by_light, kSolved);
  EXPECT_NEAR(spec.solutions[1].at[0] / 10e-9, 1, 1e-4) << "but for what a mean over the aperture takes off";
  EXPECT_EQ(spec.solutions[1].binding, 2u);
  EXPECT_FALSE(spec.solutions[1].holds_below);
  ASSERT_EQ(spec.alone.size(), 3u);
  EXPECT_NEAR(spec.alone[0].at(0) / by_light, 1, kSolved);
}

// A f^-b from 0.1 to 10 cycles/m has slope variance A (2 pi)^3 2 sinh(u ln 10)/u, u = 4 - b, even in u.
TEST(Solve, AllSolutionsAreFoundWhereThereAreTwo) {
  const std::string text = slow_mirror(
      R"({"model": "power-law", "amplitude": 1e-18, "exponent": 3.6, "f_min": "0.1 /m", "f_max": "10 /m"})",
      kGeometric, R"({"for": ["/roughness/psd/exponent"], "so_that": {"scatter_rms": "<= 1 urad"}})");
  const auto scatter = [](double exponent) {
    const double u = 4 - exponent;
    return 2 * std::sqrt(1e-18 * std::pow(2 * pi, 3) * 2 * std::sinh(u * std::log(10)) / u);
  };
  nlohmann::ordered_json study = nlohmann::ordered_json::parse(text);
  study["solve"]["so_that"]["scatter_rms"] = fmt::format("<= {:.17g} rad", scatter(3.1));
  const Specification spec = solved(study.dump());
  ASSERT_EQ(spec.solutions.size(), 2u);
  EXPECT_NEAR(spec.solutions[0].at[0], 3.1, kSolved);
  EXPECT_NEAR(spec.solutions[1].at[0], 4.9, kSolved);
  EXPECT_FALSE(spec.solutions[0].holds_below);
  EXPECT_TRUE(spec.solutions[1].holds_below);
  // Just above the minimum at b = 4 both solutions are between two steps of the search, 3.6 and 5.4.
  study["solve"]["so_that"]["scatter_rms"] = fmt::format("<= {:.17g} rad", scatter(3.9));
  const Specification close = solved(study.dump());
  ASSERT_EQ(close.solutions.size(), 2u);
  EXPECT_NEAR(close.solutions[0].at[0] + close.solutions[1].at[0], 8, kSolved);
}

TEST(Solve, InLightTheTargetsOfTheSolutionAreTheBudget) {
  const std::string text =
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {},
      "roughness": {"psd": {"model": "uniform", "rms": "60 nm", "f_min": "2.5 /m", "f_max": "20 /m"}},
      "solve": {"for": ["/roughness/psd/rms"], "so_that": {"ee80_radius": "<= 30 um"}}})";
  const Specification spec = solved(text);
  ASSERT_EQ(spec.status, SolveStatus::kSolved) << spec.reason;
  EXPECT_EQ(spec.theory, Theory::kGhs);
  EXPECT_NEAR(target_of(text, spec.solutions[0], "ee80") / 30e-6, 1, kSolved);
  EXPECT_TRUE(spec.warnings.empty());
}

TEST(Solve, DiffractionAloneMayExceedTheBudget) {
  const Specification spec = solved(
      slow_mirror(kUniform, R"("theory": "ghs")",
                  R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter": "<= 0.1 arcsec"}})"));
  EXPECT_EQ(spec.status, SolveStatus::kNoSolution);
  EXPECT_TRUE(spec.solutions.empty());
  EXPECT_NE(spec.reason.find("Airy"), std::string::npos) << spec.reason;
  // Airy pattern: 1 - J0^2 - J1^2 of v = pi D theta/lambda is 0.8 at the radius.
  const double v = pi * 0.2 / 500e-9 * spec.perfect[0].value / 2;
  const double j0 = boost::math::cyl_bessel_j(0, v), j1 = boost::math::cyl_bessel_j(1, v);
  EXPECT_NEAR(1 - j0 * j0 - j1 * j1, 0.8, kSolved);
  EXPECT_NEAR(spec.nearest.budgets[0].value / spec.perfect[0].value, 1, 1e-4) << "hardly any roughness";
}

TEST(Solve, TheSpecularCoreAloneMayMeetTheBudget) {
  // g = 4 pi 10/500: 94 % of the energy is specular, whatever the band.
  const Specification spec = solved(slow_mirror(
      R"({"model": "uniform", "rms": "10 nm", "f_min": "20 /m", "f_max": "60 /m"})", R"("theory": "ghs")",
      R"({"for": ["/roughness/psd/f_max"], "so_that": {"ee50_diameter": "<= 2 arcsec"}})"));
  EXPECT_EQ(spec.status, SolveStatus::kUnbounded);
  EXPECT_NE(spec.reason.find("specular core"), std::string::npos) << spec.reason;
  EXPECT_NEAR(spec.range[0].value, 20, 1e-5) << "the band ends at its beginning";
  EXPECT_NE(spec.range[0].why.find("f_max"), std::string::npos) << spec.range[0].why;
}

TEST(Solve, ContourOfHeightAndBandIsTheClosedLaw) {
  const Specification spec = solved(slow_mirror(
      kUniform, kGeometric,
      R"({"for": ["/roughness/psd/rms", "/roughness/psd/f_max"], "so_that": {"ee80_diameter": "<= 6 arcsec"}})"));
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  const double slope = slope_of_diameter(6 * kArcsec, 0.8);
  ASSERT_GE(spec.contour.points.size(), 10u);
  for (const SolvePoint& point : spec.contour.points) {
    EXPECT_NEAR(point.at[0] / rms_of_slope(slope, 20, point.at[1]), 1, kSolved) << point.at[1];
    EXPECT_NEAR(point.budgets[0].margin, 0, kSolved);
  }
  for (std::size_t k = 1; k < spec.contour.points.size(); ++k)
    EXPECT_GT(spec.contour.points[k].at[1], spec.contour.points[k - 1].at[1]);
  // The contour reaches the ends of the allowed range: the band, and a decade on either side.
  EXPECT_LT(spec.contour.points.front().at[1], 21);
  EXPECT_GT(spec.contour.points.back().at[1], 200);
}

TEST(Solve, ContourTurnsWhereAnotherBudgetBegins) {
  const double slope = slope_of_diameter(6 * kArcsec, 0.8);
  // The height of the closed law at 40 /m; for narrower bands the encircled energy would allow more.
  const double most = rms_of_slope(slope, 20, 40);
  const Specification spec =
      solved(slow_mirror(kUniform, kGeometric,
                         fmt::format(R"({{"for": ["/roughness/psd/rms", "/roughness/psd/f_max"],
          "so_that": {{"ee80_diameter": "<= 6 arcsec", "rms_height": "<= {:.17g} m"}}}})",
                                     most)));
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  std::array<int, 2> bound{};
  for (const SolvePoint& point : spec.contour.points) {
    ++bound[point.binding];
    EXPECT_NEAR(point.budgets[point.binding].margin, 0, 1e-9) << point.at[1];
    EXPECT_GE(point.budgets[1 - point.binding].margin, -1e-9) << point.at[1];
    if (std::abs(point.at[1] - 40) > 1) {
      EXPECT_EQ(point.binding, point.at[1] < 40 ? 1u : 0u) << point.at[1];
    }
  }
  EXPECT_GE(bound[0], 5);
  EXPECT_GE(bound[1], 3);
  EXPECT_GT(spec.contour.points.back().at[1], 200);
  EXPECT_LT(spec.contour.points.front().at[1], 22);
}

TEST(Solve, ContourInLightIsOnTheBudget) {
  const std::string text =
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {},
      "roughness": {"psd": {"model": "k-correlation", "rms": "60 nm", "B": "0.1 m", "exponent": 3.5, "f_min": "2.5 /m",
        "f_max": "40 /m"}}, "solve": {"for": ["/roughness/psd/rms", "/roughness/psd/B"], "contour_decades": 0.5,
        "so_that": {"ee80_radius": "<= 30 um"}}})";
  const Specification spec = solved(text);
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  const auto& points = spec.contour.points;
  ASSERT_GE(points.size(), 5u);
  for (const SolvePoint& point : points) EXPECT_NEAR(point.budgets[0].margin, 0, kSolved);
  for (const std::size_t k : {std::size_t(0), points.size() / 2, points.size() - 1})
    EXPECT_NEAR(target_of(text, points[k], "ee80") / 30e-6, 1, kSolved) << k;
  EXPECT_LE(spec.evaluations, int(80 + 6 * points.size())) << "exact derivatives: few steps a point";
}

// Two independent surfaces with PSDs of one shape are equivalent to one with sqrt2 times the height.
TEST(Solve, TwoEqualSurfacesAreOneOfTheRootOfTwo) {
  const std::string part =
      R"({"model": "k-correlation", "rms": "40 nm", "B": "0.1 m", "exponent": 3.5, "f_min": "2.5 /m", "f_max": "40 /m"})";
  const auto study = [](const std::string& psd, const std::string& unknown) {
    return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {}, "roughness": {"psd": )" +
           psd + R"(}, "solve": {"for": [")" + unknown + R"("], "so_that": {"ee80_radius": "<= 30 um"}}})";
  };
  const Specification one = solved(study(part, "/roughness/psd/rms"));
  ASSERT_EQ(one.solutions.size(), 1u);
  const double sigma = one.solutions[0].at[0];
  nlohmann::ordered_json half = nlohmann::ordered_json::parse(part);
  half["rms"] = sigma / std::sqrt(2.0);
  const Specification two = solved(study(R"({"model": "sum", "parts": [)" + half.dump() + "," + part + "]}",
                                         "/roughness/psd/parts/1/rms"));
  ASSERT_EQ(two.solutions.size(), 1u);
  EXPECT_NEAR(two.solutions[0].at[0] * std::sqrt(2.0) / sigma, 1, 1e-10);
  // Either surface changes the spot by half of what both do.
  EXPECT_NEAR(two.solutions[0].budgets[0].sensitivity[0] / one.solutions[0].budgets[0].sensitivity[0], 0.5,
              1e-8);
}

// At f/5000 the paraxial error 1/(32 N^2) of PHYSICS 5 is 1.3e-9.
TEST(Solve, OfAVerySlowMirrorTheClosedLawHoldsToItsLastDigits) {
  nlohmann::ordered_json study =
      nlohmann::ordered_json::parse(slow_mirror(kUniform, kGeometric,
                                                R"({"for": ["/roughness/psd/rms", "/roughness/psd/f_min"],
                      "so_that": {"ee80_diameter": "<= 6 arcsec"}, "contour_decades": 0.2})"));
  study["mirror"]["focal_length"] = "1000 m";
  const Specification spec = solved(study.dump());
  ASSERT_EQ(spec.solutions.size(), 1u);
  const double law = rms_of_slope(slope_of_diameter(6 * kArcsec, 0.8), 20, 60);
  EXPECT_NEAR(spec.solutions[0].at[0] / law, 1, 1e-8);
  // The statistic depends on rms sqrt(f_min^2 + f_max^2).
  const std::vector<double>& sensitivity = spec.solutions[0].budgets[0].sensitivity;
  EXPECT_NEAR(sensitivity[0], 1, 1e-9);
  EXPECT_NEAR(sensitivity[1], 20.0 * 20 / (20 * 20 + 60 * 60), 1e-9);
}

TEST(Solve, SaysWhereTheTheoryEnds) {
  // Half of the energy within 0.9 m at f = 2.8 m requires scatter beyond the range of the theory.
  const std::string text =
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"},
      "roughness": {"psd": {"model": "uniform", "rms": "60 um", "f_min": "2.5 /m", "f_max": "20 /m"}},
      "solve": {"for": ["/roughness/psd/rms"], "so_that": {"ee50_radius": "<= 0.9 m"}}})";
  const Specification spec = solved(text);
  ASSERT_EQ(spec.status, SolveStatus::kSolved) << spec.reason;
  std::set<std::string> codes;
  for (const Warning& warning : spec.warnings) codes.insert(warning.code);
  EXPECT_EQ(codes, (std::set<std::string>{"solve-theory-ends", "unusual"}));
}

TEST(Solve, RefusesWhatCannotBeSolvedFor) {
  const auto refusal = [](const std::string& target, const std::string& solve) -> std::string {
    try {
      solved(slow_mirror(kUniform, target, solve));
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing refused";
  };
  const std::string budget = R"("so_that": {"ee80_diameter": "<= 6 arcsec"}})";
  const struct {
    std::string target, solve, said;
  } cases[] = {
      {R"("theory": "rays")", R"({"for": ["/roughness/psd/rms"], )" + budget, "/target/theory"},
      {kGeometric, R"({"for": ["/roughness/psd/B"], )" + budget, "/roughness/psd/f_max"},
      {kGeometric, R"({"for": ["/roughness/psd/rms", "/roughness/psd/rms"], )" + budget, "different numbers"},
      {kGeometric,
       R"({"for": ["/roughness/psd/rms", "/roughness/psd/f_min", "/roughness/psd/f_max"], )" + budget,
       "one or two"},
      {kGeometric, R"({"for": [], )" + budget, "1 to 4"},
      {kGeometric, R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter": "<= 6 kg"}})", "arcsec"},
      {kGeometric, R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80": "<= 6 um"}})", "unknown key"},
      {kGeometric, R"({"for": ["/roughness/psd/rms"], "so_that": {}})", "/solve/so_that"}};
  for (const auto& one : cases) {
    const std::string said = refusal(one.target, one.solve);
    EXPECT_NE(said.find(one.said), std::string::npos) << one.solve << "\n" << said;
  }
}

TEST(Solve, NumbersOfAPsdAreThoseOfItsModel) {
  const Study study = parse_study(
      slow_mirror(
          R"({"model": "sum", "parts": [{"model": "gaussian", "rms": "5 nm", "correlation_length": "3 mm"},
        {"model": "power-law", "exponent": 3, "rms": "4 nm", "f_min": "1 /m", "f_max": "1 /mm"}]})",
          kGeometric, R"({"for": ["/x"], "so_that": {"rms_height": "<= 6 nm"}})"),
      "study.json");
  std::vector<std::string> pointers;
  for (const PsdNumber& number : psd_numbers(study)) pointers.push_back(number.pointer);
  std::sort(pointers.begin(), pointers.end());
  EXPECT_EQ(pointers, (std::vector<std::string>{
                          "/roughness/psd/parts/0/correlation_length", "/roughness/psd/parts/0/rms",
                          "/roughness/psd/parts/1/exponent", "/roughness/psd/parts/1/f_max",
                          "/roughness/psd/parts/1/f_min", "/roughness/psd/parts/1/rms"}));
  const StudyFamily family(study, {"/roughness/psd/parts/1/rms"});
  EXPECT_EQ(std::get<PowerLawPsd>(std::get<SumPsd>(*family({9e-9}).psd).parts[1]).rms, 9e-9);
  EXPECT_THROW(family({-1.0}), InputError);
}

// The unknown may be the correlation length, B over 2 pi, with the same sensitivity.
TEST(Solve, OfACorrelationLengthIsThatOfB) {
  const auto of = [](const std::string& key, const std::string& value) {
    return solved(slow_mirror(
        R"({"model": "k-correlation", "rms": "20 nm", ")" + key + R"(": ")" + value +
            R"(", "exponent": 3, "f_min": "20 /m", "f_max": "2 /mm"})",
        R"("theory": "ghs")",
        R"({"for": ["/roughness/psd/)" + key + R"("], "so_that": {"ee80_diameter": "<= 6 mm"}})"));
  };
  const Specification length = of("correlation_length", "2 mm"), b = of("B", "12.566370614359172 mm");
  ASSERT_EQ(length.status, SolveStatus::kSolved);
  ASSERT_EQ(length.solutions.size(), b.solutions.size());
  for (std::size_t k = 0; k < b.solutions.size(); ++k) {
    EXPECT_NEAR(2 * pi * length.solutions[k].at[0] / b.solutions[k].at[0], 1, 1e-9);
    EXPECT_NEAR(length.solutions[k].budgets[0].sensitivity[0], b.solutions[k].budgets[0].sensitivity[0],
                1e-7);
  }
}

// Strehl is exp(-g^2) for roughness much finer than the aperture; TIS is 1 - exp(-g^2) for any roughness.
TEST(Solve, OfStrehlAndScatterIsThatOfTheCore) {
  const std::string fine = R"({"model": "uniform", "rms": "20 nm", "f_min": "2000 /m", "f_max": "4000 /m"})";
  const auto height = [&](const std::string& so_that) {
    const Specification spec = solved(slow_mirror(
        fine, R"("theory": "ghs")", R"({"for": ["/roughness/psd/rms"], "so_that": )" + so_that + "}"));
    EXPECT_EQ(spec.status, SolveStatus::kSolved);
    return 4 * pi * spec.solutions.at(0).at[0] / 500e-9;
  };
  EXPECT_NEAR(height(R"({"strehl": ">= 0.8"})"), std::sqrt(-std::log(0.8)), 1e-5);
  EXPECT_NEAR(height(R"({"tis": "<= 1 %"})"), std::sqrt(-std::log(0.99)), 1e-6);
  const Specification none = solved(slow_mirror(
      fine, R"("theory": "ghs")", R"({"for": ["/roughness/psd/rms"], "so_that": {"mtf@2/mm": ">= 0.5"}})"));
  EXPECT_EQ(none.status, SolveStatus::kNoSolution);
  EXPECT_NE(none.reason.find("Without any roughness mtf@2/mm is already"), std::string::npos) << none.reason;
  EXPECT_THROW(solved(slow_mirror(fine, kGeometric,
                                  R"({"for": ["/roughness/psd/rms"], "so_that": {"tis": "<= 1 %"}})")),
               InputError);
}

// Closed laws of a uniform band: fraction of its area in f, slope, heights in fractions of the wavelength.
TEST(Solve, OfTheSurfaceIsThatOfItsMoments) {
  const auto height = [&](const std::string& so_that) {
    const Specification spec = solved(
        slow_mirror(kUniform, kGeometric, R"({"for": ["/roughness/psd/rms"], "so_that": )" + so_that + "}"));
    EXPECT_EQ(spec.status, SolveStatus::kSolved) << so_that;
    const double power = spec.budgets[0].is_squared ? 2 : 1;
    EXPECT_NEAR(spec.solutions.at(0).budgets[0].sensitivity[0], power, 1e-9) << so_that;
    return spec.solutions.at(0).at[0];
  };
  EXPECT_NEAR(height(R"({"rms_slope": "<= 5 urad"})") / rms_of_slope(5e-6, 20, 60), 1, 1e-9);
  EXPECT_NEAR(height(R"({"rms_height@30/m-50/m": "<= 5 nm RMS"})") / (5e-9 * std::sqrt(2.0)), 1, 1e-9);
  EXPECT_NEAR(height(R"({"rms_height@1/m-100/m": "<= lambda/20"})") / 25e-9, 1, 1e-9);
  const double root = height(R"({"structure@10mm": "<= 5 nm"})");
  EXPECT_NEAR(height(R"({"structure@10mm": "<= 25 nm^2"})") / root, 1, 1e-9);
  // D = 2 sigma^2 (1 - [f J1(2 pi f r)/(pi r)]/(f_max^2 - f_min^2)).
  const auto part = [](double f) {
    return f * boost::math::cyl_bessel_j(1, 2 * pi * f * 0.01) / (pi * 0.01);
  };
  EXPECT_NEAR(5e-9 / root, std::sqrt(2 * (1 - (part(60) - part(20)) / 3200)), 1e-8);
}

// Quantities of the surface are the same with the theory of diffraction, which they do not use.
TEST(Solve, OfTheSurfaceIsTheSameByEitherTheory) {
  const Specification spec = solved(slow_mirror(
      R"({"model": "k-correlation", "rms": "50 nm", "B": "0.1 m", "exponent": 3, "f_max": "1000 /m"})",
      R"("theory": "ghs")",
      R"({"for": ["/roughness/psd/rms"], "so_that": {"structure@10mm": "<= 5 nm", "rms_slope@0/m-100/m": "<= 1"}})"));
  ASSERT_EQ(spec.status, SolveStatus::kSolved) << spec.reason;
  const RadialPsd psd(KCorrelationPsd{spec.solutions[0].at[0], 0.1, 3, 0, 1000});
  EXPECT_NEAR(2 * structure_function(psd, Eigen::ArrayXd::Constant(1, 0.01))[0] / 25e-18, 1, 1e-9);
  EXPECT_NEAR(spec.solutions[0].budgets[1].sensitivity[0], 1, 1e-9);
}

// Two budgets on one roughness: each limit is the value at the solution of the other.
TEST(Solve, BudgetsOfLightAgreeWithEachOther) {
  const std::string begin = R"({"for": ["/roughness/psd/rms"], "so_that": )";
  const auto solution = [&](const std::string& so_that) {
    const Specification spec = solved(slow_mirror(kUniform, R"("theory": "ghs")", begin + so_that + "}"));
    EXPECT_EQ(spec.status, SolveStatus::kSolved) << so_that << spec.reason;
    return spec.solutions.at(0);
  };
  const SolvePoint first =
      solution(R"({"ensquared80_side": "<= 6 arcsec", "fwhm": "<= 1 deg", "pssn": ">= 1e-3",
      "strehl": ">= 1e-3"})");
  EXPECT_EQ(first.binding, 0u);
  const std::pair<const char*, const char*> others[] = {
      {R"("fwhm": "<=)", " rad"}, {R"("pssn": ">=)", ""}, {R"("strehl": ">=)", ""}};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string text =
        fmt::format("{{{} {:.17g}{}\"}}", others[k].first, first.budgets[k + 1].value, others[k].second);
    EXPECT_NEAR(solution(text).at[0] / first.at[0], 1, 1e-8) << text;
  }
}

TEST(Solve, ContourOfLightTakesExactDerivatives) {
  const std::string text =
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "target": {},
      "roughness": {"psd": {"model": "k-correlation", "rms": "60 nm", "B": "0.1 m", "exponent": 3.5, "f_min": "2.5 /m",
        "f_max": "40 /m"}}, "solve": {"for": ["/roughness/psd/rms", "/roughness/psd/B"], "contour_decades": 0.5,
        "so_that": {"strehl": ">= 0.7", "ensquared80_side": "<= 40 um"}}})";
  const Specification spec = solved(text);
  ASSERT_EQ(spec.status, SolveStatus::kSolved);
  const auto& points = spec.contour.points;
  ASSERT_GE(points.size(), 5u);
  for (const SolvePoint& point : points) EXPECT_NEAR(point.budgets[point.binding].margin, 0, kSolved);
  EXPECT_LE(spec.evaluations, int(80 + 6 * points.size()));
}

TEST(Solve, KeysThatAreNearlyRightAreToldWhatTheyMayMean) {
  const auto said = [](const std::string& key) -> std::string {
    try {
      solved(slow_mirror(kUniform, kGeometric,
                         R"({"for": ["/roughness/psd/rms"], "so_that": {")" + key + R"(": "<= 1 um"}})"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_NE(said("ensquared80").find("did you mean \"ensquared80_side\"?"), std::string::npos)
      << said("ensquared80");
  EXPECT_NE(said("fwmh").find("did you mean \"fwhm\"?"), std::string::npos) << said("fwmh");
  EXPECT_NE(said("rms_slpoe").find("did you mean \"rms_slope\"?"), std::string::npos) << said("rms_slpoe");
  for (const BudgetKey& kind : budget_keys())
    EXPECT_NE(said("nothing-like-it").find(kind.sample), std::string::npos) << kind.sample;
}

}  // namespace
}  // namespace aberfit
