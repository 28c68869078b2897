// The program from the outside, on studies that take no time: what it writes, prints and returns.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/study/read_study.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

// A study with three statistics of a low-frequency roughness, the Zernikes up to n = 8 and few rays.
// `statistics` and `rest` (further blocks, each with a comma before it) go into the text.
std::string tiny_study(const std::string& statistics, const std::string& rest = "") {
  return R"({
  "aberfit": 1, "title": "tiny",
  "mirror": { "focal_length": "2.8 m" },
  "aperture": { "shape": "circle", "diameter": "0.4 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "200 nm", "f_min": "2.5 /m", "f_max": "6 /m" } },
  "terms": { "zernike": { "n_max": 8 } },
  "trace": { "rays": 4096 }, "verify": { "draws": 16 },
  "target": { "theory": "geometric", "statistics": { )" +
         statistics + " } }" + rest + "\n}\n";
}

// The targets come from theory, so held-out statistics are judged, too. 42 terms do not meet them.
const std::string kFromTheory = tiny_study(R"("ee50": {}, "ee90": {}, "scatter_rms": {})");
// The targets are given as values, so nothing is held out, and three numbers are easily met.
const std::string kFromValues = tiny_study(
    R"("ee50": { "value": "27 um" }, "ee90": { "value": "48 um" }, "scatter_rms": { "value": "11.4 urad" })",
    R"(, "equivalence": { "margin": "5 %" })");

std::set<std::string> entries(const std::string& folder) {
  std::set<std::string> names;
  if (!std::filesystem::exists(folder)) return names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (const std::string name = entry.path().filename().string(); !name.starts_with('.')) names.insert(name);
  return names;
}

ordered_json read_json(const std::string& path) { return ordered_json::parse(read_file(path)); }

// A result without what a second run may change.
ordered_json comparable(ordered_json result) {
  EXPECT_GT(result["fit"]["seconds"], 0.0);
  EXPECT_GE(result["provenance"]["threads"], 1);
  result["fit"].erase("seconds");
  result["provenance"].erase("threads");
  result["provenance"].erase("inputs");  // name and hash of the study
  return result;
}

class ProgramRun : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::filesystem::exists(ABERFIT_PROGRAM)) << "build the program first: " ABERFIT_PROGRAM;
    folder_.write("theory.json", kFromTheory);
    folder_.write("values.json", kFromValues);
  }
  int run(const std::string& arguments) const { return run_program(folder_, arguments); }
  std::string file(const std::string& name) const { return folder_.file(name); }
  std::string out() const { return read_file(file("stdout.txt")); }
  std::string err() const { return read_file(file("stderr.txt")); }
  // The exit code by the result: 0 for a converged fit with an equivalent surface, else 1.
  static int exit_code_of(const ordered_json& result) {
    return result["equivalence"]["verdict"] == "equivalent" ? 0 : 1;
  }

  ScratchFolder folder_;
};

TEST_F(ProgramRun, SaysWhichCommandsThereAre) {
  EXPECT_EQ(run("chek theory.json"), 2);
  EXPECT_NE(err().find("chek"), std::string::npos) << err();
  EXPECT_NE(err().find("check"), std::string::npos) << err();
  EXPECT_EQ(run("schema"), 0);
}

