#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace aberfit {

/// A study of a mirror at 632.8 nm, everything automatic, without pictures; lengths in m.
inline nlohmann::json study_of(double focal_length, const nlohmann::json& aperture,
                               const nlohmann::json& psd) {
  return {{"aberfit", 1},
          {"mirror", {{"focal_length", focal_length}}},
          {"aperture", aperture},
          {"light", {{"wavelength", 632.8e-9}}},
          {"roughness", {{"psd", psd}}},
          {"output", {{"pictures", "none"}}}};
}
inline nlohmann::json circle(double diameter) { return {{"shape", "circle"}, {"diameter", diameter}}; }
inline nlohmann::json uniform(double rms, double f_max) {
  return {{"model", "uniform"}, {"rms", rms}, {"f_min", 2.5}, {"f_max", f_max}};
}
inline nlohmann::json k_correlation(double rms, double exponent, double f_max) {
  return {{"model", "k-correlation"}, {"rms", rms}, {"B", 0.06},
          {"exponent", exponent},     {"f_min", 3}, {"f_max", f_max}};
}

/// The study that the README shows.
inline nlohmann::json readme_study() { return study_of(2.8, circle(0.4), uniform(100e-9, 19.96)); }
/// An annulus at f/4 with 80 nm RMS.
inline nlohmann::json annulus_study() {
  return study_of(2, {{"shape", "annulus"}, {"diameter", 0.5}, {"inner_diameter", 0.15}},
                  k_correlation(80e-9, 3.2, 30));
}

/// A round mirror with a uniform band that few Zernikes carry.
inline std::string small_study(const std::string& terms, const std::string& rays) {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
    "light": {"wavelength": "632.8 nm"},
    "roughness": {"psd": {"model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "12 /m"}},
    "target": {"theory": "geometric"}, "output": {"pictures": "none"}, "equivalence": {"margin": "2 %"},
    "terms": )" +
         terms + R"(, "trace": {"rays": )" + rays + "}}";
}

/// Five encircled energies of a band of seven modes, by 25 Zernikes.
inline nlohmann::json few_modes_study() {
  nlohmann::json study = study_of(2.8, circle(0.4), uniform(100e-9, 5));
  study["terms"] = {{"zernike", {{"n_max", 6}}}};
  for (const char* share : {"ee35", "ee50", "ee65", "ee80", "ee90"})
    study["target"]["statistics"][share] = nlohmann::json::object();
  return study;
}

}  // namespace aberfit
