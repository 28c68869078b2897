#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"
#include "aberfit/commands/terminal_text.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "explain_schema.h"

namespace aberfit {

ExitCode schema_command(CommandLine line) {
  const std::string kResults = "results";
  std::string key = line.schema_key;
  nlohmann::ordered_json schema;
  if (key == kResults || key.starts_with(kResults + "/")) {
    key = key.size() > kResults.size() ? key.substr(kResults.size() + 1) : "";
    schema = results_schema();
    if (!key.empty()) {
      nlohmann::ordered_json kinds = nlohmann::ordered_json::object();
      for (const auto& one : schema["oneOf"]) kinds[one["title"].get<std::string>()] = one;
      schema = {{"type", "object"}, {"properties", kinds}};
    }
  } else {
    schema = study_schema();
  }
  fmt::print("{}\n", key.empty() ? schema.dump(2) : internal::explained_key(schema, key, text_width()));
  return ExitCode::kDone;
}

}  // namespace aberfit
