// The random-scene matrix: runs rows of it, each once, and says what they come to.
//   stability_matrix --rows FILE [--anew] [--seed N] [--range FIRST LAST | --only K,K,...] [--picture
//   FILE.svg]
//                    [--report | --sound] [--show K] [--targets]
// Rows that FILE has are not run again, so that the matrix can be run in parts, and by several at once with a
// file each; after a change of the program --anew takes none of them. --report: exit code 1 unless every
// promise is kept by the rows that were asked for; --sound: unless none of them is a failure. --show prints a
// scene's study and its table. --targets runs no program and has targets alone looked at: exit code 1 where
// one is wrong.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "matrix_report.h"
#include "matrix_row.h"
#include "random_scenes.h"

namespace aberfit {
namespace {

using nlohmann::json;

constexpr int kRows = 300;

struct Asked {
  std::string rows, picture;
  std::uint64_t seed = 1;
  std::vector<int> which;
  int show = -1;
  bool anew = false, report = false, sound = false, targets = false;
};

std::vector<int> range(int first, int last) {
  std::vector<int> rows;
  for (int k = first; k < last; ++k) rows.push_back(k);
  return rows;
}

Asked read_arguments(const std::vector<std::string>& arguments) {
  Asked asked;
  asked.which = range(0, kRows);
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& option = arguments[i];
    const auto next = [&]() -> const std::string& {
      if (i + 1 >= arguments.size()) throw std::invalid_argument(option + " needs a value");
      return arguments[++i];
    };
    if (option == "--rows")
      asked.rows = next();
    else if (option == "--picture")
      asked.picture = next();
    else if (option == "--seed")
      asked.seed = std::stoull(next());
    else if (option == "--show")
      asked.show = std::stoi(next());
    else if (option == "--anew")
      asked.anew = true;
    else if (option == "--report")
      asked.report = true;
    else if (option == "--targets")
      asked.targets = true;
    else if (option == "--sound")
      asked.sound = true;
    else if (option == "--range") {
      const int first = std::stoi(next());
      asked.which = range(first, std::stoi(next()));
    } else if (option == "--only") {
      asked.which.clear();
      std::istringstream list(next());
      for (std::string k; std::getline(list, k, ',');) asked.which.push_back(std::stoi(k));
    } else {
      throw std::invalid_argument("unknown option " + option + "; the head of matrix.cpp has them all");
    }
  }
  if (asked.rows.empty() && asked.show < 0 && !asked.targets)
    throw std::invalid_argument("--rows FILE is required");
  return asked;
}

// Rows of this seed, by number.
std::map<int, json> read_rows(const Asked& asked) {
  std::map<int, json> rows;
  std::ifstream file(asked.rows);
  for (std::string line; std::getline(file, line);) {
    const json row = json::parse(line, nullptr, false);  // the last line of a run that was cut off is none
    if (!row.is_object() || row["seed"] != asked.seed) continue;
    const int k = row["row"];
    if (row["name"] == random_scene(asked.seed, k).name) rows[k] = row;
  }
  return rows;
}

json run_in_scratch(std::uint64_t seed, int k,
                    json (*run)(std::uint64_t, int, const std::filesystem::path&)) {
  std::string name = (std::filesystem::temp_directory_path() / "aberfit-matrix-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
  json row = run(seed, k, name);
  std::filesystem::remove_all(name);
  return row;
}

void run_missing(const Asked& asked, std::map<int, json>* rows) {
  for (const int k : asked.which) {
    if (rows->count(k) > 0) continue;
    json row = run_in_scratch(asked.seed, k, run_row);
    std::ofstream(asked.rows, std::ios::app) << row.dump() << '\n';
    fmt::print("{:>4} {:<78} {:<11} {:6.1f} s {}\n", k, row["name"].get<std::string>(),
               row["outcome"].get<std::string>(), row.value("fit_s", 0.0), failure_of(row));
    std::fflush(stdout);
    (*rows)[k] = std::move(row);
  }
}

int look_at_targets(const Asked& asked) {
  bool right = true;
  for (const int k : asked.which) {
    const json row = run_in_scratch(asked.seed, k, opinion_on_targets), &second = row["second_of_targets"];
    const std::string failure = failure_of(row);
    right &= failure.empty();
    fmt::print("{:>4} {:<78} {} {}\n", k, row["name"].get<std::string>(), second.dump(), failure);
    std::fflush(stdout);
  }
  return right ? 0 : 1;
}

int run(const Asked& asked) {
  if (asked.show >= 0) {
    const RandomScene scene = random_scene(asked.seed, asked.show);
    fmt::print("{}\n", json::parse(scene.study).dump(1));
    if (!scene.table.empty()) fmt::print("{}:\n{}", kRandomTable, scene.table);
    return 0;
  }
  if (asked.targets) return look_at_targets(asked);
  if (asked.anew) std::filesystem::remove(asked.rows);
  std::map<int, json> known = read_rows(asked);
  run_missing(asked, &known);
  std::vector<json> rows;
  for (const int k : asked.which) rows.push_back(known.at(k));
  const MatrixReport report = report_on(rows);
  if (asked.report || asked.sound) fmt::print("\n{}", report.text);
  if (!asked.picture.empty() && !draw_shares(rows, asked.picture)) fmt::print("no picture: gnuplot failed\n");
  return (asked.report && !report.promised) || (asked.sound && !report.sound) ? 1 : 0;
}

}  // namespace
}  // namespace aberfit

int main(int argc, char** argv) {
  try {
    return aberfit::run(aberfit::read_arguments({argv + 1, argv + argc}));
  } catch (const std::exception& error) {
    fmt::print(stderr, "stability_matrix: {}\n", error.what());
    return 2;
  }
}