TEST_F(ProgramRun, FitWritesFourFilesAndReturnsItsVerdict) {
  std::set<int> codes;
  for (const char* name : {"theory", "values"}) {
    SCOPED_TRACE(name);
    const std::string results = std::string("results/of/") + name;
    const int code = run(std::string("fit ") + name + ".json --pictures none -o " + results);
    EXPECT_EQ(entries(file(results)),
              (std::set<std::string>{"coefficients.csv", "report.html", "result.json", "summary.txt"}));
    const ordered_json result = read_json(file(results + "/result.json"));
    EXPECT_EQ(result["kind"], "fit");
    EXPECT_EQ(result["fit"]["terms"], 42);
    EXPECT_EQ(result["statistics"]["fitted"].size(), 3u);
    EXPECT_EQ(code, exit_code_of(result));
    codes.insert(code);
    // The terminal shows the same verdict, and the angle.
    std::string verdict = result["equivalence"]["verdict"];
    if (verdict == "equivalent") {
      EXPECT_EQ(out().find("EQUIVALENT"), 0u) << out();
    } else {
      EXPECT_EQ(out().find("EQUIVALENT"), std::string::npos) << out();
    }
    const std::string summary = read_file(file(results + "/summary.txt"));
    const std::size_t at = summary.find("scatter_rms  ");
    ASSERT_NE(at, std::string::npos);
    EXPECT_NE(summary.substr(at, 60).find(" urad"), std::string::npos) << summary.substr(at, 60);
    EXPECT_NE(err().find("results in " + results), std::string::npos) << err();
  }
  EXPECT_EQ(codes, (std::set<int>{0, 1})) << "one of each is what this test is about";
}

TEST_F(ProgramRun, FitDrawsUnlessToldNotTo) {
  run("fit values.json -o drawn");
  EXPECT_TRUE(entries(file("drawn")).contains("plots"));
  EXPECT_TRUE(entries(file("drawn/plots")).contains("ee_curves.gp"));
  run("fit values.json --pictures none -o plain");
  EXPECT_FALSE(entries(file("plain")).contains("plots"));
  folder_.write("unplotted.json", tiny_study(R"("ee90": {})", R"(, "output": { "pictures": "none" })"));
  run("fit unplotted.json -o quiet");
  EXPECT_TRUE(entries(file("quiet")).contains("result.json"));
  EXPECT_FALSE(entries(file("quiet")).contains("plots"));
}

TEST_F(ProgramRun, JsonIsAllThatStandsOnStandardOutput) {
  run("fit values.json --pictures none --json --quiet -o results");
  EXPECT_EQ(ordered_json::parse(out()), read_json(file("results/result.json")));
  EXPECT_EQ(err(), "");
  run("--json verify values.json --pictures none -o verified");  // the option may stand before the command
  EXPECT_EQ(ordered_json::parse(out()), read_json(file("verified/result.json")));
  for (const char* command : {"trace", "check"}) {
    EXPECT_EQ(run(std::string(command) + " values.json --json"), 0);
    EXPECT_EQ(ordered_json::parse(out())["kind"], command);
    EXPECT_EQ(err(), "");
  }
}

TEST_F(ProgramRun, TraceOfTheFittedCoefficientsGivesTheFittedStatistics) {
  run("fit theory.json --pictures none -o results");
  ASSERT_EQ(run("trace theory.json --coefficients results/coefficients.csv --json"), 0) << err();
  const ordered_json traced = ordered_json::parse(out())["statistics"];
  const ordered_json result = read_json(file("results/result.json"));
  const ordered_json& fitted = result["statistics"]["fitted"];
  ASSERT_EQ(fitted.size(), 3u);
  ASSERT_EQ(traced.size(), 3u);
  const double kRelative =
      1e-9;  // coefficients are written to the last bit: what is left is the order of sums
  for (const auto& item : fitted.items()) {
    const double value = item.value();
    EXPECT_NEAR(traced[item.key()].get<double>(), value, kRelative * value) << item.key();
    // The start of the fit is another surface, so the traced one must come from the file.
    EXPECT_GT(std::abs(result["statistics"]["start"][item.key()].get<double>() / value - 1), 1e-4);
  }
  // `verify` uses the same surface.
  run("verify theory.json --coefficients results/coefficients.csv --json --pictures none -o verified");
  const ordered_json verified = ordered_json::parse(out())["statistics"];
  for (const char* name : {"ee50_radius_m", "ee90_radius_m", "scatter_rms_rad"}) {
    const double value = fitted[name];
    EXPECT_NEAR(verified[name]["aberration_terms"].get<double>(), value, kRelative * value) << name;
  }
}

