// `aberfit sweep` from the outside: killed and restarted, in shards, or by ranks of mpirun. The records are
// always those of one undisturbed run.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "aberfit/core/random.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;
using test::read_file;
using test::ScratchFolder;

// Each case takes a millisecond or two. f_max is above f_min in some of the cases only, so that the others
// fail.
ordered_json study(int heights, int bands) {
  ordered_json made =
      ordered_json::parse(R"({ "aberfit": 1, "title": "swept", "mirror": { "focal_length": "1 m" },
    "aperture": { "shape": "circle", "diameter": "0.2 m" }, "light": { "wavelength": "500 nm" },
    "roughness": { "psd": { "model": "uniform", "rms": "20 nm", "f_min": "10 /m", "f_max": "40 /m" } },
    "output": { "pictures": "none" } })");
  made["vary"]["over"]["/roughness/psd/rms"] = {
      {"from", "5 nm"}, {"to", "80 nm"}, {"count", heights}, {"spacing", "log"}};
  made["vary"]["over"]["/roughness/psd/f_max"] = {{"from", "9 /m"}, {"to", "49 /m"}, {"count", bands}};
  return made;
}

// Records by id, without the time they took. Fails if an id occurs twice.
std::map<std::string, std::string> records_in(const std::string& folder) {
  std::map<std::string, std::string> found;
  for (const auto& entry : fs::directory_iterator(folder + "/cases")) {
    if (entry.path().extension() != ".jsonl") continue;
    std::istringstream lines(read_file(entry.path().string()));
    for (std::string line; std::getline(lines, line);) {
      if (lines.eof()) break;  // cut short
      json record = json::parse(line);
      record.erase("seconds");
      EXPECT_TRUE(found.emplace(record["id"], record.dump()).second) << record["id"] << " twice";
    }
  }
  return found;
}

