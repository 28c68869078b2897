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
  // JSON that a test prints must follow the schema of results.
  const auto printed =
      nlohmann::ordered_json::parse(std::ifstream(folder.file("stdout.txt")), nullptr, false);
  if (printed.is_object() && printed.contains("kind") && printed.contains("aberfit"))
    expect_valid_result(printed);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// A time limit as an argument: seconds of the release build, more for slower builds.
inline std::string in_seconds(int of_release) {
  return " --seconds " + std::to_string((kSanitized ? 10 : 1) * of_release) + " ";
}

}  // namespace aberfit::test
