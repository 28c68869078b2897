#include "aberfit/commands/serve.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "aberfit/commands/answer.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

const char* const kStudy = R"({"aberfit": 1, "mirror": {"focal_length": 2}, "light": {"wavelength": 1e-6},
  "aperture": {"shape": "circle", "diameter": 0.2},
  "roughness": {"psd": {"model": "uniform", "rms": 3e-8, "f_min": 6, "f_max": 30}},
  "target": {"statistics": {"ee80": {}, "strehl": {}}}, "terms": {"zernike": {"n_max": 10}},
  "solve": {"for": ["/roughness/psd/rms"], "so_that": {"strehl": ">= 0.8"}}})";

std::vector<ordered_json> answers_to(const std::string& lines) {
  std::istringstream in(lines);
  std::ostringstream out;
  serve(in, out, 2);
  std::istringstream text(out.str());
  std::vector<ordered_json> answers;
  for (std::string line; std::getline(text, line);) answers.push_back(ordered_json::parse(line));
  return answers;
}

std::string on_one_line(const std::string& text) { return ordered_json::parse(text).dump(); }

std::string request(int id, const std::string& method) {
  return R"({"id": )" + std::to_string(id) + R"(, "method": ")" + method + R"(", "study": )" +
         on_one_line(kStudy) + "}\n";
}

// The answer to a request that is no progress.
ordered_json last_of(const std::vector<ordered_json>& answers, int id) {
  ordered_json last;
  for (const ordered_json& answer : answers)
    if (answer["id"] == id && !answer.contains("progress")) last = answer;
  return last;
}

TEST(Serve, GivesTheResultsOfTheCommandsInTheirOrder) {
  const auto answers = answers_to(request(1, "check") + "\n" + request(2, "solve") + request(3, "fit"));
  const Study study = parse_study(on_one_line(kStudy), "request");
  for (const auto& [id, command] : {std::pair{2, StudyCommand::kSolve}, {3, StudyCommand::kFit}}) {
    ordered_json theirs = last_of(answers, id), ours = answer(command, study, {}).document();
    ASSERT_TRUE(theirs.contains("result")) << theirs;
    for (const char* key : {"solutions", "coefficients", "headline"})
      EXPECT_EQ(theirs["result"].value(key, ordered_json()), ours.value(key, ordered_json())) << key;
  }
  EXPECT_EQ(last_of(answers, 3)["exit_code"], int(answer(StudyCommand::kFit, study, {}).code));
  EXPECT_NE(last_of(answers, 3)["text"].get<std::string>().find("ee80_radius"), std::string::npos);
  std::vector<int> order;
  for (const ordered_json& answer : answers)
    if (answer.contains("result")) order.push_back(answer["id"]);
  EXPECT_EQ(order, (std::vector{1, 2, 3}));
}

TEST(Serve, SaysWhatIsWrongAndGoesOn) {
  const auto answers = answers_to(
      "not json\n[1]\n"
      R"({"id": "a", "method": "fot"})"
      "\n"
      R"({"id": "b", "method": "fit"})"
      "\n"
      R"({"id": "c", "method": "check", "study": {"aberfit": 1, "mirrors": {}}})"
      "\n"
      R"({"id": "d", "method": "schema"})"
      "\n"
      R"({"id": "e", "method": "cancel", "of": 77})"
      "\n"
      R"({"id": "i", "method": "schema", "of": "nonsense"})"
      "\n");
  const auto both = answers_to(R"({"id": 1, "method": "check", "study": {}, "file": "study.json"})");
  EXPECT_EQ(both.at(0)["error"]["pointer"], "/file");
  const auto twice = answers_to(R"({"id": 1, "method": "check", "method": "fit"})");
  ASSERT_EQ(twice.size(), 1u);
  EXPECT_EQ(twice[0]["error"]["pointer"], "/method");
  std::string deep = R"({"id": "f", "method": "check", "study": )";
  for (int k = 0; k < 100000; ++k) deep += R"({"a":)";
  deep += "1" + std::string(100001, '}') + "\n";
  EXPECT_EQ(answers_to(deep + R"({"id": "g", "method": "cancel"})" + "\n" +
                       R"({"id": "h", "method": "check", "bogus": 1})" + "\n")
                .size(),
            3u);
  ASSERT_EQ(answers.size(), 8u);
  std::map<std::string, ordered_json> by_id;
  int nameless = 0;
  for (const ordered_json& answer : answers)
    if (answer["id"].is_null())
      ++nameless;
    else
      by_id[answer["id"]] = answer;
  EXPECT_EQ(nameless, 2);
  EXPECT_EQ(by_id["a"]["error"]["pointer"], "/method");
  EXPECT_EQ(by_id["b"]["error"]["pointer"], "/study");
  EXPECT_EQ(by_id["c"]["error"]["kind"], "input");
  EXPECT_EQ(by_id["c"]["error"]["pointer"], "/mirrors");
  EXPECT_TRUE(by_id["d"]["result"].contains("$defs"));
  EXPECT_EQ(by_id["e"]["result"]["cancelled"], false);
  EXPECT_EQ(by_id["i"]["error"]["pointer"], "/of");
}

// The second request is cancelled while the first runs, and never begins.
TEST(Serve, CancelsWhatWaitsAndWhatRuns) {
  const auto answers =
      answers_to(request(1, "fit") + request(2, "fit") + "{\"id\": 3, \"method\": \"cancel\", \"of\": 2}\n");
  EXPECT_EQ(last_of(answers, 3)["result"]["cancelled"], true);
  const ordered_json second = last_of(answers, 2);
  ASSERT_TRUE(second.contains("error")) << second;
  EXPECT_EQ(second["error"]["kind"], "cancelled");
  EXPECT_TRUE(last_of(answers, 1).contains("result"));
}

}  // namespace
}  // namespace aberfit
