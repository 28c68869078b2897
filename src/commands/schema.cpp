#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "aberfit/commands/program.h"
#include "aberfit/study/read_study.h"

namespace aberfit {

ExitCode schema_command() {
  fmt::print("{}\n", study_schema().dump(2));
  return ExitCode::kDone;
}

}  // namespace aberfit
