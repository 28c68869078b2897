// The default set: fitted statistics, guides, and statistics that are left out.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/study/read_study.h"
#include "aberfit/waves/diffraction_psf.h"
#include "reference_scenes.h"
#include "short_form.h"

namespace aberfit {
namespace {

// A 0.3 m f/6 circle at 632.8 nm with a power law from 5 to 2,000 cycles/m.
std::string scene(double rms_nm, double exponent, double f_max = 2000) {
  return fmt::format(
      R"({{"aberfit": 1, "mirror": {{"focal_length": "1.8 m"}}, "aperture": {{"shape": "circle", )"
      R"("diameter": "0.3 m"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": )"
      R"("power-law", "rms": "{} nm", "exponent": {}, "f_min": "5 /m", "f_max": "{} /m"}}}}}})",
      rms_nm, exponent, f_max);
}

struct Made {
  Study study;
  Groundwork ground;
  TargetSets sets;
};
Made made(const std::string& text) {
  Made made{parse_study(text, "study.json"), {}, {}};
  made.ground = lay_groundwork(made.study);
  made.sets = make_targets(made.study, made.ground, 2);
  return made;
}

// The core has a few grains, and its halo hundreds. Rings with equal steps in radius would miss the core.
TEST(LightGuides, LeaveNoShareOfACoreWithAHaloUnwatched) {
  const Made scene_made = made(scene(70, 2.4));
  ASSERT_EQ(scene_made.ground.use.model, FocusModel::kWaves);
  const double grain = 632.8e-9 * 6;
  std::map<double, std::map<double, double>> planes;  // dz, radius, energy fraction
  for (const Target& guide : scene_made.sets.guides)
    if (const auto* ring = std::get_if<RingThrough>(&guide.statistic))
      planes[ring->dz][ring->ring_radius] = guide.value;
  ASSERT_GT(planes.size(), 9u);
  for (const auto& [dz, rings] : planes) {
    EXPECT_LE(rings.size(), 40u);  // half-grain and 2/sqrt(r) steps: bounded for any size of the halo
    double before = 0.2, inner = rings.begin()->first;
    EXPECT_NEAR(rings.begin()->second, before, 1e-6);
    for (const auto& [radius, share] : rings) {
      if (radius == inner) continue;
      // The spacing is that at which the grains on a ring average out to the margin.
      const double steady = law::kSteadyRing * 0.01 * inner * std::sqrt(2 * EIGEN_PI * inner / grain);
      EXPECT_LT(radius - inner, 1.01 * std::max(0.5 * grain, steady))
          << dz << ": from " << before << " to " << share;
      before = share;
      inner = radius;
    }
    EXPECT_GT(before, 0.9 - 0.1);
  }
  const MeanSpot focus = scene_made.ground.mean_spot->at_plane(0);
  // Checks that the scene has a core and a halo.
  EXPECT_LT(focus.encircled_energy_radius(0.3), 6 * grain);
  EXPECT_GT(focus.encircled_energy_radius(0.9), 60 * grain);
}

// All guides of a fit by waves have the same tolerance; a closer one for the mean angle would delay the fit.
TEST(LightGuides, AndTheMeanAngleHaveOneToleranceThatFollowsTheMargin) {
  for (const double margin : {0.01, 0.003}) {
    auto study = readme_study();
    study["equivalence"]["margin"] = margin;
    const Made of_waves = made(study.dump());
    ASSERT_EQ(of_waves.ground.use.model, FocusModel::kWaves);
    int angles = 0;
    for (const Target& guide : of_waves.sets.guides) {
      const double scale = guide.scale > 0 ? guide.scale : guide.value;
      EXPECT_NEAR(guide.tolerance / scale, law::kGuideShareOfMargin * margin, 1e-12)
          << statistic_name(guide.statistic);
      angles += std::holds_alternative<ScatterMean>(guide.statistic);
    }
    EXPECT_EQ(angles, 1);
  }
}

// Grid cells across for the rings of the default set, and for everything else.
struct Cells {
  double rings = 0, rest = 0;
};
Cells cells(const Made& of) {
  Cells cells;
  for (const Target& target : all_targets(of.sets)) {
    const double n = 2 * of.ground.radius /
                     diffraction_sampling(of.study.aperture, of.study.mirror.focal_length,
                                          of.study.wavelength, 0, plane_reach(target))
                         .pitch;
    double& most = std::holds_alternative<RingFwhm>(target.statistic) ? cells.rings : cells.rest;
    most = std::max(most, n);
  }
  return cells;
}

bool missing(const Made& of, const std::string& name) {
  return std::any_of(of.sets.warnings.begin(), of.sets.warnings.end(), [&](const Warning& warning) {
    return warning.code == "target-missing" && warning.message.find(name) != std::string::npos;
  });
}

// The irradiance of a ring in the halo falls to half so far out that this ring alone needs thousands of
// cells.
TEST(DefaultStatistics, LeaveOutRingsThatAskForAGridOfTheirOwn) {
  int left_out = 0, kept = 0;
  for (const double rms : {60.0, 105.0}) {
    const Made made_here = made(scene(rms, 2.2, 3000));
    ASSERT_EQ(made_here.ground.use.model, FocusModel::kWaves);
    const Cells asked = cells(made_here);
    EXPECT_LE(asked.rings, law::kMostCells * (1 + 1e-9)) << rms;
    (missing(made_here, "grid points across, so it is left out") ? left_out : kept) += 1;
  }
  EXPECT_EQ(left_out, 1);
  EXPECT_EQ(kept, 1);
}

// A uniform PSD from 5 to 20 cycles/m on a 0.3 m f/6 circle, by waves.
std::string narrow_scene(double rms_nm, const std::string& more = "", const std::string& model = "waves") {
  return fmt::format(
      R"({{"aberfit": 1, "mirror": {{"focal_length": "1.8 m"}}, "aperture": {{"shape": "circle", "diameter": )"
      R"("0.3 m"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": "uniform", )"
      R"("rms": "{} nm", "f_min": "5 /m", "f_max": "20 /m"}}}}, "trace": {{"model": "{}"}}{}}})",
      rms_nm, model, more);
}

