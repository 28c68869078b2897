// Changes of a study before it is read (`--set`) must give the same study as the changed text.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "aberfit/core/errors.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/read_study.h"
#include "study_texts.h"

namespace aberfit {
namespace {

using test::changed;

using Changes = std::vector<std::string>;

nlohmann::ordered_json resolved_with(const Changes& changes, const char* text = test::kMinimalStudy) {
  return resolved_study(parse_study(text, "study.json", changes));
}

nlohmann::ordered_json resolved_text(const std::string& text) {
  return resolved_study(parse_study(text, "study.json"));
}

std::string refusal(const Changes& changes, const char* text = test::kMinimalStudy) {
  try {
    parse_study(text, "study.json", changes);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing refused";
}

TEST(StudyChanges, AreTheStudyWithItsTextChanged) {
  const std::string rms = "/roughness/psd/rms";
  EXPECT_EQ(resolved_with({rms + "=60 nm"}), resolved_text(changed(rms, "\"60 nm\"")));
  EXPECT_EQ(resolved_with({rms + "=6e-8"}), resolved_text(changed(rms, "6e-8")));
  EXPECT_EQ(resolved_with({rms + "=\"60 nm\""}), resolved_text(changed(rms, "\"60 nm\"")));
  EXPECT_EQ(resolved_with({"/title=a=b, c"})["title"], "a=b, c") << "the first = separates";
  EXPECT_NE(resolved_with({rms + "=60 nm"}), resolved_with({}));
}

TEST(StudyChanges, MakeWhatThePointerLeadsThrough) {
  EXPECT_EQ(resolved_with({"/target/statistics/ee80/tolerance=1 %"}),
            resolved_text(changed("/target", R"({"statistics": {"ee80": {"tolerance": "1 %"}}})")));
  EXPECT_EQ(resolved_with({R"(/target={"statistics": {"ee80": {}}})"}),
            resolved_text(changed("/target", R"({"statistics": {"ee80": {}}})")));
}

TEST(StudyChanges, ComeOneAfterTheOther) {
  const std::string planes = "/target/statistics/ee50/planes";
  const nlohmann::ordered_json study = resolved_with(
      {planes + "=[0]", planes + "/-=1 mm", planes + "/2=2 mm", planes + "/0=-1 mm", "/title=a", "/title=b"});
  EXPECT_EQ(study["target"]["statistics"]["ee50"]["planes"], (std::vector<double>{-1e-3, 1e-3, 2e-3}));
  EXPECT_EQ(study["title"], "b");
}

TEST(StudyChanges, EscapedKeysAreThoseOfThePointer) {
  const std::string said = refusal({"/a~1b~0c=1"});
  EXPECT_NE(said.find("unknown key \"a/b~c\""), std::string::npos) << said;
}

TEST(StudyChanges, WhatIsWrongWithOneNamesTheOption) {
  const struct {
    Changes changes;
    std::vector<std::string> said;
  } cases[] = {
      {{"/roughness/psd/rms=-3 nm"}, {"--set \"/roughness/psd/rms=-3 nm\": /roughness/psd/rms", "above 0"}},
      {{"/roughness/psd/rms=60"}, {"study.json with --set \"/roughness/psd/rms=60\""}},
      // The band ends below its beginning, so the error names the other key.
      {{"/roughness/psd/f_min=50 /m"}, {"--set \"/roughness/psd/f_min=50 /m\"", "/roughness/psd/f_max"}},
      {{"/rufness=1"}, {"--set \"/rufness=1\"", "unknown key"}},
      {{"/roughness/psd/rms"}, {"command line", "no value"}},
      {{"roughness/psd/rms=1"}, {"command line", "not a JSON pointer"}},
      {{"=1"}, {"not a JSON pointer"}},
      {{"/a~b=1"}, {"a ~ alone"}},
      {{"/aberfit/version=1"}, {"1 at /aberfit, which has no keys", "--set \"/aberfit={}\""}},
      {{"/target/statistics/ee50/planes=[0]", "/target/statistics/ee50/planes/2=1"},
       {"an index from 0 to 1"}},
      {{R"(/target={"theory": "ghs", "theory": "ghs"})"}, {"key \"theory\" twice", "--set"}},
  };
  for (const auto& one : cases)
    for (const std::string& part : one.said) {
      const std::string said = refusal(one.changes);
      EXPECT_NE(said.find(part), std::string::npos) << one.changes.back() << ":\n" << said;
    }
}

TEST(StudyChanges, AreNotBlamedForWhatTheyDidNotChange) {
  const std::string broken = changed("/light/wavelength", "\"-1 nm\"");
  const std::string said = refusal({"/roughness/psd/rms=60 nm"}, broken.c_str());
  EXPECT_NE(said.find("/light/wavelength"), std::string::npos) << said;
  EXPECT_EQ(said.find("--set"), std::string::npos) << said;
}

TEST(StudyChanges, AreNamedByWhatIsFoundLater) {
  const Study study = parse_study(test::kMinimalStudy, "study.json", {"/target/theory=ghs"});
  const InputError error = input_error(study, {"target.theory", "it", "another"});
  EXPECT_EQ(error.file(), "study.json with --set \"/target/theory=ghs\"");
}

}  // namespace
}  // namespace aberfit
