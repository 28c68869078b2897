// Whole runs of the program, from the study file to result.json, without pictures.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmark_case.h"

namespace aberfit::benchmarks {
namespace {

namespace fs = std::filesystem;

nlohmann::json read_json(const fs::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("no file " + path.string());
  return nlohmann::json::parse(file);
}

/// A temporary folder, removed with the object.
struct ScratchFolder {
  fs::path path;
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "aberfit-benchmark-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no scratch folder");
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
};

void add_study(const std::string& name) {
  const fs::path study = fs::path(ABERFIT_SOURCE_DIR) / "fits" / name / "study.json";
  add_case("Study from the command line/fits/" + name, [=]() -> Timed {
    return [=](benchmark::State& state) {
      const ScratchFolder folder;
      const std::string command =
          fmt::format("'{}' fit '{}' --pictures none --quiet -o '{}' > '{}'", ABERFIT_PROGRAM, study.string(),
                      folder.path.string(), (folder.path / "log").string());
      int code = 0;
      time_alone(state, [&] { code = std::system(command.c_str()); });
      if (code != 0) throw std::runtime_error(fmt::format("{} failed with {}", command, code));
      // Errors are on fresh rays, of fitted and held-out statistics.
      const nlohmann::json result = read_json(folder.path / "result.json");
      double worst = 0;
      for (const auto& metric : result.at("equivalence").at("metrics"))
        worst = std::max(worst, std::abs(metric.at("relative_difference").get<double>()));
      const auto& metrics = result.at("equivalence").at("metrics");
      report_error(state, metrics.empty() ? std::nan("") : worst, metrics.at(0).at("margin").get<double>());
      report_rate(state, "studies", 1);
    };
  });
}

}  // namespace

void register_cases(bool smoke) {
  add_study("paper-physical");
  if (!smoke) add_study("paper-harvey-shack");
}

}  // namespace aberfit::benchmarks
