// Legal numbers of a study that are probably wrong: which are reported, which value is suggested, and that
// studies of real mirrors have no such message.
#include "aberfit/study/unusual.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "shared_data.h"
#include "study/study_texts.h"

namespace aberfit {
namespace {

using test::kMinimalStudy;

using Changes = std::vector<std::string>;

Study study_with(const Changes& changes) { return parse_study(kMinimalStudy, "s.json", changes); }

std::vector<UnusualNumber> unusual_with(const Changes& changes) {
  return unusual_numbers(study_with(changes));
}

constexpr const char* kWith = R"(/solve={"for": ["/roughness/psd/rms"],
  "so_that": {"ee80_diameter": "<= 20 um"}, "with": )";

// One wrong number: it is reported once, at its key, with the probable value.
struct OneSlip {
  Changes changes;
  std::string pointer, value, meant;
};

TEST(UnusualNumbers, OfOneWrongNumberAreToldOnceWithWhatWasMeant) {
  const OneSlip kSlips[] = {
      // The mirror: millimetres instead of metres, metres instead of millimetres, and swapped lengths.
      {{"/aperture/diameter=250"}, "/aperture/diameter", "250 m", "a diameter of 250 mm"},
      {{"/mirror/focal_length=1500", "/aperture/diameter=0.25"},
       "/mirror/focal_length",
       "1.5 km",
       "a focal length of 1.5 m"},
      {{"/mirror/focal_length=1.5 mm"}, "/mirror/focal_length", "1.5 mm", "a focal length of 1.5 m"},
      {{"/aperture/diameter=250 um"}, "/aperture/diameter", "250 um", "a diameter of 250 mm"},
      {{"/mirror/focal_length=0.3", "/aperture/diameter=2.4"},
       "/mirror/focal_length",
       "300 mm",
       "focal length and diameter interchanged"},
      {{R"(/aperture={"shape": "rectangle", "width": 300, "height": 200})"},
       "/aperture/width",
       "300 m",
       "a width of 300 mm"},
      {{R"(/aperture={"shape": "annulus", "diameter": 500, "inner_diameter": 100})"},
       "/aperture/diameter",
       "500 m",
       "a diameter of 500 mm"},
      {{R"(/mirror/zernike={"noll": {"5": "90 mm"}})"},
       "/mirror/zernike/noll/5",
       "90 mm",
       "a height of 90 um"},
      {{"/light/wavelength=3 pm"}, "/light/wavelength", "3 pm", "a wavelength of 3 nm"},
      // The roughness: heights, and bands in /mm instead of /m and vice versa.
      {{"/roughness/psd/rms=200 um", "/roughness/psd/f_max=10 /m"},
       "/roughness/psd/rms",
       "200 um",
       "an RMS height of 200 nm"},
      {{"/roughness/psd/rms=5 mm"}, "/roughness/psd/rms", "5 mm", "an RMS height of 5 um"},
      {{"/roughness/psd/rms=1 pm"}, "/roughness/psd/rms", "1 pm", "an RMS height of 1 nm"},
      {{"/roughness/psd/f_min=0.004 /m", "/roughness/psd/f_max=0.3 /m"},
       "/roughness/psd/f_max",
       "0.3 /m",
       "a highest frequency of 300 /m"},
      {{"/roughness/psd/f_min=5 /um", "/roughness/psd/f_max=40 /um"},
       "/roughness/psd/f_max",
       "40 /um",
       "a highest frequency of 40 /mm"},
      {{R"(/roughness/psd={"model": "gaussian", "rms": "20 nm", "correlation_length": 15})"},
       "/roughness/psd/correlation_length",
       "15 m",
       "a length of 15 mm"},
      {{R"(/roughness/psd={"model": "sum", "parts": [{"model": "uniform", "rms": "20 nm", "f_min": "3 /m",
           "f_max": "30 /m"}, {"model": "uniform", "rms": "3 mm", "f_min": "30 /m", "f_max": "300 /m"}]})"},
       "/roughness/psd/parts/1/rms",
       "3 mm",
       "an RMS height of 3 um"},
      // Contributors to the spot, and the focus.
      {{kWith + std::string(R"({"jitter": 0.3}})")},
       "/solve/with/jitter",
       "300 mrad",
       "a jitter of 0.3 arcsec"},
      {{kWith + std::string(R"({"atmosphere": {"r0": 200, "wavelength": "500 nm"}}})")},
       "/solve/with/atmosphere/r0",
       "200 m",
       "an r0 of 200 mm"},
      {{kWith + std::string(R"({"surfaces": [{"name": "flat", "psd": {"model": "uniform", "rms": "2 mm",
          "f_min": "30 /m", "f_max": "300 /m"}}]}})")},
       "/solve/with/surfaces/0/psd/rms",
       "2 mm",
       "an RMS height of 2 um"},
      {{R"(/target/statistics={"ee80": {"value": 30}})"},
       "/target/statistics/ee80/value",
       "30 m",
       "a length of 30 mm"},
      {{R"(/target/statistics={"ee_within": {"radii": ["10 um", 15]}})"},
       "/target/statistics/ee_within/radii/1",
       "15 m",
       "a length of 15 mm"},
      {{R"(/target/statistics={"ee80": {"planes": [0, -3]}})"},
       "/target/statistics/ee80/planes/1",
       "-3 m",
       "a plane at -3 mm"}};
  for (const OneSlip& slip : kSlips) {
    const std::vector<UnusualNumber> unusual = unusual_with(slip.changes);
    ASSERT_EQ(unusual.size(), 1u) << slip.changes[0];
    EXPECT_EQ(unusual[0].pointer, slip.pointer);
    EXPECT_EQ(unusual[0].value, slip.value);
    EXPECT_NE(unusual[0].meant.find(slip.meant), std::string::npos) << unusual[0].meant;
  }
}

