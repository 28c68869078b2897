#pragma once
#include <string>

#include "aberfit/study/read_study.h"

namespace aberfit {

/// Parameters of the mirror [m].
inline constexpr double kLambda = 632.8e-9, kFocal = 2.8, kDiameter = 0.4;

/// Uniform PSDs of known regime. g = 4 pi sigma/lambda = 0.5: waves. g = 3.97 with a spot of 2.8 and of 12
/// Airy ee90: rays err by percents. g = 40: rays are accurate.
inline const char* const kSmooth =
    R"({"model": "uniform", "rms": "25.18 nm", "f_min": "2.5 /m", "f_max": "19.96 /m"})";
inline const char* const kShallow =
    R"({"model": "uniform", "rms": "200 nm", "f_min": "1 /m", "f_max": "3 /m"})";
inline const char* const kRough =
    R"({"model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "13 /m"})";
inline const char* const kSteep =
    R"({"model": "uniform", "rms": "2 um", "f_min": "2.5 /m", "f_max": "13 /m"})";

inline std::string text_of(const std::string& psd, const std::string& target, const std::string& trace = "{}",
                           const std::string& aperture = R"({"shape": "circle", "diameter": "0.4 m"})",
                           const std::string& rest = "", const std::string& conic = "-1") {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m", "conic": )" + conic + R"(},
    "aperture": )" +
         aperture + R"(, "light": {"wavelength": "632.8 nm"}, "roughness": {"psd": )" + psd +
         R"(}, "target": )" + target + R"(, "trace": )" + trace + rest + "}";
}
inline Study study_of(const std::string& psd, const std::string& target = "{}",
                      const std::string& trace = "{}") {
  return parse_study(text_of(psd, target, trace), "study.json");
}

}  // namespace aberfit
