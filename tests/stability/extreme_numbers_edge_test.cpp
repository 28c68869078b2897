// Takes every number of a study, one after the other, to where double precision or the optics end. The
// program must predict or refuse; it must not crash, hang or return a NaN.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using nlohmann::json;

constexpr double kLongest = 30;  // [s]; alone each is below 10

// Together the studies have every number that a prediction uses.
std::map<std::string, json> studies() {
  const json plain = json::parse(R"({"aberfit": 1, "mirror": {"focal_length": 1.4},
      "aperture": {"shape": "circle", "diameter": 0.2}, "light": {"wavelength": 632.8e-9},
      "roughness": {"psd": {"model": "uniform", "rms": 60e-9, "f_min": 5, "f_max": 20}}})");
  std::map<std::string, json> all{{"plain", plain}};
  json aspheric = plain;
  aspheric["mirror"] =
      json::parse(R"({"focal_length": 1.4, "conic": -1.01, "spherical": {"c4": 1e-6, "c12": 1e-3}})");
  aspheric["target"]["statistics"]["ee50"] = {{"planes", {0.0, 1e-4}}, {"tolerance", 1e-3}};
  all["aspheric"] = aspheric;
  json astigmatic = plain;  // wave optics of a sphere with it takes half a minute
  astigmatic["mirror"]["zernike"] = {{"radius", 0.1}, {"noll", {{"5", 20e-9}}}};
  astigmatic["target"]["statistics"]["ee80"] = {{"planes", {0.0}}};
  all["astigmatic"] = astigmatic;
  json annulus = plain;
  annulus["aperture"] = {{"shape", "annulus"}, {"diameter", 0.2}, {"inner_diameter", 0.06}, {"margin", 1e-3}};
  annulus["roughness"]["psd"] = {{"model", "k-correlation"}, {"rms", 20e-9}, {"B", 0.05},
                                 {"exponent", 2.6},          {"f_min", 5},   {"f_max", 200}};
  all["annulus"] = annulus;
  json rectangle = plain;
  rectangle["aperture"] = {{"shape", "rectangle"}, {"width", 0.2}, {"height", 0.1}};
  rectangle["roughness"]["psd"] = {{"model", "gaussian"}, {"rms", 20e-9}, {"correlation_length", 0.02}};
  all["rectangle"] = rectangle;
  json polygon = plain;
  polygon["aperture"] = {{"shape", "polygon"}, {"vertices", {{0.1, 0.0}, {-0.05, 0.08}, {-0.05, -0.08}}}};
  polygon["roughness"]["psd"] = {
      {"model", "power-law"}, {"amplitude", 1e-16}, {"exponent", 2.5}, {"f_min", 5}, {"f_max", 200}};
  all["polygon"] = polygon;
  json given = plain;
  given.erase("roughness");
  given["terms"]["zernike"]["n_max"] = 6;
  given["fit"]["prior"] = "zero-mean";
  given["target"]["statistics"] = {{"ee50", {{"value", 10e-6}, {"tolerance", 1e-3}, {"planes", {0.0}}}},
                                   {"scatter_rms", {{"value", 5e-6}}}};
  all["given"] = given;
  return all;
}

std::vector<json::json_pointer> numbers(const json& study) {
  std::vector<json::json_pointer> found;
  const json flat = study.flatten();
  for (const auto& [pointer, value] : flat.items())
    if (value.is_number() && pointer != "/aberfit") found.emplace_back(pointer);
  return found;
}

struct Answer {
  bool refused = false;
  std::string text;
  double seconds = 0;
  int without_value = 0;
};
Answer ask(const std::string& text) {
  Answer answer;
  const auto begin = std::chrono::steady_clock::now();
  try {
    const Study study = parse_study(text, "study.json");
    const Groundwork ground = lay_groundwork(study);
    const TargetSets targets = make_targets(study, ground, 2);
    for (const Target& target : all_targets(targets))
      if (!(std::isfinite(target.value) && target.value >= 0 && std::isfinite(target.tolerance)))
        ++answer.without_value;
  } catch (const InputError& error) {
    answer = {true, error.what()};
  } catch (const FieldError& error) {
    answer = {true, error.what()};
  } catch (const ComputationError& error) {
    answer = {true, error.what()};
  }
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return answer;
}

void sweep(const std::vector<double>& values) {
  for (const auto& [name, study] : studies()) {
    const Answer plain = ask(study.dump());
    ASSERT_FALSE(plain.refused) << name << ": " << plain.text;
    for (const json::json_pointer& pointer : numbers(study))
      for (const double value : values) {
        json changed = study;
        changed[pointer] = value;
        const Answer answer = ask(changed.dump());
        EXPECT_LT(answer.seconds, kLongest) << name << ' ' << pointer << ' ' << value;
        EXPECT_EQ(answer.without_value, 0) << name << ' ' << pointer << ' ' << value;
        EXPECT_TRUE(!answer.refused || answer.text.size() > 30) << name << ' ' << pointer << ' ' << value;
      }
  }
}

TEST(ExtremeNumbers, AreTakenOrRefused) { sweep({1e300, -1e300}); }

TEST(ExtremeNumbersLong, AreTakenOrRefusedAtEveryScale) {
  std::vector<double> values{0, -1, 1e308, 2.3e-308, 5e-324};
  for (int power = -250; power <= 250; power += power > -30 && power < 30 ? 2 : 20)
    values.push_back(std::pow(10.0, power));
  sweep(values);
}

TEST(ExtremeNumbers, ThatAreNoneAreRefused) {
  for (const char* wrong : {"1e999", "-1e999", "NaN", "Infinity", "nan"}) {
    std::string text = studies()["plain"].dump();
    text.replace(text.find("1.4"), 3, wrong);
    EXPECT_TRUE(ask(text).refused) << wrong;
  }
}

}  // namespace
}  // namespace aberfit
