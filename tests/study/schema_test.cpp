#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/study/read_study.h"
#include "scratch_folder.h"
#include "study_texts.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::ScratchFolder;

void collect_keys(const ordered_json& study, std::set<std::string>* keys) {
  if (study.is_object()) {
    for (const auto& item : study.items()) {
      keys->insert(item.key());
      collect_keys(item.value(), keys);
    }
  } else if (study.is_array()) {
    for (const auto& item : study) collect_keys(item, keys);
  }
}

// Collects names of properties anywhere in a schema, those of patternProperties by the sample in the
// description.
void collect_properties(const ordered_json& schema, std::set<std::string>* names) {
  if (schema.is_object()) {
    if (schema.contains("properties") && schema["properties"].is_object())
      for (const auto& item : schema["properties"].items()) names->insert(item.key());
    for (const auto& item : schema.items()) collect_properties(item.value(), names);
  } else if (schema.is_array()) {
    for (const auto& item : schema) collect_properties(item, names);
  }
}

void expect_closed_objects(const ordered_json& schema) {
  if (schema.is_object()) {
    if (schema.contains("type") && schema["type"] == "object") {
      EXPECT_EQ(schema["additionalProperties"], false);
    }
    for (const auto& item : schema.items()) expect_closed_objects(item.value());
  } else if (schema.is_array()) {
    for (const auto& item : schema) expect_closed_objects(item);
  }
}

TEST(StudySchema, KnowsEveryKeyThatTheReaderTakes) {
  std::set<std::string> properties;
  collect_properties(study_schema(), &properties);
  std::set<std::string> keys;
  // The list is written by hand, because it is the contract of the format, whatever the code does.
  for (const char* key : {"aberfit",
                          "$schema",
                          "title",
                          "description",
                          "mirror",
                          "focal_length",
                          "conic",
                          "spherical",
                          "c4",
                          "c6",
                          "c8",
                          "c10",
                          "c12",
                          "radius",
                          "noll",
                          "aperture",
                          "shape",
                          "diameter",
                          "margin",
                          "inner_diameter",
                          "width",
                          "height",
                          "vertices",
                          "light",
                          "wavelength",
                          "roughness",
                          "psd",
                          "model",
                          "rms",
                          "f_min",
                          "f_max",
                          "B",
                          "exponent",
                          "amplitude",
                          "correlation_length",
                          "file",
                          "kind",
                          "frequency_unit",
                          "psd_unit",
                          "of",
                          "scale",
                          "parts",
                          "target",
                          "theory",
                          "convention",
                          "statistics",
                          "planes",
                          "tolerance",
                          "value",
                          "standard_error",
                          "ring",
                          "dz",
                          "values",
                          "bandwidth",
                          "ring_fwhm",
                          "ring_profile",
                          "scatter_rms",
                          "scatter_mean",
                          "spot_fwhm",
                          "rms_radius",
                          "rms_height",
                          "terms",
                          "zernike",
                          "n_min",
                          "n_max",
                          "fourier",
                          "count",
                          "sampling",
                          "covariance",
                          "trace",
                          "pupil",
                          "rays",
                          "seed",
                          "normals",
                          "central_difference",
                          "step",
                          "centre",
                          "fit",
                          "start",
                          "prior",
                          "max_iterations",
                          "starts",
                          "spherical_rms",
                          "bound_sigmas",
                          "equivalence",
                          "confidence",
                          "output",
                          "pictures",
                          "export",
                          "export_grid",
                          "arrays",
                          "format",
                          "column",
                          "columns",
                          "first_row",
                          "hdu",
                          "plane",
                          "bands",
                          "profile_psd",
                          "A",
                          "f_unit",
                          "of",
                          "x_unit",
                          "value_unit",
                          "pitch",
                          "scale",
                          "mask",
                          "invalid",
                          "erode",
                          "length",
                          "outliers",
                          "further",
                          "detrend",
                          "degree",
                          "window",
                          "bins_per_decade",
                          "find_lines",
                          "family",
                          "map",
                          "origin",
                          "held_out",
                          "psd",
                          "method",
                          "verify",
                          "draws"})
    keys.insert(key);
  collect_keys(ordered_json::parse(test::kFullStudy), &keys);
  for (const std::string& key : keys) {
    const bool energy = key.starts_with("ee") || key.starts_with("ring_fwhm@");    // patternProperties
    const bool number = key.find_first_not_of("0123456789") == std::string::npos;  // by Noll's index
    EXPECT_TRUE(energy || number || properties.contains(key)) << key;
  }
}

TEST(StudySchema, IsClosedAndNamesItsDraftAndRequiredBlocks) {
  const ordered_json schema = study_schema();
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema["required"], (std::vector<std::string>{"aberfit", "mirror", "aperture", "light"}));
  expect_closed_objects(schema);
}

TEST(StudySchema, DocumentsUnitsAndDefaults) {
  const ordered_json schema = study_schema();
  const ordered_json& wavelength = schema["properties"]["light"]["properties"]["wavelength"];
  EXPECT_NE(wavelength["description"].get<std::string>().find("nm, um, mm"), std::string::npos);
  EXPECT_EQ(wavelength["examples"], ordered_json({"632.8 nm"}));
  EXPECT_FALSE(wavelength.contains("default"));
  EXPECT_EQ(schema["properties"]["trace"]["properties"]["rays"]["default"], "auto");
  EXPECT_EQ(schema["properties"]["equivalence"]["properties"]["margin"]["default"], 0.01);
}