TEST_F(ProgramRun, VerifyReturnsItsVerdictAndTheOthersZero) {
  folder_.write("lenient.json",
                tiny_study(R"("ee90": {})", R"(, "equivalence": { "margin": "50 %", "confidence": 0.55 })"));
  std::set<int> codes;
  for (const char* name : {"theory.json", "lenient.json"}) {
    SCOPED_TRACE(name);
    const int code = run(std::string("verify ") + name + " -o verified");
    EXPECT_EQ(entries(file("verified")),
              (std::set<std::string>{"plots", "report.html", "result.json", "summary.txt"}));
    EXPECT_TRUE(entries(file("verified/plots")).contains("focal_images.gp"));
    EXPECT_EQ(read_file(file("verified/summary.txt")), out());
    run(std::string("verify ") + name + " --pictures none -o plain");
    EXPECT_EQ(entries(file("plain")), (std::set<std::string>{"report.html", "result.json", "summary.txt"}));
    EXPECT_EQ(code, read_json(file("verified/result.json"))["verdict"] == "equivalent" ? 0 : 1);
    codes.insert(code);
  }
  EXPECT_EQ(codes, (std::set<int>{0, 1})) << "one of each is what this test is about";
  const std::set<std::string> before = entries(file(""));
  for (const char* arguments : {"trace theory.json", "check theory.json", "schema"}) {
    EXPECT_EQ(run(arguments), 0) << arguments;
    EXPECT_NE(out(), "") << arguments;
  }
  EXPECT_EQ(entries(file("")), before) << "they print, they do not write";
}

TEST_F(ProgramRun, ResultsDependNeitherOnThreadsNorOnTheRun) {
  run("fit theory.json --pictures none --threads 1 -o one");
  run("fit theory.json --pictures none --threads 2 -o two");
  run("fit theory.json --pictures none --threads 2 -o again");
  const ordered_json one = read_json(file("one/result.json"));
  const ordered_json two = read_json(file("two/result.json"));
  EXPECT_EQ(one["provenance"]["threads"], 1);
  EXPECT_EQ(two["provenance"]["threads"], 2);
  // The comparison is as text, so that every digit counts.
  EXPECT_EQ(comparable(two).dump(1), comparable(one).dump(1));
  EXPECT_EQ(comparable(read_json(file("again/result.json"))).dump(1), comparable(two).dump(1));
  EXPECT_EQ(read_file(file("two/coefficients.csv")), read_file(file("one/coefficients.csv")));
  for (const char* command : {"trace", "verify"}) {
    const std::string rest = std::string(command) + " theory.json --json" +
                             (std::string(command) == "verify" ? " -o verified" : "");
    const auto printed = [&](const std::string& threads) {
      run("--threads " + threads + " " + rest);
      ordered_json result = ordered_json::parse(out());
      EXPECT_EQ(result["provenance"]["threads"], std::stoi(threads));
      result["provenance"].erase("threads");
      return result.dump();
    };
    const std::string first = printed("1");
    EXPECT_EQ(printed("2"), first) << command;
    EXPECT_GT(first.size(), 100u);
  }
}

TEST_F(ProgramRun, TheResolvedStudyOfAResultIsAStudyThatGivesItAgain) {
  run("fit theory.json --pictures none -o first");
  const ordered_json first = read_json(file("first/result.json"));
  folder_.write("resolved.json", first["study"].dump(2));
  EXPECT_EQ(resolved_study(read_study(file("resolved.json"))), first["study"]);
  run("fit resolved.json --pictures none -o second");
  EXPECT_EQ(comparable(read_json(file("second/result.json"))).dump(1), comparable(first).dump(1));
  EXPECT_EQ(read_file(file("second/coefficients.csv")), read_file(file("first/coefficients.csv")));
}