class SweepCommand : public testing::Test {
 protected:
  void SetUp() override {
    // Removes what a batch system that started the tests has set.
    for (const char* name : {"SLURM_ARRAY_TASK_ID", "SGE_TASK_ID", "PBS_ARRAY_INDEX", "OMPI_COMM_WORLD_SIZE"})
      unsetenv(name);
  }
  int run(const std::string& arguments) const { return test::run_program(folder_, arguments); }
  std::string out() const { return read_file(folder_.file("stdout.txt")); }
  std::string err() const { return read_file(folder_.file("stderr.txt")); }
  // Starts a command by the shell, in the folder; the program is $ABERFIT.
  pid_t start(const std::string& command) const {
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child != 0) return child;
    setsid();  // so that mpirun's ranks can be told from the tests
    setenv("ABERFIT", ABERFIT_PROGRAM, 1);
    if (chdir(folder_.file("").c_str()) != 0) _exit(99);
    for (const int stream : {1, 2})
      if (!freopen("/dev/null", "w", stream == 1 ? stdout : stderr)) _exit(99);
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
    _exit(99);
  }
  static int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::size_t recorded(const std::string& out) const {
    std::size_t count = 0;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder_.file(out + "/cases"), none)) {
      if (entry.path().extension() != ".jsonl") continue;
      const std::string text = read_file(entry.path().string());
      count += std::size_t(std::count(text.begin(), text.end(), '\n'));
    }
    return count;
  }
  // Waits for `count` records, or for the end of the process.
  void wait_for_records(const std::string& out, std::size_t count, pid_t child) const {
    while (recorded(out) < count && waitid(P_PID, id_t(child), nullptr, WEXITED | WNOHANG | WNOWAIT) == 0) {
      siginfo_t info{};
      waitid(P_PID, id_t(child), &info, WEXITED | WNOHANG | WNOWAIT);
      if (info.si_pid == child) return;
      usleep(2000);
    }
  }
  // Runs the same sweep undisturbed, killed `kills` times, as shards, and by ranks of which one is killed.
  void whole(int heights, int bands) {
    folder_.write("study.json", study(heights, bands).dump());
    const int code = run("sweep study.json -o whole --quiet");
    EXPECT_EQ(code, 1) << err();  // some failed
    whole_ = records_in(folder_.file("whole"));
    EXPECT_EQ(whole_.size(), std::size_t(heights * bands));
    table_ = table_of("whole");
  }
  // Returns cases.csv without the times.
  std::string table_of(const std::string& out) const {
    std::istringstream lines(read_file(folder_.file(out + "/cases.csv")));
    std::string text;
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> cells;
      std::istringstream parts(line);
      for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
      for (std::size_t k = 0; k < std::min<std::size_t>(cells.size(), 10); ++k) text += cells[k] + ",";
      text += "\n";
    }
    return text;
  }
  void killed(int kills) {
    const RandomStream stream(5, "sweep-kills");
    for (int k = 0; k < kills; ++k) {
      const std::size_t before = recorded("killed");
      const pid_t child =
          start("\"$ABERFIT\" sweep study.json -o killed --threads " + std::to_string(1 + k % 2));
      // This is the fraction of the remaining records. A fast machine writes some more between the check and
      // the kill.
      const double share = 1.3 * stream.uniform(std::uint64_t(k)) / (kills - k + 1);
      wait_for_records("killed", before + std::size_t(share * double(whole_.size() - before)), child);
      kill(child, SIGKILL);
      EXPECT_EQ(wait_for(child), -1) << "killed too late to mean anything, " << k;
    }
    EXPECT_EQ(run("sweep study.json -o killed --quiet"), 1) << err();
    EXPECT_EQ(records_in(folder_.file("killed")), whole_);
    EXPECT_EQ(table_of("killed"), table_);
  }
  void sharded(int shards) {
    std::vector<pid_t> children;
    for (int k = 1; k <= shards; ++k)
      children.push_back(
          start(fmt::format("\"$ABERFIT\" sweep study.json -o shards --threads 1 --shard {}/{}", k, shards)));
    // Each shard ends with the exit code of all records so far; an early one may have seen no failed case.
    int most = 0;
    for (const pid_t child : children) {
      const int code = wait_for(child);
      EXPECT_TRUE(code == 0 || code == 1) << code;
      most = std::max(most, code);
    }
    EXPECT_EQ(most, 1);
    EXPECT_EQ(records_in(folder_.file("shards")), whole_);
    EXPECT_EQ(table_of("shards"), table_) << "the last to end gathers all";
  }
  static bool has_mpi() {
    const fs::path module = fs::path(ABERFIT_PROGRAM).parent_path() / "aberfit_mpi.so";
    return fs::exists(module) && std::system("command -v mpirun > /dev/null") == 0;
  }
  static std::string mpirun(int ranks) {
    return fmt::format(
        "env OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n {} "
        "\"$ABERFIT\" "
        "sweep study.json -o ranks --quiet",
        ranks);
  }
  // The processes of this program whose parent is `parent`.
  static std::vector<pid_t> ranks_of(pid_t parent) {
    std::vector<pid_t> ranks;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      const std::string name = entry.path().filename().string();
      if (name.find_first_not_of("0123456789") != std::string::npos) continue;
      std::istringstream stat(read_file(entry.path().string() + "/stat"));
      std::string id, program, state;
      pid_t of = 0;
      if (stat >> id >> program >> state >> of && of == parent && program == "(aberfit)")
        ranks.push_back(pid_t(std::stol(id)));
    }
    return ranks;
  }
  void by_ranks() {
    const pid_t child = start(mpirun(3));
    wait_for_records("ranks", whole_.size() / 5, child);
    const std::vector<pid_t> ranks = ranks_of(child);
    ASSERT_EQ(ranks.size(), 3u);
    kill(ranks[1], SIGKILL);
    EXPECT_NE(wait_for(child), 0);
    const std::size_t then = recorded("ranks");
    EXPECT_LT(then, whole_.size());
    EXPECT_GE(then, whole_.size() / 5);
    EXPECT_EQ(wait_for(start(mpirun(2))), 1);
    EXPECT_EQ(records_in(folder_.file("ranks")), whole_);
    EXPECT_EQ(table_of("ranks"), table_);
    // At least two ranks have worked.
    int workers = 0;
    for (const auto& entry : fs::directory_iterator(folder_.file("ranks/cases")))
      workers += entry.path().extension() == ".jsonl" && fs::file_size(entry.path()) > 0;
    EXPECT_GE(workers, 2);
  }

  const ScratchFolder folder_;
  std::map<std::string, std::string> whole_;
  std::string table_;
};

