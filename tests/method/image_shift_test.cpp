// Known aberrations that move the image: the warning, its shift, and the tilt that removes it.
#include "aberfit/method/image_shift.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "aberfit/commands/run.h"
#include "aberfit/core/units.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

// f/7; heights by Noll's index.
Study study_of(const std::string& noll, const std::string& rest = "",
               const std::string& shape = R"("shape": "circle", "diameter": "0.4 m")") {
  return parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m", "zernike": {"noll": {)" + noll +
          R"(}}}, "light": {"wavelength": "632.8 nm"}, "aperture": {)" + shape +
          R"(}, "roughness": {"psd": {"model": "uniform", "rms": "2 nm", "f_min": "2.5 /m", "f_max": "10 /m"}})" +
          rest + "}",
      "study.json");
}

// The length before `words` in the warning.
double length_before(const std::string& text, const std::string& words) {
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(R"(([-0-9.e+]+ [a-z]+) )" + words))) return NAN;
  return parse_quantity(found[1].str(), Dimension::kLength);
}

// For a surface a Z the centroid lies at 2f times its mean slope: 4 f a/R for Z_2 = 2x/R, sqrt(2) of that for
// Z_8 with its tilt. An opposite tilt of the same size centres the image.
TEST(ImageShift, IsSaidWithTheTiltThatEndsIt) {
  struct Case {
    const char *noll, *shape;
    int axis;
    double tilt, shift;  // recommended, found [m]
    bool coma = false;
  };
  const char* const kCircle = R"("shape": "circle", "diameter": "0.4 m")";
  const char* const kAnnulus = R"("shape": "annulus", "diameter": "0.4 m", "inner_diameter": "0.1 m")";
  const double per_height = 4 * 2.8 / 0.2;
  for (const Case& one :
       std::vector<Case>{{R"("2": "200 nm")", kCircle, 2, -200e-9, 200e-9 * per_height},
                         {R"("3": "-90 nm", "6": "30 nm")", kAnnulus, 3, 90e-9, 90e-9 * per_height},
                         {R"("8": "150 nm")", kCircle, 2, -150e-9 * std::sqrt(2.0),
                          150e-9 * std::sqrt(2.0) * per_height, true},
                         {R"("7": "80 nm", "11": "20 nm")", kCircle, 3, -80e-9 * std::sqrt(2.0),
                          80e-9 * std::sqrt(2.0) * per_height, true}}) {
    SCOPED_TRACE(one.noll);
    Study study = study_of(one.noll, "", one.shape);
    const std::optional<Warning> said = image_shift_warning(study);
    ASSERT_TRUE(said.has_value());
    EXPECT_EQ(said->code, "image-off-axis");
    EXPECT_NEAR(length_before(said->message, "from the nominal focus") / one.shift, 1, 5e-3) << said->message;
    EXPECT_NEAR(length_before(said->message, fmt::format("to Noll {}", one.axis)) / one.tilt, 1, 5e-3)
        << said->message;
    // The core of coma lies at the focus, its centroid in the tail; the core of a tilt lies at the centroid.
    const double about_focus = length_before(said->message, "about the focus"),
                 about_centroid = length_before(said->message, "about the centroid");
    EXPECT_GT(one.coma ? about_centroid : about_focus, 1.01 * (one.coma ? about_focus : about_centroid))
        << said->message;
    study.mirror.zernike.push_back({zernike_from_noll(one.axis), one.tilt});
    EXPECT_FALSE(image_shift_warning(study).has_value());
  }
}

TEST(ImageShift, IsNotSaidOfWhatStaysOnTheAxis) {
  for (const char* noll : {R"("6": "150 nm")", R"("11": "100 nm")", R"("10": "120 nm")", R"("2": "1 nm")"})
    EXPECT_FALSE(image_shift_warning(study_of(noll)).has_value()) << noll;
  EXPECT_FALSE(image_shift_warning(
                   study_of(R"("2": "200 nm")", R"(, "trace": {"model": "rays", "centre": "centroid"})"))
                   .has_value())
      << "statistics about the centroid";
}

TEST(ImageShift, IsAmongTheWarningsOfWhatACommandLaysOut) {
  const auto has = [](const Warnings& warnings) {
    return std::count_if(warnings.begin(), warnings.end(),
                         [](const Warning& one) { return one.code == "image-off-axis"; });
  };
  const Study study = study_of(R"("2": "200 nm")", R"(, "target": {"statistics": {"ee50": {}}},
      "solve": {"for": ["/roughness/psd/rms"], "so_that": {"rms_height": "<= 3 nm"}})");
  EXPECT_EQ(has(lay_groundwork(study).use.warnings), 1);
  EXPECT_EQ(has(run_check(study, {}).warnings), 1);
  EXPECT_EQ(has(run_solve(study, {}).warnings), 1);
}

}  // namespace
}  // namespace aberfit