struct Reach {
  double fitted = 0, guides = 0, held_out = 0;  // [plane units]
};
Reach reach_of(const Made& made) {
  const auto farthest = [&](const std::vector<Target>& targets) {
    double reach = 0;
    for (const Target& target : targets)
      reach = std::max(reach, std::abs(plane_of_light(target.statistic).value_or(0)));
    return reach / made.ground.plane_unit();
  };
  return {farthest(made.sets.fitted), farthest(made.sets.guides), farthest(made.sets.held_out)};
}

int said(const Made& made, const std::string& code) {
  return int(std::count_if(made.sets.warnings.begin(), made.sets.warnings.end(),
                           [&](const Warning& warning) { return warning.code == code; }));
}

// For Gaussian spots and cones of rays the mean square radii are 2 sigma^2 and (dz R/f)^2 / 2. They are equal
// two units of f sigma/R from the focus.
TEST(DefaultPlanes, OfASpotWithoutACoreEndWhereTheConeIsAsWideAsTheScatter) {
  const double thousandth = std::sqrt(std::log(1000)) * 632.8 / (4 * std::numbers::pi);  // nm: exp(-g^2)
  for (const double rms : {0.99 * thousandth, 1.01 * thousandth, 400.0}) {
    const Made here = made(narrow_scene(rms));
    ASSERT_EQ(here.ground.use.model, FocusModel::kWaves);
    const Reach reach = reach_of(here);
    const double last = rms > thousandth ? 2 : 5, last_between = rms > thousandth ? 1.75 : 4.6;
    EXPECT_NEAR(reach.fitted, last, 0.01) << rms;
    EXPECT_NEAR(reach.guides, last, 0.01) << rms;
    EXPECT_NEAR(reach.held_out, last_between, 0.01) << rms;
    // Fractions and planes are those of any spot, up to the last plane.
    std::set<double> planes, fractions;
    for (const Target& target : here.sets.fitted)
      if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic))
        planes.insert(ee->dz), fractions.insert(ee->fraction);
    EXPECT_EQ(planes.size(), rms > thousandth ? 5u : 9u);
    EXPECT_EQ(said(here, "near-planes"), rms > thousandth ? 1 : 0);
    EXPECT_EQ(fractions.size(), 7u);
  }
}