// The scene with both numbers wrong has two lines, each with its own remedy.
TEST(UnusualNumbers, OfTwoWrongNumbersAreToldEach) {
  const std::vector<UnusualNumber> unusual =
      unusual_with({"/aperture/diameter=400", "/roughness/psd/rms=2 mm"});
  ASSERT_EQ(unusual.size(), 2u);
  EXPECT_EQ(unusual[0].pointer, "/aperture/diameter");
  EXPECT_EQ(unusual[1].pointer, "/roughness/psd/rms");
}

// 1.5 m and 0.25 mm, or 1.5 mm and 0.25 m, instead of 1.5 m and 0.25 m. The message names both remedies,
// because the numbers do not decide which length is wrong.
TEST(UnusualNumbers, NameBothWaysOutWhereTheyAreAsLikely) {
  for (const Changes& changes : {Changes{"/mirror/focal_length=1.5", "/aperture/diameter=0.25 mm"},
                                 Changes{"/mirror/focal_length=1.5 mm", "/aperture/diameter=0.25"}}) {
    const std::vector<UnusualNumber> unusual = unusual_with(changes);
    ASSERT_EQ(unusual.size(), 1u);
    EXPECT_NE(unusual[0].meant.find("a diameter of 250 "), std::string::npos) << unusual[0].meant;
    EXPECT_NE(unusual[0].meant.find("a focal length of 1.5 "), std::string::npos) << unusual[0].meant;
  }
}

// With the suggested value there is no further message.
TEST(UnusualNumbers, AreOrdinaryOnceTheSlipIsUndone) {
  const std::pair<Changes, Changes> kPairs[] = {{{"/aperture/diameter=250"}, {"/aperture/diameter=250 mm"}},
                                                {{"/roughness/psd/rms=5 mm"}, {"/roughness/psd/rms=5 um"}},
                                                {{"/mirror/focal_length=0.3", "/aperture/diameter=2.4"},
                                                 {"/mirror/focal_length=2.4", "/aperture/diameter=0.3"}}};
  for (const auto& [wrong, right] : kPairs) {
    EXPECT_EQ(unusual_with(wrong).size(), 1u);
    EXPECT_TRUE(unusual_with(right).empty());
  }
}

