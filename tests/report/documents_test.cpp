#include "aberfit/report/documents.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "report/sample_result.h"
#include "report/valid_result.h"

using namespace aberfit;
using Json = nlohmann::ordered_json;

namespace {

// Visits the description of every member below `schema`.
void visit_members(const Json& schema, const std::function<void(const std::string&, const Json&)>& see) {
  const Json members = schema.value("properties", Json::object());
  for (const auto& [key, member] : members.items()) {
    see(key, member);
    visit_members(member, see);
  }
  for (const char* inner : {"items", "additionalProperties"})
    if (schema.contains(inner) && schema[inner].is_object()) visit_members(schema[inner], see);
  for (const Json& one : schema.value("anyOf", Json::array())) visit_members(one, see);
}

}  // namespace

TEST(ResultsSchema, HasEveryKindOnce) {
  std::set<std::string> kinds;
  const Json schema = results_schema();
  for (const Json& one : schema["oneOf"])
    EXPECT_TRUE(kinds.insert(one["title"]).second && one["title"] == one["properties"]["kind"]["const"]);
  EXPECT_EQ(kinds, (std::set<std::string>{"fit", "check", "check-of-map", "trace", "verify", "solve",
                                          "ceilings", "psd-of-focus", "sweep", "chart", "psd"}));
}

TEST(ResultsSchema, ExplainsEveryMemberInASentence) {
  const Json schema = results_schema();
  for (const Json& kind : schema["oneOf"])
    visit_members(kind, [](const std::string& key, const Json& member) {
      const std::string meaning = member.value("description", "");
      EXPECT_GT(meaning.size(), 5u) << key;
      EXPECT_TRUE(meaning.ends_with('.') || meaning.ends_with(']')) << key << ": " << meaning;
    });
}

TEST(ResultsSchema, SaysTheUnitThatAKeyEndsIn) {
  const Json schema = results_schema();
  const Json& fit = schema["oneOf"][0]["properties"];
  EXPECT_EQ(fit["fit"]["properties"]["seconds"]["unit"], "s");
  EXPECT_EQ(fit["split"]["properties"]["cut_per_m"]["unit"], "1/m");
  EXPECT_EQ(fit["split"]["properties"]["scatter"]["properties"]["scatter_rms_rad"]["unit"], "rad");
  EXPECT_FALSE(fit["fit"]["properties"]["rank"].contains("unit"));
}

TEST(ResultsSchema, TellsAWrongDocument) {
  Json result = to_json(sample_result(), Json::object());
  test::expect_valid_result(result);
  const Json kind = results_schema()["oneOf"][0];
  Json wrong = result;
  wrong["fit"]["rank"] = "three";
  EXPECT_EQ(test::fault_of(wrong, kind), "/fit/rank is no [\"integer\"]: \"three\"");
  wrong = result;
  wrong["fit"].erase("rank");
  EXPECT_EQ(test::fault_of(wrong, kind), "/fit lacks \"rank\"");
  wrong = result;
  wrong["fit"]["rang"] = 3;
  EXPECT_EQ(test::fault_of(wrong, kind), "/fit/rang is not in the schema");
}
