// The main program of every benchmark: google-benchmark with the option --smoke. The exit code is an error if
// an error exceeds its allowed value.
#include <fmt/format.h>

#include <cstring>
#include <exception>
#include <memory>
#include <set>

#include "aberfit/core/instruction_set.h"
#include "aberfit/core/parallel.h"
#include "benchmark_case.h"

namespace aberfit::benchmarks {
namespace {

/// Failed rows, one sentence each. This is the only global state beside google-benchmark's own registry of
/// rows.
std::set<std::string>& failures() {
  static std::set<std::string> found;
  return found;
}

/// The row whose preparation is kept.
struct Kept {
  std::string name;
  Timed timed;
};
Kept& kept() {
  static Kept row;
  return row;
}

}  // namespace

void add_case(const std::string& name, const std::function<Timed()>& prepare) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [name, prepare](benchmark::State& state) {
                                 try {
                                   if (kept().name != name) {
                                     kept() = {};  // frees the memory of the previous row
                                     kept() = {name, prepare()};
                                   }
                                   kept().timed(state);
                                 } catch (const std::exception& problem) {
                                   state.SkipWithError(problem.what());
                                   failures().insert(fmt::format("{}: {}", name, problem.what()));
                                 }
                               })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

void report_error(benchmark::State& state, double error, double allowed) {
  state.counters["error"] = error;
  state.counters["allowed"] = allowed;
  if (!(error <= allowed))
    failures().insert(fmt::format("{}: error {:.3g}, allowed {:.3g}", kept().name, error, allowed));
}

void report_rate(benchmark::State& state, const std::string& unit, double work) {
  state.counters["rate:" + unit] = benchmark::Counter(work, benchmark::Counter::kIsIterationInvariantRate);
}

void report_prediction(benchmark::State& state, double seconds) { state.counters["predicted"] = seconds; }

void time_against(benchmark::State& state, const std::function<void()>& ours,
                  const std::string& name_of_other, const std::function<void()>& other) {
  // google-benchmark counts only the time of `ours`; a much slower other way is repeated less often.
  constexpr double kOtherSeconds = 0.3;
  double spent = 0;
  std::vector<double> of_ours, of_other;
  for (auto _ : state) {
    if (spent < kOtherSeconds) {
      of_other.push_back(seconds_of(other));
      spent += of_other.back();
    }
    of_ours.push_back(seconds_of(ours));
    state.SetIterationTime(of_ours.back());
  }
  state.counters["ratio:" + name_of_other] = median(of_ours) / median(of_other);
}

void time_alone(benchmark::State& state, const std::function<void()>& ours) {
  for (auto _ : state) state.SetIterationTime(seconds_of(ours));
}

}  // namespace aberfit::benchmarks

int main(int argc, char** argv) {
  using namespace aberfit::benchmarks;
  bool smoke = false;
  std::vector<char*> arguments;
  for (int i = 0; i < argc; ++i) {
    if (std::strcmp(argv[i], "--smoke") == 0)
      smoke = true;
    else
      arguments.push_back(argv[i]);
  }
  std::string once = "--benchmark_min_time=0.000000001";  // one iteration
  if (smoke) arguments.push_back(once.data());
  int count = int(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::AddCustomContext("instruction_set", aberfit::to_string(aberfit::best_instruction_set()));
  benchmark::AddCustomContext("threads", std::to_string(aberfit::available_threads()));
  benchmark::AddCustomContext("smoke", smoke ? "yes" : "no");
  register_cases(smoke);
  const std::size_t rows = benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  for (const std::string& failure : failures()) fmt::print(stderr, "FAILED {}\n", failure);
  if (rows == 0) fmt::print(stderr, "FAILED no row ran\n");
  return failures().empty() && rows > 0 ? 0 : 1;
}