// The exit code is 3 if a study cannot be computed. Here a ring wider than half the mirror holds all energy
// even half-way to the mirror, so its width does not exist. A folder that cannot be written is found before
// that.
TEST_F(ProgramRun, AnUnwritableFolderIsRefusedBeforeAnythingIsComputed) {
  folder_.write("impossible.json", tiny_study(R"("ring_fwhm": { "ring": "0.12 m" })"));
  folder_.write("file", "in the way");
  const std::set<std::string> before = [this] {
    run("fit impossible.json -o new/folder");
    return entries(file(""));
  }();
  EXPECT_EQ(run("fit impossible.json -o new/folder"), 3) << err();
  EXPECT_NE(err().find("ring_fwhm_m"), std::string::npos) << err();
  EXPECT_FALSE(before.contains("new")) << "a run that fails leaves nothing behind";
  for (const char* command : {"fit impossible.json", "fit theory.json", "verify theory.json"}) {
    for (const char* where : {"file", "file/below", "/dev/null/below"}) {
      SCOPED_TRACE(std::string(command) + " -o " + where);
      EXPECT_EQ(run(std::string(command) + " --json -o " + where), 2);
      EXPECT_NE(err().find(where), std::string::npos) << err();
      EXPECT_EQ(out(), "");
    }
  }
  EXPECT_EQ(entries(file("")), before);
  EXPECT_EQ(read_file(file("file")), "in the way");
}

TEST_F(ProgramRun, OutputThatCannotBeWrittenIsNoSuccess) {
  const auto exit_code = [&](const std::string& command) {
    return WEXITSTATUS(std::system(
        fmt::format("{} {} > /dev/full 2> {}", ABERFIT_PROGRAM, command, file("full.err")).c_str()));
  };
  for (const std::string command : {"check ", "check --json ", "trace "}) {
    EXPECT_EQ(exit_code(command + file("theory.json")), 2) << command;
    EXPECT_NE(read_file(file("full.err")).find("standard output"), std::string::npos) << command;
  }
}

// A study with automatic terms that takes seconds.
const char* const kSeconds = R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"},
  "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "632.8 nm"},
  "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "19.96 /m"}},
  "output": {"pictures": "none"}})";

TEST_F(ProgramRun, ASignalEndsAFitWithExitCodeFour) {
  const std::string study = folder_.write("seconds.json", kSeconds), out = file("interrupted");
  const int status =
      std::system(fmt::format("timeout --preserve-status -s INT 1.5 {} fit {} -o {} --json > {} "
                              "2> {}",
                              ABERFIT_PROGRAM, study, out, file("said.json"), file("said.err"))
                      .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 4) << read_file(file("said.err"));
  // A result that could be kept is marked as interrupted; otherwise nothing is written.
  if (std::filesystem::exists(out)) {
    EXPECT_TRUE(read_json(out + "/result.json")["fit"]["interrupted"]);
    EXPECT_EQ(read_file(out + "/summary.txt").find("INTERRUPTED"), 0u);
  } else {
    EXPECT_NE(read_file(file("said.err")).find("nothing is written"), std::string::npos);
  }
}

// `timeout` and batch systems signal first the process and then its group. The second signal must not end the
// fit without a result.
TEST_F(ProgramRun, ASignalThatComesTwiceIsOneWish) {
  const std::string study = folder_.write("seconds.json", kSeconds);
  const int status = std::system(
      fmt::format("{} fit {} -o {} > {} 2>&1 & pid=$!; sleep 0.5; for i in 1 2 3 4 5; do kill -TERM $pid 2> "
                  "/dev/null; sleep 0.002; done; wait $pid",
                  ABERFIT_PROGRAM, study, file("twice"), file("said.txt"))
          .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 4) << read_file(file("said.txt"));
}

// Named terms with so many rays that an iteration takes half a second, and a margin that needs many
// iterations.
TEST_F(ProgramRun, ATimeLimitEndsAFitWithAJudgedResult) {
  std::string text = kSeconds;
  text.insert(text.rfind('}'), R"(, "terms": {"zernike": {"n_max": 20}}, "equivalence": {"margin": "0.1 %"},
      "target": {"theory": "geometric"}, "trace": {"rays": 300000, "model": "rays"})");
  const std::string study = folder_.write("limited.json", text), out = file("limited");
  const int status = std::system(fmt::format("{} fit {} -o {} --json --time-limit 0.5s > {} 2> {}",
                                             ABERFIT_PROGRAM, study, out, file("said.json"), file("said.err"))
                                     .c_str());
  ASSERT_EQ(WEXITSTATUS(status), 4) << read_file(file("said.err"));
  for (const std::string& from : {file("said.json"), out + "/result.json"}) {
    const auto result = read_json(from);
    EXPECT_TRUE(result["fit"]["interrupted"]);
    EXPECT_EQ(result["fit"]["stopped_by"], "--time-limit 0.5s");
    EXPECT_FALSE(result["equivalence"]["metrics"].empty());
    EXPECT_FALSE(result["coefficients"].empty());
  }
  EXPECT_EQ(
      read_file(out + "/summary.txt").find("INTERRUPTED (stopped by --time-limit 0.5s), the best so far: "),
      0u)
      << read_file(out + "/summary.txt");
  EXPECT_TRUE(std::filesystem::exists(out + "/coefficients.csv"));
}

