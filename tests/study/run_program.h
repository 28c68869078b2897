#pragma once
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "report/valid_result.h"
#include "sanitized.h"
#include "scratch_folder.h"

namespace aberfit::test {

/// Runs the program in `folder`; returns its exit code, its output in the files stdout.txt and stderr.txt
/// there.
inline int run_program(const ScratchFolder& folder, const std::string& arguments) {
  const std::string command =
      "cd '" + folder.file("") + "' && '" ABERFIT_PROGRAM "' " + arguments + " > stdout.txt 2> stderr.txt";
  const int status = std::system(command.c_str());
  // Whatever a test prints as JSON is as the schema of results has it.
  const auto printed =
      nlohmann::ordered_json::parse(std::ifstream(folder.file("stdout.txt")), nullptr, false);
  if (printed.is_object() && printed.contains("kind") && printed.contains("aberfit"))
    expect_valid_result(printed);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// A budget of time, as an argument, for what the release build does in so many seconds.
inline std::string in_seconds(int of_release) {
  return " --seconds " + std::to_string((kSanitized ? 10 : 1) * of_release) + " ";
}

}  // namespace aberfit::test
