// The program is killed, or runs out of disk space, at random moments. A folder of results must hold those of
// one run.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "aberfit/core/random.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::read_file;
using test::ScratchFolder;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// One of the two runs that take turns in a folder.
struct Turn {
  std::vector<std::string> arguments;      // without the folder
  std::map<std::string, std::string> own;  // by name: files that another run writes otherwise
  std::string title;                       // of the study; it stands in every file of `titled`
  std::vector<std::string> titled;
  std::set<std::string> names;
  double seconds = 0;
};

// room: bytes that a file may have, as on a disk that fills up; negative: no limit.
pid_t start(const Turn& run, const std::string& folder, long room = -1) {
  std::fflush(nullptr);  // not twice
  const pid_t child = fork();
  if (child != 0) return child;
  std::vector<std::string> arguments{ABERFIT_PROGRAM};
  arguments.insert(arguments.end(), run.arguments.begin(), run.arguments.end());
  arguments.insert(arguments.end(), {"-o", folder});
  std::vector<char*> pointers;
  for (std::string& one : arguments) pointers.push_back(one.data());
  pointers.push_back(nullptr);
  for (const int stream : {1, 2})
    if (!freopen("/dev/null", "w", stream == 1 ? stdout : stderr)) _exit(99);
  if (room >= 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{rlim_t(room), rlim_t(room)};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  execv(ABERFIT_PROGRAM, pointers.data());
  _exit(99);
}
int wait_for(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::set<std::string> visible(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with('.'))
      names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

// Makes an undisturbed run to learn which files it leaves.
void learn(Turn* run, const std::string& folder, const std::vector<std::string>& own) {
  const auto begin = Clock::now();
  const int code = wait_for(start(*run, folder));
  ASSERT_TRUE(code == 0 || code == 1) << code;
  run->seconds = since(begin);
  run->names = visible(folder);
  for (const std::string& name : own) run->own[name] = read_file(folder + "/" + name);
  for (const auto& [name, text] : run->own) ASSERT_FALSE(text.empty()) << name;
}

bool is_of(const Turn& run, const std::string& folder) {
  if (visible(folder) != run.names) return false;
  for (const auto& [name, text] : run.own)
    if (read_file(folder + "/" + name) != text) return false;
  for (const std::string& name : run.titled)
    if (json::parse(read_file(folder + "/" + name))["study"].value("title", "") != run.title) return false;
  return true;
}

void expect_one_runs(const Turn& first, const Turn& second, const std::string& folder) {
  EXPECT_TRUE(is_of(first, folder) != is_of(second, folder)) << testing::PrintToString(visible(folder));
}

// Kills and full disks in turn, on both runs in turn.
void torment(const std::string& what, Turn first, Turn second, const std::vector<std::string>& own,
             int times) {
  const ScratchFolder scratch;
  learn(&first, scratch.file("first"), own);
  learn(&second, scratch.file("second"), own);
  if (testing::Test::HasFatalFailure()) return;
  const std::string folder = scratch.file("out");
  int killed = 0, full = 0;
  wait_for(start(first, folder));
  const RandomStream stream(17, what);
  for (int k = 0; k < times; ++k) {
    const Turn& run = k % 2 ? first : second;
    const double u = double(stream.bits(std::uint64_t(k)) >> 11) * 0x1p-53;
    const pid_t child = start(run, folder);
    usleep(useconds_t(1e6 * run.seconds * (0.3 + 0.9 * u)));
    kill(child, SIGKILL);
    killed += wait_for(child) < 0;
    expect_one_runs(first, second, folder);
    full += wait_for(start(run, folder, long(std::pow(10.0, 6 * u)))) > 1;
    expect_one_runs(first, second, folder);
  }
  std::printf("%s: %d of %d killed, %d of %d with a full disk\n", what.c_str(), killed, times, full, times);
  EXPECT_GT(killed + full, 0);
  EXPECT_LE(wait_for(start(second, folder)), 1);
  EXPECT_TRUE(is_of(second, folder));
  EXPECT_EQ(std::distance(fs::directory_iterator(scratch.file("")), {}), 3) << "something is left beside";
}

std::string study(const std::string& title, int seed, int n_max) {
  return json{{"aberfit", 1},
              {"title", title},
              {"mirror", {{"focal_length", 2.8}}},
              {"aperture", {{"shape", "circle"}, {"diameter", 0.4}}},
              {"light", {{"wavelength", 632.8e-9}}},
              {"roughness", {{"psd", {{"model", "uniform"}, {"rms", 100e-9}, {"f_min", 2.5}, {"f_max", 6}}}}},
              {"target", {{"theory", "geometric"}, {"statistics", {{"ee50", json::object()}}}}},
              {"terms", {{"zernike", {{"n_max", n_max}}}}},
              {"trace", {{"rays", 4096}}},
              {"fit", {{"seed", seed}}},
              {"output", {{"pictures", "none"}}}}
      .dump();
}

std::string profile(double period) {
  std::string text;
  for (int k = 0; k < 400; ++k)
    text += fmt::format("{:.6f} {:.6e}\n", 1e-3 * k,
                        1e-8 * std::sin(6.2831853 * 1e-3 * k / period) + 1e-9 * std::sin(0.7 * k * k));
  return text;
}

class KilledRuns : public testing::Test {
 protected:
  const ScratchFolder inputs;
  Turn run(const std::string& command, const std::string& title, int seed, int n_max,
           const std::vector<std::string>& titled) const {
    return {{command, inputs.write(title + ".json", study(title, seed, n_max))}, {}, title, titled, {}};
  }
  void of_fit(int times) const {
    torment("fit", run("fit", "one", 1, 6, {"result.json"}), run("fit", "two", 2, 8, {"result.json"}),
            {"coefficients.csv"}, times);
  }
  void of_chart(int times) const {
    Turn one = run("chart", "one", 1, 6, {"result.json"}), two = run("chart", "two", 2, 8, {"result.json"});
    for (Turn* each : {&one, &two}) each->arguments.insert(each->arguments.end(), {"--seconds", "0.1"});
    torment("chart", one, two, {}, times);
  }
  void of_psd(int times) const {
    const auto of = [&](const std::string& name, double period) {
      return Turn{{"psd", "--pictures", "none", "--quantity", "height", "--x-unit", "m", "--value-unit", "m",
                   inputs.write(name, profile(period))},
                  {},
                  {},
                  {},
                  {}};
    };
    torment("psd", of("one.txt", 0.02), of("two.txt", 0.03), {"psd.csv", "roughness.json"}, times);
  }
};
TEST_F(KilledRuns, OfFitLeaveOneRunsFolder) { of_fit(3); }
TEST_F(KilledRuns, OfPsdLeaveOneRunsFolder) { of_psd(3); }
using KilledRunsLong = KilledRuns;
TEST_F(KilledRunsLong, OfFitLeaveOneRunsFolder) { of_fit(20); }
TEST_F(KilledRunsLong, OfPsdLeaveOneRunsFolder) { of_psd(20); }
TEST_F(KilledRunsLong, OfChartLeaveOneRunsFolder) { of_chart(20); }

}  // namespace
}  // namespace aberfit