TEST_F(SweepCommand, KilledAndStartedAgainGivesTheSame) {
  whole(12, 10);
  killed(3);
}

TEST_F(SweepCommand, InShardsGivesTheSame) {
  whole(8, 6);
  sharded(3);
}

// mpirun takes seconds to kill a rank, so that test is among the long ones.
TEST_F(SweepCommand, ByRanksGivesTheSame) {
  if (!has_mpi()) GTEST_SKIP() << "no mpirun, or built without Open MPI";
  whole(12, 10);
  EXPECT_EQ(wait_for(start(mpirun(2))), 1);
  EXPECT_EQ(records_in(folder_.file("ranks")), whole_);
  EXPECT_EQ(table_of("ranks"), table_);
}

// Sweeps of 2,000 cases; run with `ctest -C stability -L stability`.
using SweepLong = SweepCommand;
TEST_F(SweepLong, KilledTwentyTimesGivesTheSame) {
  whole(50, 40);
  killed(20);
}
TEST_F(SweepLong, InFourShardsGivesTheSame) {
  whole(50, 40);
  sharded(4);
}
TEST_F(SweepLong, ByRanksOfWhichOneIsKilledGivesTheSame) {
  if (!has_mpi()) GTEST_SKIP() << "no mpirun, or built without Open MPI";
  whole(50, 40);
  by_ranks();
}

TEST_F(SweepCommand, SaysWhatCheckSaysOfEachCase) {
  ordered_json one = study(2, 2);
  one["target"]["statistics"] = {{"ee50", ordered_json::object()}, {"ee80", ordered_json::object()}};
  one["mirror"]["conic"] = -1;
  // Cases share data of a pupil. Each of these changes needs a pupil of its own.
  const std::vector<std::pair<std::string, json>> varied = {{"/light/wavelength", {"0.4 um", "1 um"}},
                                                            {"/mirror/focal_length", {"0.5 m", "1 m"}},
                                                            {"/mirror/conic", {-1, -0.99}},
                                                            {"/aperture/diameter", {"0.2 m", "0.1 m"}}};
  for (const auto& [pointer, values] : varied) {
    one["vary"]["over"] = {{"/roughness/psd/rms", {"30 nm"}}, {pointer, values}};
    folder_.write("study.json", one.dump());
    const std::string folder = "swept" + pointer.substr(pointer.rfind('/') + 1);
    EXPECT_EQ(run("sweep study.json --json --quiet --threads 1 -o " + folder), 0) << err();
    EXPECT_EQ(json::parse(out())["kind"], "sweep");
    EXPECT_EQ(out(), read_file(folder_.file(folder + "/result.json")));
    const auto records = records_in(folder_.file(folder));
    ASSERT_EQ(records.size(), 2u);
    for (const auto& [id, text] : records) {
      const json record = json::parse(text), value = record["at"][pointer];
      EXPECT_EQ(
          run(fmt::format("check study.json --json --quiet --set '/roughness/psd/rms=30 nm' --set '{}={}'",
                          pointer, value.is_string() ? std::string(value) : value.dump())),
          0)
          << err();
      const json check = json::parse(out());
      for (const char* name : {"ee50_radius_m", "ee80_radius_m"})
        EXPECT_NEAR(double(record["values"][name]) / double(check["target"][name]["value"]), 1, 1e-12)
            << pointer << " " << name;
      EXPECT_NEAR(double(record["values"]["scene_g"]) / double(check["scene"]["g"]), 1, 1e-12);
    }
  }
}