// With 3,000 cycles at f/3, the cone is as wide as the scatter only in planes beyond any grid that fits.
constexpr const char* kFastScene =
    R"({{"aberfit": 1, "mirror": {{"focal_length": "1.2 m"}}, "aperture": {{"shape": "circle",
        "diameter": "0.4 m"}}, "light": {{"wavelength": "100 nm"}}, "roughness": {{"psd": {{"model": "uniform",
        "rms": "40 nm", "f_min": "10 /m", "f_max": "7500 /m"}}}}{}}})";

TEST(DefaultPlanes, OfASpotWithoutACoreEndWhereTheCellsDo) {
  const Made here = made(fmt::format(fmt::runtime(kFastScene), ""));
  const double unit = here.ground.default_unit(), farthest = here.ground.farthest_by_cells;
  ASSERT_LT(unit, 0.5 * here.ground.plane_unit());
  std::set<double> planes;
  for (const std::vector<Target>* some : {&here.sets.fitted, &here.sets.held_out, &here.sets.guides})
    for (const Target& target : *some)
      if (const auto dz = plane_of_light(target.statistic)) planes.insert(*dz);
  EXPECT_NEAR(*planes.begin(), -farthest, 1e-6);
  EXPECT_NEAR(*planes.rbegin(), farthest, 1e-6);
  EXPECT_GE(planes.size(), 9u);
  // The limit follows from the sampling of the safe grid.
  const auto cells = [&](double dz) {
    return diffraction_sampling(CircleAperture{0.4}, 1.2, 100e-9, 0, dz).samples;
  };
  EXPECT_LE(cells(-0.999 * farthest), law::kMostCells);
  EXPECT_GT(cells(-1.001 * farthest), law::kMostCells);
  EXPECT_TRUE(missing(here, "where wave optics needs more than 1024 grid points across"));
  ASSERT_EQ(said(here, "near-planes"), 1);
  for (const Warning& warning : here.sets.warnings)
    if (warning.code == "near-planes") {
      EXPECT_NE(warning.message.find("needs more than 1024 grid points across"), std::string::npos);
    }
}

// A named plane a tenth beyond the default ones does not need ten times the cells.
TEST_WITH_SHORT_FORM(DefaultPlanes, BeyondTheCellsAreThereWhereTheyAreNamed) {
  const Groundwork ground = made(fmt::format(fmt::runtime(kFastScene), "")).ground;
  const double unit = ground.plane_unit();
  for (const double asked :
       aberfit::test::all_or_few(whole, std::vector{1.1 * ground.farthest_by_cells / unit, 1.8}, {0})) {
    const Made named = made(fmt::format(
        fmt::runtime(kFastScene),
        fmt::format(R"(, "target": {{"statistics": {{"ee50": {{"planes": [0, {}]}}}}}})", asked * unit)));
    EXPECT_NEAR(reach_of(named).fitted, asked, 0.001 * asked);
    EXPECT_NEAR(reach_of(named).guides, asked, 0.001 * asked);
    EXPECT_NEAR(reach_of(named).held_out, 0.875 * asked, 0.01 * asked);
    EXPECT_EQ(said(named, "near-planes"), 0);
  }
}