// The ends of each range are those in FORMATS.md.
TEST(UnusualNumbers, BeginAtTheEndsOfTheRanges) {
  const auto one = [](const std::string& change) { return unusual_with({change}).size(); };
  // These limits are for f = 2.8 m.
  EXPECT_EQ(one("/aperture/diameter=11.19"), 0u);  // f/0.2502
  EXPECT_EQ(one("/aperture/diameter=11.21"), 1u);
  EXPECT_EQ(one("/mirror/focal_length=1999"), 0u);  // f/4998
  EXPECT_EQ(one("/mirror/focal_length=2001"), 1u);
  // With lambda = 632.8 nm, 63.28 um is 100 wavelengths and 15.82 pm is 2.5e-5. For a uniform PSD up to 39.92
  // /m the slope is far below 0.1.
  EXPECT_EQ(one("/roughness/psd/rms=63.2 um"), 0u);
  EXPECT_EQ(one("/roughness/psd/rms=63.3 um"), 1u);
  EXPECT_EQ(one("/roughness/psd/rms=15.9 pm"), 0u);
  EXPECT_EQ(one("/roughness/psd/rms=15.8 pm"), 1u);
  // With S constant from 0 to F the slope per axis is pi rms F: 0.1 at 318.3 /mm for 100 nm.
  const std::string kBand =
      R"(/roughness/psd={"model": "uniform", "rms": "100 nm", "f_min": "0.1 /m", "f_max": )";
  EXPECT_EQ(one(kBand + "\"318.2 /mm\"}"), 0u);
  EXPECT_EQ(one(kBand + "\"318.4 /mm\"}"), 1u);
  EXPECT_EQ(one(kBand + "\"2.51 /m\"}"), 0u);  // 0.4 m across
  EXPECT_EQ(one(kBand + "\"2.49 /m\"}"), 1u);
  EXPECT_EQ(one(kWith + std::string(R"({"jitter": "0.99 mrad"}})")), 0u);
  EXPECT_EQ(one(kWith + std::string(R"({"jitter": "1.01 mrad"}})")), 1u);
}

// Both lengths of a mirror in millimetres, or both in metres.
TEST(UnusualNumbers, OfAMirrorInAnotherUnitAreTakenTogether) {
  for (const auto& [changes, meant] :
       {std::pair{Changes{"/mirror/focal_length=2800", "/aperture/diameter=400"},
                  "a diameter of 400 mm and a focal length of 2.8 m"},
        {Changes{"/mirror/focal_length=1200", "/aperture/diameter=150"},
         "a diameter of 150 mm and a focal length of 1.2 m"},
        {Changes{"/mirror/focal_length=15 um", "/aperture/diameter=3 um", "/roughness/psd/f_max=2000 /m"},
         "a diameter of 3 mm and a focal length of 15 mm"}}) {
    const std::vector<UnusualNumber> unusual = unusual_with(changes);
    ASSERT_EQ(unusual.size(), 1u) << changes[0];
    EXPECT_EQ(unusual[0].pointer, "/aperture/diameter");
    EXPECT_NE(unusual[0].meant.find(meant), std::string::npos) << unusual[0].meant;
  }
}

// A part of a sum may be of any smoothness, but the whole may not.
TEST(UnusualNumbers, OfASmoothPartAreNone) {
  const auto sum = [](const char* first) {
    return unusual_with(
               {std::string(R"(/roughness/psd={"model": "sum", "parts": [{"model": "uniform", "rms": ")") +
                first + R"(", "f_min": "3 /m", "f_max": "30 /m"}, {"model": "uniform", "rms": "1 pm",
                         "f_min": "30 /m", "f_max": "300 /m"}]})"})
        .size();
  };
  EXPECT_EQ(sum("20 nm"), 0u);
  EXPECT_EQ(sum("1 pm"), 2u);
}

// An error of a run with usual numbers is passed on unchanged. If a number is unusual, the error names it.
TEST(FailureOfAStudy, NamesTheNumberThatIsUnusual) {
  const auto fail = [] { throw ComputationError("no light"); };
  const Study ordinary = study_with({});
  EXPECT_THROW(with_fields_of(ordinary, fail), ComputationError);
  for (const auto& [change, pointer] : {std::pair{"/aperture/diameter=400", "/aperture/diameter"},
                                        {"/mirror/focal_length=2.8 mm", "/mirror/focal_length"},
                                        {"/roughness/psd/rms=2 mm", "/roughness/psd/rms"}}) {
    const Study study = study_with({change});
    try {
      with_fields_of(study, fail);
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(error.pointer(), pointer);
      EXPECT_NE(error.found().find("; a wrong unit?"), std::string::npos) << error.found();
      EXPECT_NE(error.found().find("no light"), std::string::npos) << error.found();
    }
    // An error about a field of the scene names the unusual number instead; an error about another field
    // keeps its own pointer.
    const auto field = [](const char* name) { return [name] { throw FieldError(name, "this", "that"); }; };
    EXPECT_THROW(
        try { with_fields_of(study, field("mirror.focal_length")); } catch (const InputError& error) {
          EXPECT_EQ(error.pointer(), pointer);
          throw;
        },
        InputError);
    EXPECT_THROW(
        try { with_fields_of(study, field("target.psd.method")); } catch (const InputError& error) {
          EXPECT_EQ(error.pointer(), "/target/psd/method");
          throw;
        },
        InputError);
    EXPECT_THROW(with_fields_of(study, [] { throw Interrupted("stopped"); }), Interrupted);
  }
}

