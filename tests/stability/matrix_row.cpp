#include "matrix_row.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "aberfit/report/result.h"
#include "aberfit/study/read_study.h"
#include "random_scenes.h"
#include "sweep/independent_verdict.h"

namespace aberfit {
namespace {

using nlohmann::json;

// Other work on the machine slows the clock time, but not beyond this factor of the processor time.
constexpr double kPatience = 8;
// Memory of an ordinary machine. The program must say so if it needs more.
constexpr rlim_t kMemory = rlim_t(8) << 30;
// A second opinion may cost no more than most fits. A grid of 512 points across takes 0.07 GB.
constexpr OpinionLimits kOpinion{.largest_grid = 512, .seconds = 15, .most_planes = 3, .most_rings = 1};
// A second opinion on targets needs no surface, and a finer grid is closer to the truth.
constexpr OpinionLimits kOpinionOfTargets{
    .smallest_grid = 512, .largest_grid = 1024, .seconds = 30, .most_planes = 5, .most_rings = 1, .field = 4};
// In margins. Targets should be within 1e-4 of the energy, which is a fiftieth of a margin.
constexpr double kTargetsMayBeOff = 0.1;
// A surface with the height of its specification has it within the spread of realisations. Beyond this factor
// nobody would take it for the same mirror.
constexpr double kAbsurd = 2;
constexpr double kNearlyAll = 0.99;  // of the slope variance: the terms can carry the band

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

struct Ended {
  int exit = -1;          // -1: not by itself
  std::string violently;  // "crash", "time-out", "hang"; empty: by itself
  double seconds = 0;     // of the processor
  std::string out, error;
};

[[noreturn]] void become(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  const rlimit seconds{rlim_t(kLongestFit), rlim_t(kLongestFit) + 5}, no_core{0, 0}, memory{kMemory, kMemory};
  setrlimit(RLIMIT_CPU, &seconds);
  if (!test::kSanitized) setrlimit(RLIMIT_AS, &memory);  // sanitizers map terabytes that they never touch
  setrlimit(RLIMIT_CORE, &no_core);
  const int out = open((folder / "out.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644),
            error = open((folder / "error.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(out, STDOUT_FILENO);
  dup2(error, STDERR_FILENO);
  std::vector<char*> raw;
  for (const std::string& argument : arguments) raw.push_back(const_cast<char*>(argument.c_str()));
  raw.push_back(nullptr);
  if (chdir(folder.c_str()) == 0) execv(raw[0], raw.data());
  _exit(127);
}

Ended run(std::vector<std::string> arguments, const std::filesystem::path& folder) {
  arguments.insert(arguments.begin(), ABERFIT_PROGRAM);
  const pid_t child = fork();
  if (child == 0) become(arguments, folder);
  const auto begin = std::chrono::steady_clock::now();
  Ended ended;
  int status = 0;
  rusage used{};
  while (wait4(child, &status, WNOHANG, &used) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (std::chrono::steady_clock::now() - begin < std::chrono::duration<double>(kPatience * kLongestFit))
      continue;
    kill(child, SIGKILL);
    ended.violently = "hang";
    wait4(child, &status, 0, &used);
    break;
  }
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  ended.seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
  if (WIFEXITED(status)) ended.exit = WEXITSTATUS(status);
  if (WIFSIGNALED(status) && ended.violently.empty())
    ended.violently = WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL ? "time-out" : "crash";
  ended.out = text_of(folder / "out.txt");
  ended.error = text_of(folder / "error.txt");
  return ended;
}

// Returns whether a message says what to do about it, by its words.
bool has_remedy(const std::string& message) {
  for (const char* word : {"allowed:", "; give", ". Give", "take", "Take", " use ", ". Use", "Try", "request",
                           "instead", "fewer", "a larger margin", "would help"})
    if (message.find(word) != std::string::npos) return true;
  return false;
}

// Records a command that ended before it had a result.
bool note_end(const char* command, const Ended& ended, json* row) {
  if (ended.violently.empty() && ended.exit <= 1) return false;
  const std::string line = ended.error.substr(0, ended.error.find('\n'));
  (*row)["outcome"] = ended.violently.empty() ? "refused" : ended.violently;
  (*row)["exit"] = ended.exit;
  (*row)["message"] = fmt::format("{}: {}", command, line);
  (*row)["remedy"] = has_remedy(line);
  return true;
}

json codes(const json& warnings) {
  json list = json::array();
  for (const json& warning : warnings) list.push_back(warning["code"]);
  return list;
}

double number(const json& value) { return value.is_number() ? value.get<double>() : std::nan(""); }

// Uses the metrics on which the verdict rests: those by waves if there are any.
void note_mismatch(const json& equivalence, json* row) {
  const json& light = equivalence.value("light", json::object());
  const bool lights = light.value("decides", false) && light.contains("metrics") && !light["metrics"].empty();
  double worst = 0;
  for (const json& metric : lights ? light["metrics"] : equivalence["metrics"]) {
    const double off = std::abs(number(metric["difference"])) / number(metric["margin"]);
    if (off <= worst) continue;
    worst = off;
    (*row)["statistic"] = metric["name"];
  }
  (*row)["mismatch"] = worst;
}

void note_surface(const json& result, json* row) {
  const json& scene = result["scene"];
  double height = 0, slope = 0;
  if (result["fit"].contains("equivalent_surface")) {
    height = number(result["fit"]["equivalent_surface"]["rms_height_m"]);
    slope = number(result["fit"]["equivalent_surface"]["rms_slope_per_axis"]);
  }
  if (result.contains("split") && result["split"].contains("scatter")) {
    const json& rest = result["split"]["scatter"];
    height = std::hypot(height, number(rest["rms_height_m"]));
    slope = std::hypot(slope, number(rest["rms_slope_per_axis"]));
  }
  (*row)["rms_ratio"] = height / number(scene["rms_height_m"]);
  (*row)["slope_ratio"] = slope / number(scene["rms_slope_per_axis"]);
  // A split leaves the roughness that no term has to carry to scatter.
  const bool split = result.contains("split");
  (*row)["carried"] = split ? 1 : 1 - number(scene["band"]["left_out_slope_share"]);
}

json noted(const SecondOpinion& opinion, const char* of) {
  if (!opinion.obstacle.empty()) return {{"of", of}, {"obstacle", opinion.obstacle}};
  return {{"of", of}, {"margins", opinion.worst}, {"statistic", opinion.statistic}, {"rings", opinion.rings}};
}

// If targets give no second opinion, that of the verdict counts.
json on_targets(const SecondOpinions& opinions) {
  try {
    return noted(opinions.of_targets(kOpinionOfTargets), "waves");
  } catch (const std::exception& error) {
    return {{"obstacle", error.what()}};
  }
}

void note_second_opinion(const json& result, const std::filesystem::path& folder, json* row) {
  const Study study = read_study((folder / "study.json").string());
  TermSet terms;
  Eigen::VectorXd coefficients;
  if (result["fit"]["terms"].get<int>() > 0)
    coefficients = read_coefficients_csv((folder / "out" / "coefficients.csv").string(), &terms);
  else
    terms.radius = aperture_radius(study.aperture);
  const bool rays = result["scene"]["model"] == "rays";
  std::optional<double> cut;
  if (result.contains("split")) cut = number(result["split"]["cut_per_m"]);
  const SecondOpinions opinions(study);
  SecondOpinion opinion;
  if (rays && cut)
    opinion.obstacle = "rays with a scatter of their own";
  else
    opinion = rays ? opinions.of_rays(terms, coefficients, kOpinion)
                   : opinions.of_waves(terms, coefficients, cut, kOpinion);
  (*row)["second"] = noted(opinion, rays ? "rays" : "waves");
  (*row)["second_of_targets"] = on_targets(opinions);
}

// Records where the search of a fit went, and when, to explain a wrong prediction.
void note_search(const json& fit, json* row) {
  if (!fit.contains("frontier")) return;
  json& search = (*row)["search"] = json::array();
  for (const json& point : fit["frontier"]["points"])
    search.push_back({{"order", point["order"]},
                      {"mismatch", point["fitted_mismatch_tolerances"]},
                      {"held_out", point["held_out_mismatch"]},
                      {"passes", point["passes"]},
                      {"s", point["seconds"]}});
}

void note_result(const Ended& fit, const std::filesystem::path& folder, json* row) {
  const json result = json::parse(text_of(folder / "out" / "result.json"));
  (*row)["exit"] = fit.exit;
  (*row)["outcome"] = result["equivalence"]["verdict"];
  (*row)["status"] = result["fit"]["status"];
  (*row)["terms"] = result["fit"]["terms"];
  (*row)["cells"] = result["fit"]["pupil_points"];
  (*row)["model"] = result["scene"]["model"];
  (*row)["theory"] = result["scene"]["theory"];
  (*row)["warnings"] = codes(result["warnings"]);
  std::string says = fit.out.substr(0, fit.out.find("\n-----"));
  std::replace(says.begin(), says.end(), '\n', ' ');
  (*row)["says"] = says;
  if (result["fit"].contains("message")) (*row)["fit_says"] = result["fit"]["message"];
  note_mismatch(result["equivalence"], row);
  note_surface(result, row);
  note_search(result["fit"], row);
  try {
    note_second_opinion(result, folder, row);
  } catch (const std::exception& error) {
    (*row)["second"] = {{"obstacle", error.what()}};
  }
}

}  // namespace

json opinion_on_targets(std::uint64_t seed, int k, const std::filesystem::path& folder) {
  const RandomScene scene = random_scene(seed, k);
  if (!scene.table.empty()) std::ofstream(folder / kRandomTable) << scene.table;
  json row{{"seed", seed}, {"row", k}, {"name", scene.name}};
  try {
    const SecondOpinions opinions(parse_study(scene.study, (folder / "study.json").string()));
    row["second_of_targets"] = on_targets(opinions);
  } catch (const std::exception& error) {
    row["second_of_targets"] = {{"obstacle", error.what()}};
  }
  return row;
}

json run_row(std::uint64_t seed, int k, const std::filesystem::path& folder) {
  const RandomScene scene = random_scene(seed, k);
  std::ofstream(folder / "study.json") << scene.study;
  if (!scene.table.empty()) std::ofstream(folder / kRandomTable) << scene.table;
  json row{
      {"seed", seed}, {"row", k}, {"name", scene.name}, {"classes", scene.classes}, {"open", scene.all_open}};
  const Ended check = run({"check", "study.json", "--json", "--quiet", "--threads", "1"}, folder);
  row["check_s"] = check.seconds;
  if (note_end("check", check, &row)) return row;
  const json report = json::parse(check.out);
  if (report.contains("cost")) row["iteration_s"] = report["cost"]["iteration_seconds"];
  row["checked_terms"] = report["terms"]["count"];
  row["warnings"] = codes(report["warnings"]);
  const Ended fit =
      run({"fit", "study.json", "--quiet", "--pictures", "none", "--threads", "1", "-o", "out"}, folder);
  row["fit_s"] = fit.seconds;
  if (note_end("fit", fit, &row)) return row;
  try {
    note_result(fit, folder, &row);
  } catch (const std::exception& error) {  // a file that is not there, or not what it should be
    row["outcome"] = "crash";
    row["message"] = error.what();
    return row;
  }
  row["remedy"] = has_remedy(row["says"]);
  return row;
}

std::string failure_of(const json& row) {
  const std::string outcome = row.value("outcome", "");
  const json targets = row.value("second_of_targets", json::object());
  if (targets.contains("margins") && !(number(targets["margins"]) <= kTargetsMayBeOff))
    return "wrong targets";
  if (outcome == "crash" || outcome == "hang" || outcome == "time-out") return outcome;
  if (outcome == "refused" && !row.value("remedy", false)) return "refused without a remedy";
  if (outcome != "equivalent") return "";
  const json second = row.value("second", json::object());
  // A NaN has become null.
  if (second.contains("margins") && !(number(second["margins"]) <= 1))
    return "contradicted by " + second["of"].get<std::string>();
  if (number(row["carried"]) < kNearlyAll) return "";
  for (const char* ratio : {"rms_ratio", "slope_ratio"})
    if (const double off = number(row[ratio]); !(off < kAbsurd && off > 1 / kAbsurd)) return "absurd surface";
  return "";
}

}  // namespace aberfit