// The irradiance of the 90 % ring falls to half three units out of focus.
TEST(DefaultPlanes, LeaveOutTheRingsBeyondThem) {
  const Made deep = made(narrow_scene(400)), usual = made(narrow_scene(60));
  const auto rings = [](const std::vector<Target>& targets) {
    return std::count_if(targets.begin(), targets.end(), [](const Target& target) {
      return std::holds_alternative<RingFwhm>(target.statistic);
    });
  };
  EXPECT_EQ(rings(usual.sets.fitted), 1);
  EXPECT_FALSE(missing(usual, "ring_fwhm"));
  EXPECT_EQ(rings(deep.sets.fitted), 0);
  EXPECT_TRUE(missing(deep, "beyond the default planes of a spot without a core"));
  for (const Target& target : deep.sets.held_out) {
    const bool is_ring = std::holds_alternative<RingFwhm>(target.statistic);
    EXPECT_LE(is_ring ? 0.5 * target.value : 0, 2.001 * deep.ground.plane_unit());
  }
}

TEST(DefaultPlanes, GoAsFarAsWhatIsAskedForByName) {
  const double unit = made(narrow_scene(400)).ground.plane_unit();
  const Made named = made(narrow_scene(
      400, fmt::format(R"(, "target": {{"statistics": {{"ee50": {{"planes": [0, {}]}}}}}})", 4 * unit)));
  const Reach reach = reach_of(named);
  EXPECT_NEAR(reach.fitted, 4, 0.01);
  EXPECT_NEAR(reach.guides, 5, 0.01);  // on both sides of the named plane
  EXPECT_NEAR(reach.held_out, 4.6, 0.01);
  EXPECT_EQ(said(named, "near-planes"), 0);
  const Made in_focus = made(narrow_scene(400, R"(, "target": {"statistics": {"ee50": {}}})"));
  EXPECT_NEAR(reach_of(in_focus).held_out, 1.75, 0.01);
  EXPECT_NEAR(reach_of(in_focus).guides, 2, 0.01);
  const Made ring = made(narrow_scene(400, R"(, "target": {"statistics": {"ring_fwhm@ee50": {}}})"));
  EXPECT_NEAR(reach_of(ring).guides, 5, 0.01);
}

TEST(DefaultPlanes, OfRaysAreAll) {
  for (const char* theory : {"geometric", "ghs"}) {
    const Made rays =
        made(narrow_scene(400, fmt::format(R"(, "target": {{"theory": "{}"}})", theory), "rays"));
    EXPECT_NEAR(reach_of(rays).fitted, 5, 0.01) << theory;
  }
}

// Most of this height is slower than the aperture: exp(-g^2) is 0.003, but 45 % of the energy is in the core.
TEST(DefaultPlanes, OfASpotWithACoreAreAllWhateverIsSlowerThanTheAperture) {
  const Made slow = made(
      R"({"aberfit": 1, "mirror": {"focal_length": "0.7 m"}, "aperture": {"shape": "circle", "diameter": "0.1 m"},
      "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": {"model": "power-law", "rms": "120 nm",
      "exponent": 2.5, "f_min": "0.1 /m", "f_max": "1000 /m"}}})");
  ASSERT_EQ(slow.ground.use.model, FocusModel::kWaves);
  ASSERT_LT(1 - slow.ground.numbers.tis, 0.01);
  EXPECT_NEAR(reach_of(slow).fitted, 5, 0.01);
  EXPECT_EQ(said(slow, "near-planes"), 0);
}

// N_eff of a Gaussian ACF of length l is area / (pi l^2) to a few percent: 10 for a 0.3 m circle, l = 47 mm.
std::string with_correlation_length(double millimetres, const std::string& target = "") {
  return fmt::format(
      R"({{"aberfit": 1, "mirror": {{"focal_length": "1.8 m"}}, "aperture": {{"shape": "circle", "diameter": )"
      R"("0.3 m"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": "gaussian", )"
      R"("rms": "60 nm", "correlation_length": "{} mm"}}}}{}}})",
      millimetres, target);
}
int moments_of(const TargetSets& sets) {
  int count = 0;
  for (const Target& target : all_targets(sets)) count += kind_of(target.statistic).is_moment();
  return count;
}