TEST(UnusualWarnings, AreOfTheStudyThatIsReadOnceEach) {
  EXPECT_TRUE(study_with({}).data_warnings.empty());
  const Study study = study_with({"/mirror/focal_length=2800"});
  ASSERT_EQ(study.data_warnings.size(), 1u);
  EXPECT_EQ(study.data_warnings[0].code, "unusual");
  EXPECT_EQ(study.data_warnings[0].message,
            "/mirror/focal_length is 2.8 km: an f-number of 7000; 0.25 to 5000 is usual. Is a focal length "
            "of 2.8 m meant? Then it is 7.");
}

// Real mirrors, which must give no message: f [m], D [m], lambda [m], rms [m], band [/m].
TEST(OrdinaryNumbers, AreThoseOfMirrorsThatAreBuilt) {
  struct Built {
    const char* what;
    double focal, across, wavelength, rms, f_min, f_max;
  };
  for (const Built& mirror :
       {Built{"dish for millimetre waves", 17.5, 50, 1e-3, 75e-6, 0.02, 20},
        Built{"largest dish below a centimetre", 60, 100, 3e-3, 240e-6, 0.01, 10},
        Built{"extremely large telescope", 34.2, 39.3, 1e-6, 30e-9, 0.03, 1e4},
        Built{"cavity of a gravitational-wave detector", 970, 0.34, 1.064e-6, 0.3e-9, 3, 1e3},
        Built{"projection optics for extreme ultraviolet", 1.5, 0.4, 13.5e-9, 0.1e-9, 10, 1e6},
        Built{"X-rays near normal incidence", 2, 0.05, 4.5e-9, 0.2e-9, 20, 1e7},
        Built{"mirror on a fibre", 50e-6, 20e-6, 780e-9, 0.3e-9, 1e5, 1e7},
        Built{"scanner on a chip", 10e-3, 1e-3, 905e-9, 5e-9, 2e3, 1e6},
        Built{"Cherenkov telescope", 16, 12, 350e-9, 7e-6, 0.1, 100},
        Built{"searchlight", 0.3, 1.1, 550e-9, 2e-6, 1, 1e3}}) {
    const std::vector<UnusualNumber> unusual =
        unusual_with({fmt::format("/mirror/focal_length={}", mirror.focal),
                      fmt::format("/aperture/diameter={}", mirror.across),
                      fmt::format("/light/wavelength={}", mirror.wavelength),
                      fmt::format("/roughness/psd/rms={}", mirror.rms),
                      fmt::format("/roughness/psd/f_min={}", mirror.f_min),
                      fmt::format("/roughness/psd/f_max={}", mirror.f_max)});
    EXPECT_TRUE(unusual.empty()) << mirror.what << ": " << unusual[0].quantity;
  }
}

// Counts the studies below `folder` whose file has this name (all if it is empty), whatever they request;
// none may give a message.
int count_ordinary(const std::filesystem::path& folder, const std::string& name) {
  int studies = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".json" || !(name.empty() || entry.path().filename() == name)) continue;
    const Study study = read_study(entry.path().string());
    for (const UnusualNumber& number : unusual_numbers(study))
      ADD_FAILURE() << entry.path() << ": " << number.pointer << ", " << number.quantity;
    for (const Warning& warning : study.data_warnings)
      EXPECT_NE(warning.code, "unusual") << entry.path() << ": " << warning.message;
    ++studies;
  }
  return studies;
}

TEST(OrdinaryNumbers, AreThoseOfTheReferenceStudies) {
  EXPECT_GT(count_ordinary(std::filesystem::path(ABERFIT_SOURCE_DIR) / "fits", "study.json"), 10);
}

class ScenesOnRealData : public test::RealData {
 protected:
  ScenesOnRealData() : RealData("scenes") {}
};

TEST_F(ScenesOnRealData, HaveNothingUnusual) { EXPECT_GT(count_ordinary(file(""), ""), 20); }

}  // namespace
}  // namespace aberfit
