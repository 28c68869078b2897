#include "aberfit/method/pupil_choice.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/constants.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

Study study_of(const std::string& rms, const std::string& target = "{}", const std::string& margin = "1 %") {
  return parse_study(fmt::format(R"({{"aberfit": 1, "mirror": {{"focal_length": "2.8 m"}},
        "aperture": {{"shape": "circle", "diameter": "0.4 m"}}, "light": {{"wavelength": "632.8 nm"}},
        "roughness": {{"psd": {{"model": "uniform", "rms": "{}", "f_min": "2.5 /m", "f_max": "13 /m"}}}},
        "target": {}, "terms": {{"band": "all"}}, "equivalence": {{"margin": "{}"}}}})",
                                 rms, target, margin),
                     "study.json");
}

// Single precision needs many grid cells and tolerances well above its rounding.
TEST(SinglePrecision, IsForFitsOnManyCells) {
  const auto fits = [](FocusModel model, Eigen::Index cells, double tolerance) {
    TargetSets targets;
    targets.fitted = {{EncircledEnergyRadius{0.8, 0}, 2e-5, 0, 0.01 * 2e-5},
                      {EncircledEnergyRadius{0.5, 0}, 1e-5, 0, tolerance * 1e-5}};
    return in_single_precision(model, targets, cells);
  };
  EXPECT_TRUE(fits(FocusModel::kWaves, law::kManyCells, 1.01e-4));
  EXPECT_FALSE(fits(FocusModel::kWaves, law::kManyCells - 1, 1.01e-4));
  EXPECT_FALSE(fits(FocusModel::kWaves, law::kManyCells, 0.99e-4));
  EXPECT_FALSE(fits(FocusModel::kRays, law::kManyCells, 1.01e-4));
}

TEST(WavePitch, SaysWhatAsksForAGridThatNoMemoryHolds) {
  const auto why = [](const std::string& text) {
    try {
      run_fit(parse_study(text, "study.json"), {});
    } catch (const ComputationError& error) {
      return std::string(error.what());
    } catch (const InputError& error) {  // for the value outside the plausible range
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string scene = R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": )"
                            R"("circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"}, )";
  const std::string far =
      why(scene + R"("roughness": {"psd": {"model": "uniform", "rms": "25 nm", "f_min": )"
                  R"("2.5 /m", "f_max": "20 /m"}}, "terms": {"band": "all"}, "target": {"statistics": )"
                  R"({"ee50": {"value": "1 m"}}}})");
  EXPECT_NE(far.find("1.5 m from the axis"), std::string::npos) << far;
  const std::string fine =
      why(scene + R"("roughness": {"psd": {"model": "uniform", "rms": "1 nm", "f_min": )"
                  R"("2.5 /m", "f_max": "20 /mm"}}, "terms": {"fourier": {"count": 9}}})");
  EXPECT_NE(fine.find("points across the aperture, more than 16384"), std::string::npos) << fine;
  std::string planes;  // all energy is scatter and needs no field of view
  try {
    wave_pitch(study_of("100 nm"), TermSet{0.2, {}, {}, {}}, {Target{EncircledEnergyRadius{0.5, 1.0}, 1e-3}},
               nullptr);
  } catch (const ComputationError& error) {
    planes = error.what();
  }
  EXPECT_NE(planes.find("16384: planes up to 1 m out of focus need it; take"), std::string::npos) << planes;
}

}  // namespace
}  // namespace aberfit