// For few modes the mean irradiance is not that of a mirror with the mean height; no surface meets both.
TEST(FewModes, LeaveHeightAndSlopeOutOfTheDefaultStatistics) {
  const Made few = made(with_correlation_length(110)), more = made(with_correlation_length(85));
  ASSERT_LT(few.ground.numbers.n_eff, 9);
  ASSERT_GT(more.ground.numbers.n_eff, 11);
  EXPECT_EQ(moments_of(few.sets), 0);
  EXPECT_EQ(said(few, "few-modes"), 1);
  EXPECT_GE(moments_of(more.sets), 3);
  EXPECT_EQ(said(more, "few-modes"), 0);
}

TEST(FewModes, KeepWhatIsAskedForWithAWord) {
  const Made asked = made(with_correlation_length(
      110,
      R"(, "target": {"statistics": {"ee50": {}, "rms_height": {}}}, "terms": {"zernike": {"n_max": 6}})"));
  EXPECT_GE(moments_of(asked.sets), 1);
  EXPECT_EQ(said(asked, "few-modes"), 1);
  const Made light = made(with_correlation_length(
      110, R"(, "target": {"statistics": {"ee50": {}, "ee80": {}}}, "terms": {"zernike": {"n_max": 6}})"));
  EXPECT_EQ(said(light, "few-modes"), 0);
}

// Held-out statistics are judged, so guides are needed along them.
TEST(NamedStatistics, AreGuidedAlongTheRestOfTheCurve) {
  const Study study = parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
      "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": {"model": "uniform", "rms": "60 nm",
      "f_min": "2.5 /m", "f_max": "4.8 /m"}}, "terms": {"zernike": {"n_max": 8}}, "target": {"statistics":
      {"ee20": {}, "ee50": {}, "ee80": {}, "ee90": {}, "ee95": {}}}, "output": {"pictures": "none"}})",
      "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.judgement.verdict, Verdict::kEquivalent) << result.fitted.fit.message;
  EXPECT_EQ(result.fitted.targets.size(), 5u);
  EXPECT_GT(result.judgement.metrics.size(), 80u);
}

std::string given(const std::string& statistics) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "1.8 m"}, "aperture": {"shape": "circle", "diameter": "0.3 m"},
      "light": {"wavelength": "632.8 nm"}, "terms": {"zernike": {"n_max": 6}},
      "fit": {"prior": "zero-mean"}, "target": {"statistics": {)" +
         statistics + "}}}";
}

TEST(GivenValues, OfOnePlaneGrowWithTheShareOfTheLight) {
  EXPECT_NO_THROW(made(given(R"("ee50": {"value": "10 um"}, "ee90": {"value": "20 um"})")));
  // Energy fractions within radii are points of the same curve; other planes have their own.
  EXPECT_NO_THROW(
      made(given(R"("ee50": {"value": "10 um"}, "ee_within": {"radii": ["12 um"], "value": 0.6})")));
  EXPECT_NO_THROW(
      made(given(R"("ee50": {"value": "30 um", "planes": ["1 mm"]}, "ee90": {"value": "20 um"})")));
  for (const char* wrong :
       {R"("ee50": {"value": "20 um"}, "ee90": {"value": "10 um"})",
        R"("ee50": {"value": "20 um"}, "ee90": {"value": "20 um"})",
        R"("ee50": {"value": "10 um"}, "ee_within": {"radii": ["9 um"], "value": 0.6})"}) {
    try {
      made(given(wrong));
      ADD_FAILURE() << "was taken: " << wrong;
    } catch (const FieldError& error) {
      EXPECT_EQ(error.field(), "target.statistics.ee50") << wrong;
      EXPECT_NE(error.found().find("50 % of the energy within"), std::string::npos) << error.found();
    }
  }
}