// Each example in the schema is put into a study and read, if one key is enough.
TEST(StudySchema, GivesExamplesThatTheReaderTakes) {
  const ordered_json schema = study_schema();
  int tried = 0;
  for (const char* block : {"mirror", "light", "target", "terms", "equivalence"}) {
    const ordered_json& described = schema["properties"][block];
    const ordered_json& object =
        described.contains("oneOf") ? described["oneOf"][1] : described;  // or a word
    for (const auto& item : object["properties"].items()) {
      if (!item.value().contains("examples")) continue;
      const std::string pointer = std::string("/") + block + "/" + item.key();
      SCOPED_TRACE(pointer);
      EXPECT_NO_THROW(parse_study(test::changed(pointer, item.value()["examples"][0].dump()), "study.json"));
      ++tried;
    }
  }
  EXPECT_GE(tried, 5);
}

// The validator is Python's jsonschema module (Debian python3-jsonschema), written by others.
class SchemaValidator : public ::testing::Test {
 protected:
  static bool available() {
    static const bool found = std::system("/usr/bin/python3 -c 'import jsonschema' > /dev/null 2>&1") == 0;
    return found;
  }
  // Names of the studies that validate.
  std::set<std::string> valid(const std::vector<std::pair<std::string, std::string>>& studies) {
    folder_.write("schema.json", study_schema().dump());
    ordered_json list = ordered_json::object();
    for (const auto& [name, text] : studies) list[name] = ordered_json::parse(text);
    folder_.write("studies.json", list.dump());
    const std::string script = folder_.write("validate.py",
                                             "import json, sys, jsonschema\n"
                                             "schema = json.load(open(sys.argv[1]))\n"
                                             "jsonschema.Draft202012Validator.check_schema(schema)\n"
                                             "validator = jsonschema.Draft202012Validator(schema)\n"
                                             "for name, study in json.load(open(sys.argv[2])).items():\n"
                                             "    if validator.is_valid(study): print(name)\n");
    const std::string command = "/usr/bin/python3 '" + script + "' '" + folder_.file("schema.json") + "' '" +
                                folder_.file("studies.json") + "' > '" + folder_.file("valid.txt") + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    std::set<std::string> names;
    std::ifstream lines(folder_.file("valid.txt"));
    for (std::string line; std::getline(lines, line);) names.insert(line);
    return names;
  }

 private:
  ScratchFolder folder_;
};

TEST_F(SchemaValidator, AgreesWithTheReader) {
  std::vector<std::pair<std::string, std::string>> studies = {
      {"minimal", test::kMinimalStudy},
      {"full", test::kFullStudy},
      {"resolved minimal", resolved_study(parse_study(test::kMinimalStudy, "study.json")).dump()},
      {"resolved full", resolved_study(parse_study(test::kFullStudy, "study.json")).dump()},
      {"k-correlation",
       test::with_psd(R"({"model": "k-correlation", "rms": "9 nm", "B": "5 mm", "exponent": 5})")},
      {"power-law",
       test::with_psd(R"({"model": "power-law", "rms": "9 nm", "exponent": 5, "f_min": "1 cycles/m"})")},
      {"line of a drawing", test::with_psd(R"({"model": "power-law", "f_min": "0.1 /mm", "f_max": "1 /um",
                          "profile_psd": {"A": "0.02 nm^2 mm", "f_unit": "1/mm", "B": 2}})")},
      {"sum", test::with_psd(R"({"model": "sum", "parts": [{"model": "gaussian", "rms": "9 nm",
                                 "correlation_length": ".5 cm"}]})")},
      {"table",
       test::with_psd(R"({"model": "table", "file": "psd.csv", "kind": "1d", "psd_unit": "nm^2 mm"})")},
      {"annulus",
       test::changed("/aperture", R"({"shape": "annulus", "diameter": "4e-1 m", "inner_diameter": 0.1})")},
      {"clear aperture of a map",
       test::changed(
           "/target",
           R"({"map": {"file": "map.csv", "invalid": [0, -9999], "erode": 2, "outliers": "reject", "aperture":
                                   {"shape": "annulus", "diameter": "95 %", "inner_diameter": 0.01, "centre": [0, "1 mm"]}}})")},
      {"polygon",
       test::changed("/aperture", R"({"shape": "polygon", "vertices": [[0, 0], ["1 m", 0], [0, 1]]})")},
  };
  std::set<std::string> good;
  for (const auto& study : studies) good.insert(study.first);
  std::set<std::string> bad;
  for (const test::MalformedStudy& study : test::malformed_studies()) {
    if (!study.against_schema) continue;
    bad.insert(study.name);
    studies.emplace_back(study.name, study.text);
  }
  EXPECT_GE(bad.size(), 40u);
  // The validator is optional. Without it only the count above is checked.
  if (!available()) return;
  EXPECT_EQ(valid(studies), good);
}

}  // namespace
}  // namespace aberfit