TEST_F(SweepCommand, OfDrawnMirrorsHasQuantiles) {
  ordered_json drawn = study(2, 2);
  drawn["terms"] = {{"zernike", {{"n_max", 6}}}};
  drawn["target"] = {{"theory", "geometric"}, {"statistics", {{"ee80", ordered_json::object()}}}};
  drawn["trace"]["rays"] = 1000;
  drawn["vary"] = {
      {"over", {{"/roughness/psd/rms", {"20 nm", "40 nm"}}}}, {"realisations", 4}, {"run", "trace"}};
  folder_.write("study.json", drawn.dump());
  EXPECT_EQ(run("sweep study.json -o out --quiet"), 0) << err();
  std::istringstream table(read_file(folder_.file("out/quantiles.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(
      line,
      "/roughness/psd/rms,statistic,count,mean,standard_deviation,smallest,q05,q25,q50,q75,q95,largest");
  std::getline(table, line);
  EXPECT_EQ(line.find("20 nm,ee80_radius_m,4,"), 0u) << line;
  // The seed of a case is the one that `trace` uses.
  EXPECT_EQ(run("trace study.json --json --quiet --set '/fit/seed=3'"), 0) << err();
  const json trace = json::parse(out());
  for (const auto& [id, text] : records_in(folder_.file("out"))) {
    const json record = json::parse(text);
    if (record["at"]["/fit/seed"] != 3 || record["at"]["/roughness/psd/rms"] != "20 nm") continue;
    const std::string shown = trace.dump();
    EXPECT_NE(shown.find(record["values"]["ee80_radius_m"].dump()), std::string::npos) << shown;
  }
}

TEST_F(SweepCommand, OfFitsHasVerdicts) {
  ordered_json fits = study(2, 2);
  fits["terms"] = {{"zernike", {{"n_max", 8}}}};
  fits["target"] = {{"theory", "geometric"}, {"statistics", {{"ee50", ordered_json::object()}}}};
  fits["trace"]["rays"] = 2048;
  fits["vary"] = {{"over", {{"/roughness/psd/rms", {"100 nm", "200 nm"}}}}, {"run", "fit"}};
  folder_.write("study.json", fits.dump());
  EXPECT_EQ(run("sweep study.json -o out --quiet"), 0) << err();
  EXPECT_EQ(run("fit study.json --json --quiet -o one --set '/roughness/psd/rms=200 nm'") & ~1, 0) << err();
  const json fit = json::parse(out());
  for (const auto& [id, text] : records_in(folder_.file("out"))) {
    const json record = json::parse(text);
    EXPECT_EQ(record["status"], "done");
    if (record["at"]["/roughness/psd/rms"] != "200 nm") continue;
    EXPECT_EQ(record["verdict"], fit["equivalence"]["verdict"]);
  }
}

TEST_F(SweepCommand, OfSolvesHasWhatIsAllowed) {
  ordered_json solves = study(2, 2);
  solves["solve"] = {{"for", {"/roughness/psd/rms"}}, {"so_that", {{"ee80_diameter", "<= 20 um"}}}};
  solves["vary"] = {{"over", {{"/light/wavelength", {"500 nm"}}}}, {"run", "solve"}};
  folder_.write("study.json", solves.dump());
  EXPECT_EQ(run("sweep study.json -o out --quiet"), 0) << err();
  EXPECT_EQ(run("solve study.json --json --quiet -o one"), 0) << err();
  const json solved = json::parse(out())["solutions"][0]["at"]["/roughness/psd/rms"];
  const auto records = records_in(folder_.file("out"));
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(json::parse(records.begin()->second)["values"]["solved_rms_m"], solved);
}

// If budgets are on their limits except for rounding, there are no contours to draw.
TEST_F(SweepCommand, OfEqualValuesEnds) {
  ordered_json solves = study(2, 2);
  solves["output"]["pictures"] = "auto";
  solves["solve"] = {{"for", {"/roughness/psd/rms"}}, {"so_that", {{"rms_height@1/m-30/m", "<= 5 nm"}}}};
  solves["vary"] = {{"over",
                     {{"/roughness/psd/f_min", {{"from", "2 /m"}, {"to", "9 /m"}, {"count", 3}}},
                      {"/roughness/psd/f_max", {{"from", "31 /m"}, {"to", "61 /m"}, {"count", 3}}}}},
                    {"run", "solve"}};
  folder_.write("study.json", solves.dump());
  EXPECT_EQ(run("sweep study.json -o out --quiet"), 0) << err();
  const std::string table = read_file(folder_.file("out/cases.csv"));
  EXPECT_NE(table.find(",rms_height_m@1/m-30/m,"), std::string::npos) << table;
  // A case that only `solve` itself rejects is a failed case.
  solves["solve"] = {{"ceilings", ordered_json::object()}, {"so_that", {{"strehl", ">= 0.8"}}}};
  folder_.write("ceilings.json", solves.dump());
  EXPECT_EQ(run("sweep ceilings.json -o none --quiet"), 1) << err();
  EXPECT_NE(read_file(folder_.file("none/cases.csv")).find("ceilings work only with"), std::string::npos);
}

TEST_F(SweepCommand, TellsBadInputAndTriesFailedCasesAgain) {
  folder_.write("study.json", study(3, 4).dump());
  EXPECT_EQ(run("sweep study.json -o out --shard 5/4"), 2);
  EXPECT_NE(err().find("--shard"), std::string::npos) << err();
  EXPECT_EQ(run("sweep study.json -o out --set '/vary/over={\"/roughness/psd/rns\": [1, 2]}'"), 2);
  EXPECT_NE(err().find("rns"), std::string::npos) << err();
  EXPECT_EQ(run("sweep study.json -o out --set /vary={}"), 2);
  EXPECT_EQ(run("sweep study.json -o out --shard 1/2 --quiet"), 1);
  EXPECT_EQ(out().find("NOT COMPLETE: 6 of 12 cases"), 0u) << out();
  EXPECT_EQ(run("sweep study.json -o out --gather --quiet"), 1);
  EXPECT_EQ(out().find("NOT COMPLETE: 6 of 12 cases"), 0u) << out();
  EXPECT_EQ(run("sweep study.json -o out --quiet"), 1);
  EXPECT_EQ(out().find("SWEPT: 12 of 12 cases, 3 failed"), 0u) << out();
  const std::size_t before = recorded("out");
  EXPECT_EQ(run("sweep study.json -o out --quiet --retry"), 1);
  EXPECT_EQ(recorded("out"), before + 3);
  // A line that is no record gives a message, and its case is computed again.
  folder_.write("out/cases/worker-0001.jsonl",
                read_file(folder_.file("out/cases/worker-0001.jsonl")) + "oops\n");
  EXPECT_EQ(run("sweep study.json -o out --json --quiet"), 1);
  EXPECT_EQ(json::parse(out())["warnings"][0]["code"], "damaged-records");
}

// A smaller version of fits/telescope-sweep.
TEST_F(SweepCommand, TheExampleHasTablesAndPictures) {
  EXPECT_EQ(
      run("sweep '" ABERFIT_SOURCE_DIR "/fits/telescope-sweep/study.json' -o out --quiet "
          "--set '/vary/over/~1roughness~1psd~1rms/count=4' --set '/vary/over/~1roughness~1psd~1B/count=3'"),
      0)
      << err();
  EXPECT_EQ(out().find("SWEPT: 12 of 12 cases\n"), 0u) << out();
  for (const char* name : {"curve_ee80_radius.gp", "map_ee50_radius.gp", "contour_ee80_radius.gp"})
    EXPECT_TRUE(fs::exists(folder_.file(std::string("out/plots/") + name))) << name;
}

TEST_F(SweepCommand, StoppedByASignalGoesOnLater) {
  folder_.write("study.json", study(40, 40).dump());
  const pid_t child = start("\"$ABERFIT\" sweep study.json -o out");
  wait_for_records("out", 5, child);
  kill(child, SIGTERM);
  EXPECT_EQ(wait_for(child), 4);
  EXPECT_GE(recorded("out"), 5u);
  EXPECT_LT(recorded("out"), 1600u);
  EXPECT_TRUE(fs::exists(folder_.file("out/cases.csv")));
}

}  // namespace
}  // namespace aberfit