// The Airy pattern of f/6 at 632.8 nm has ee50 = 0.535 lambda N and ee80 = 0.90 lambda N.
TEST(GivenValues, SharperThanDiffractionAreTold) {
  const auto told = [](const std::string& statistics) {
    const Made one = made(given(statistics));
    std::string text;
    for (const Warning& warning : one.sets.warnings)
      if (warning.code == "below-diffraction") text += warning.message;
    return text;
  };
  EXPECT_EQ(told(R"("ee50": {"value": "2.1 um"}, "ee90": {"value": "20 um"})"), "");
  const std::string sharp = told(R"("ee50": {"value": "1.8 um"}, "ee90": {"value": "20 um"})");
  EXPECT_NE(sharp.find("ee50_radius_m = 1.8 um (the perfect mirror: 2.03"), std::string::npos) << sharp;
  EXPECT_EQ(sharp.find("ee90"), std::string::npos) << sharp;
}

std::string disc_study(const std::string& focal_length, const std::string& diameter, const std::string& rms) {
  return fmt::format(
      R"({{"aberfit": 1, "mirror": {{"focal_length": "{}"}}, "aperture": {{"shape": "circle", "diameter": "{}"}},
      "light": {{"wavelength": "632.8 nm"}}, "roughness": {{"psd": {{"model": "uniform", "rms": "{}",
      "f_min": "5 /m", "f_max": "20 /m"}}}}}})",
      focal_length, diameter, rms);
}

TEST(Depth, OfAFocusWithoutPlanesBesideItIsBlamedOnItsCause) {
  const auto refused = [](const std::string& focal_length, const std::string& diameter,
                          const std::string& rms) {
    try {
      lay_groundwork(parse_study(disc_study(focal_length, diameter, rms), "study.json"));
    } catch (const FieldError& error) {
      return error.field() + ": " + error.allowed();
    }
    return std::string();
  };
  EXPECT_EQ(refused("1.4 m", "0.2 m", "60 nm"), "");
  EXPECT_EQ(refused("1.4 m", "0.2 m", "0.15 mm"), "");
  EXPECT_NE(refused("1.4 m", "0.2 m", "1 mm").find("roughness.psd: an RMS slope far below"),
            std::string::npos);
  // R^2/(lambda f) = 0.39: a pinhole.
  const std::string pinhole = refused("1 m", "1 mm", "1 nm");
  EXPECT_NE(pinhole.find("mirror.focal_length: a Fresnel number R^2/(lambda f) well above 1, here 0.4"),
            std::string::npos)
      << pinhole;
}

// For a spot nearly as wide as the aperture, planes at five of its depths would lie behind the mirror.
TEST(Depth, OfASpotAsWideAsTheMirrorKeepsPlanesInFrontOfIt) {
  const auto planes_of = [](const Made& of) {
    double farthest = 0;
    for (const Target& target : all_targets(of.sets))
      if (const auto dz = plane_of_light(target.statistic)) farthest = std::max(farthest, std::abs(*dz));
    return farthest;
  };
  const auto told = [](const Made& of) {
    std::string text;
    for (const Warning& warning : of.ground.use.warnings)
      if (warning.code == "deep-focus") text += warning.message;
    return text;
  };
  const Made deep = made(disc_study("1.4 m", "0.2 m", "0.15 mm"));
  EXPECT_GT(5 * 1.4 * deep.ground.core_sigma / 0.1, 1.4);
  EXPECT_NEAR(planes_of(deep), 0.7, 1e-9);
  EXPECT_NE(told(deep).find("limited to 700 mm, and rings are left out"), std::string::npos) << told(deep);
  for (const Target& target : all_targets(deep.sets))
    EXPECT_FALSE(std::holds_alternative<RingFwhm>(target.statistic));
  const Made usual = made(disc_study("1.4 m", "0.2 m", "60 nm"));
  EXPECT_EQ(told(usual), "");
  EXPECT_NEAR(planes_of(usual) / (5 * 1.4 * usual.ground.core_sigma / 0.1), 1, 1e-3);
}