TEST_F(ProgramRun, ATimeLimitThatIsNoPositiveTimeIsRefused) {
  const std::string study = folder_.write("seconds.json", kSeconds);
  for (const char* limit : {"60", "'0 s'", "'-3 s'", "soon", "'5 m'", "'1e400 s'"}) {
    const int status = std::system(fmt::format("{} fit {} -o {} --time-limit {} > {} 2>&1", ABERFIT_PROGRAM,
                                               study, file("never"), limit, file("said.txt"))
                                       .c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2) << limit;
    EXPECT_NE(read_file(file("said.txt")).find("a positive time with its unit"), std::string::npos)
        << read_file(file("said.txt"));
  }
  EXPECT_FALSE(std::filesystem::exists(file("never")));
}

// Result of a fit that was asked to stop after `looks` queries.
ResultDocument stopped_after(const std::string& text, int looks) {
  RunOptions options;
  options.interrupted = [looks, seen = std::make_shared<int>(0)] { return ++*seen > looks; };
  return run_fit(parse_study(text, "study.json"), options);
}

TEST(Interruption, KeepsTheBestSoFarJudgedAndMarked) {
  std::string explicit_terms = kSeconds;
  explicit_terms.insert(explicit_terms.rfind('}'), R"(, "terms": {"zernike": {"n_max": 8}})");
  for (const std::string& text : {std::string(kSeconds), explicit_terms}) {
    const ResultDocument result = stopped_after(text, 12);
    EXPECT_TRUE(result.interrupted);
    EXPECT_GT(result.fitted.fit.coefficients.size(), 0);
    EXPECT_TRUE(result.fitted.fit.coefficients.allFinite());
    EXPECT_FALSE(result.judgement.metrics.empty());
    EXPECT_LT(result.fitted.fit.iterations, 20);
    EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(),
                            [](const Warning& w) { return w.code == "interrupted"; }));
  }
}

TEST(Interruption, EndsTheRunOfAMap) {
  ScratchFolder folder;
  std::string map = "# pitch = 1 mm\n# of: surface\n# unit: nm\n";
  for (int row = 0; row < 21; ++row) {
    for (int column = 0; column < 21; ++column)
      map += fmt::format("{} ", 10 * std::cos(0.3 * row) * std::sin(0.2 * column));
    map += "\n";
  }
  folder.write("map.txt", map);
  const Study study =
      read_study(folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "1 m"},
      "light": {"wavelength": "632.8 nm"}, "aperture": {"shape": "circle", "diameter": "18 mm"},
      "target": {"map": {"file": "map.txt"}}, "terms": {"zernike": {"n_max": 4}}})"));
  for (const int looks : {0, 1, 100}) {
    RunOptions options;
    options.interrupted = [looks, seen = std::make_shared<int>(0)] { return ++*seen > looks; };
    options.output_directory = folder.file("out");
    options.pictures = PictureFormat::kNone;
    if (looks < 100) {
      EXPECT_THROW(run_map_fit(study, options), Interrupted) << looks;
      EXPECT_FALSE(std::filesystem::exists(folder.file("out"))) << looks;
    } else {
      run_map_fit(study, options);
      EXPECT_TRUE(std::filesystem::exists(folder.file("out/result.json")));
    }
  }
}

}  // namespace
}  // namespace aberfit