TEST(TargetSets, WithoutAFocusTheRefusalNamesTheCause) {
  const auto refused = [](const char* height, const char* rms) -> std::string {
    try {
      made(fmt::format(
          R"({{"aberfit": 1, "mirror": {{"focal_length": "7 m"}}, "aperture": {{"shape": "rectangle", )"
          R"("width": "1 m", "height": "{}"}}, "light": {{"wavelength": "632.8 nm"}}, "roughness": )"
          R"({{"psd": {{"model": "gaussian", "rms": "{}", "correlation_length": "5 mm"}}}}}})",
          height, rms));
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refused("1 nm", "18 nm").find("its smaller side"), std::string::npos) << refused("1 nm", "18 nm");
  EXPECT_NE(refused("1 m", "5 mm").find("less height or a lower f_max"), std::string::npos)
      << refused("1 m", "5 mm");
  EXPECT_EQ(refused("1 m", "18 nm"), "");
}

// The field of view is smaller towards the mirror, while the image at the same defocus is as wide.
TEST(WavePitch, IsThatOfThePlaneNearestToTheMirror) {
  const Study study = parse_study(disc_study("0.26 m", "9 mm", "90 nm"), "study.json");
  const auto pitch = [&](double dz) {
    Target target;
    target.statistic = EncircledEnergyRadius{0.9, dz};
    target.value = 1e-3;
    return wave_pitch(study, {4.5e-3, {}, {}, {}}, {target}, nullptr);
  };
  const auto asked = [&](double dz) {
    return diffraction_sampling(study.aperture, 0.26, 632.8e-9, 0, dz).pitch;
  };
  for (const double dz : {0.19, -0.19, 0.05, -0.05}) EXPECT_LE(pitch(dz), asked(dz) * (1 + 1e-12)) << dz;
  EXPECT_LT(pitch(-0.19), 0.3 * pitch(0.19));
  Target ring;  // a ring needs both sides
  ring.statistic = RingFwhm{};
  ring.value = 0.19 / 0.75;
  EXPECT_NEAR(wave_pitch(study, {4.5e-3, {}, {}, {}}, {ring}, nullptr) / asked(-0.19), 1, 0.02);
}

// In a focus of a few um depth, rounded planes must stay distinct.
TEST(DefaultStatistics, AreDistinctInEveryDepthOfFocus) {
  for (const char* size : {"1 mm", "20 mm", "300 mm", "5 m"}) {
    const std::string text = R"({"aberfit": 1, "mirror": {"focal_length": ")" + std::string(size) +
                             R"("}, "aperture": {"shape": "circle", "diameter": ")" + size +
                             R"("}, "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": {"model": )" +
                             R"("gaussian", "rms": "25 nm", "correlation_length": "0.1 mm"}}})";
    const Study study = parse_study(text, "study.json");
    const Groundwork ground = lay_groundwork(study);
    const TargetSets sets = make_targets(study, ground, 1);
    std::set<std::string> names;
    std::size_t count = 0;
    for (const auto* some : {&sets.fitted, &sets.guides, &sets.held_out})
      for (const Target& target : *some) {
        std::string name = statistic_name(target.statistic);
        if (const auto* ring = std::get_if<RingThrough>(&target.statistic))
          name += std::to_string(1e9 * ring->ring_radius);
        names.insert(name);
        ++count;
      }
    EXPECT_EQ(names.size(), count) << size;
    // Rounding is small beside the steps between planes.
    for (const Target& target : sets.held_out)
      if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic)) {
        const double units = ee->dz / ground.plane_unit();
        double nearest = HUGE_VAL;
        for (const double wanted : {0.0, 0.25, 0.75, 1.75, 3.1, 4.6})
          nearest = std::min(nearest, std::abs(std::abs(units) - wanted));
        EXPECT_LE(nearest, 0.025 * (1 + 1e-9)) << size;
      }
  }
}

}  // namespace
}  // namespace aberfit
