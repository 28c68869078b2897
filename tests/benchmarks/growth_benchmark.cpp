// How time and memory grow with rays and with terms: values and Jacobian of 12 statistics, and whole fits.
//
//     growth_benchmark [--smoke] [--benchmark_out=FILE]
//
// Every case runs in its own process, because peak memory is measured per process. The growth is the exponent
// of a power law through the times (least squares of logarithms) and the largest exponent between neighbours,
// which are a decade apart. Fails when a law grows faster than kExponentAllowed, a process needs more memory
// than kMemoryAllowed, or an error is above what is allowed; --smoke takes small cases and leaves out the
// exponents.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "benchmark_numbers.h"
#include "model_evaluation.h"

namespace aberfit::benchmarks {
namespace {

constexpr double kExponentAllowed = 1.1;
constexpr double kMemoryAllowed = 2000;    // [MB]
constexpr double kMismatchAllowed = 1e-3;  // relative
constexpr double kLeastSeconds = 0.5;      // a case is repeated for so long

struct Outcome {
  std::vector<double> seconds;  // one per repetition
  double peak = 0;              // [MB], timed part with all it needs
  double error = 0, allowed = 0;
};

struct Case {
  std::string setting;
  double size = 0;  // rays or terms
  std::function<Outcome()> run;
};

// Resets the peak of resident memory to the present value. On systems other than Linux the peak of the whole
// process remains.
void reset_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peak_megabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return std::nan("");
}

// A scene with half Zernikes and half plane waves beyond the resolution of the Zernikes.
Scene mixed_scene(int count, std::int64_t rays) {
  int n_max = 1;
  while ((n_max + 2) * (n_max + 3) / 2 <= count / 2) ++n_max;
  TermSet terms = zernike_terms(n_max);
  const double cut = (n_max + 1) / (2 * std::numbers::pi * kRadius);
  const RadialPsd psd(UniformPsd{100e-9, 0.5, 2 * cut});
  terms.fourier = fourier_modes(psd.band(cut, 2 * cut), (count - int(terms.zernike.size()) + 1) / 2, 1);
  CoefficientPrior prior = make_prior(terms, psd, CovarianceKind::kFull);
  return Scene(std::move(terms), std::move(prior), circle_pupil(PupilLayout::kRandom, rays));
}

Outcome time_jacobian(const Scene& scene) {
  ModelEvaluation model(scene, twelve_statistics());
  model.values_and_jacobian();  // fills the caches
  Outcome outcome;
  reset_peak();
  double total = 0;
  while (outcome.seconds.empty() || (total < kLeastSeconds && outcome.seconds.size() < 50)) {
    outcome.seconds.push_back(seconds_of([&] { model.values_and_jacobian(); }));
    total += outcome.seconds.back();
  }
  outcome.peak = peak_megabytes();
  outcome.error = model.error();
  outcome.allowed = kDerivativeAllowed;
  return outcome;
}

Outcome time_fit(const Scene& scene, const std::vector<Statistic>& statistics, int seeds) {
  Outcome outcome;
  reset_peak();
  for (int seed = 1; seed <= seeds; ++seed) {
    const FitProblem problem =
        scene.problem(targets_of(scene, statistics, 1000 + std::uint64_t(seed), kMismatchAllowed));
    FitResult result;
    outcome.seconds.push_back(seconds_of(
        [&] { result = calibrate(problem, draw_white(scene.prior.size(), std::uint64_t(seed)), {}); }));
    outcome.peak = peak_megabytes();
    // We compare the smooth statistics. With 1,000 rays they differ from the exact ones by more than a
    // tolerance.
    for (std::size_t k = 0; k < statistics.size(); ++k)
      outcome.error = std::max(
          outcome.error, std::abs(result.smooth_statistics[Eigen::Index(k)] / problem.targets[k].value - 1));
  }
  outcome.allowed = kMismatchAllowed;
  return outcome;
}

// Runs the case in a child process and reads its result.
Outcome in_process_of_its_own(const Case& one) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    close(ends[0]);
    int code = 1;
    try {
      const Outcome found = one.run();
      const std::string text =
          nlohmann::json{found.seconds, found.peak, found.error, found.allowed}.dump();  // NaN: null
      if (write(ends[1], text.data(), text.size()) == ssize_t(text.size())) code = 0;
    } catch (const std::exception& problem) {
      fmt::print(stderr, "{}: {}\n", one.setting, problem.what());
    }
    _exit(code);
  }
  close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t n = 0; (n = read(ends[0], part, sizeof part)) > 0;) text.append(part, std::size_t(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error(one.setting + " failed");
  const nlohmann::json found = nlohmann::json::parse(text);
  const auto number = [&](int at) { return found[at].is_number() ? found[at].get<double>() : std::nan(""); };
  return {found[0].get<std::vector<double>>(), number(1), number(2), number(3)};
}

struct Growth {
  double exponent, largest_local;
};
Growth growth(const std::vector<double>& sizes, const std::vector<double>& seconds) {
  const Eigen::Index n = Eigen::Index(sizes.size());
  Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(sizes.data(), n).log();
  Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(seconds.data(), n).log();
  double local = -INFINITY;
  for (Eigen::Index i = 1; i < n; ++i) local = std::max(local, (y[i] - y[i - 1]) / (x[i] - x[i - 1]));
  x -= x.mean();
  return {(x * y).sum() / x.square().sum(), local};
}

/// Rows in the form of google-benchmark's JSON, for print_table.py.
class Rows {
 public:
  void add(const std::string& name, double seconds, double error, double allowed, double peak) {
    nlohmann::json row{{"name", name},     {"run_type", "iteration"}, {"real_time", seconds},
                       {"time_unit", "s"}, {"allowed", allowed},      {"error", error}};
    if (peak > 0) row["peak_MB"] = peak, row["allowed_MB"] = kMemoryAllowed;
    rows_.push_back(std::move(row));
    if (!(error <= allowed))
      failures_.insert(fmt::format("{}: error {:.3g}, allowed {:.3g}", name, error, allowed));
    if (peak > kMemoryAllowed)
      failures_.insert(fmt::format("{}: {:.0f} MB, allowed {:.0f} MB", name, peak, kMemoryAllowed));
  }
  const std::set<std::string>& failures() const { return failures_; }
  nlohmann::json document() const { return {{"context", nlohmann::json::object()}, {"benchmarks", rows_}}; }

 private:
  nlohmann::json rows_ = nlohmann::json::array();
  std::set<std::string> failures_;
};

void run_series(const std::string& name, const std::vector<Case>& cases, bool smoke, Rows* rows) {
  std::vector<double> sizes, seconds_of_size;
  for (const Case& one : cases) {
    const Outcome outcome = in_process_of_its_own(one);
    for (const double seconds : outcome.seconds)
      rows->add(name + "/" + one.setting, seconds, outcome.error, outcome.allowed, outcome.peak);
    sizes.push_back(one.size);
    // Fits differ by their number of steps, so their median counts. Evaluations differ by noise of the
    // machine, so the shortest counts.
    const bool fit = name.starts_with("Fit");
    seconds_of_size.push_back(fit ? median(outcome.seconds)
                                  : *std::min_element(outcome.seconds.begin(), outcome.seconds.end()));
    fmt::print("{:<40} {:<30} {:>10.4g} s {:>8.0f} MB  error {:.2g}\n", name, one.setting,
               seconds_of_size.back(), outcome.peak, outcome.error);
    std::fflush(stdout);
  }
  const Growth law = growth(sizes, seconds_of_size);
  fmt::print("{:<40} exponent {:.2f}, largest over a decade {:.2f}\n", name, law.exponent, law.largest_local);
  if (smoke) return;
  rows->add(fmt::format("{}/exponent of the law, largest over a decade {:.2f}", name, law.largest_local),
            seconds_of_size.back(), law.exponent, kExponentAllowed, 0);
}

int run(bool smoke, const std::string& out) {
  Rows rows;
  const int seeds = smoke ? 1 : 3;
  const auto by_rays = [&](std::int64_t largest, const std::function<Outcome(const Scene&)>& timed) {
    std::vector<Case> cases;
    for (std::int64_t rays = 1000; rays <= largest; rays *= 10)
      cases.push_back({fmt::format("231 Zernikes, {} random rays", grouped(rays)), double(rays),
                       [=] { return timed(Scene(20, circle_pupil(PupilLayout::kRandom, rays))); }});
    return cases;
  };
  const auto by_terms = [&](const std::function<Outcome(const Scene&)>& timed) {
    std::vector<Case> cases;
    for (int terms = 10; terms <= (smoke ? 1000 : 10000); terms *= 10)
      cases.push_back({fmt::format("{} mixed terms, 15,000 random rays", grouped(terms)), double(terms),
                       [=] { return timed(mixed_scene(terms, 15000)); }});
    return cases;
  };
  const auto fit = [seeds](const std::vector<Statistic>& statistics) {
    return [=](const Scene& scene) { return time_fit(scene, statistics, seeds); };
  };
  run_series("Jacobian of 12 statistics over rays", by_rays(smoke ? 100000 : 10000000, time_jacobian), smoke,
             &rows);
  run_series("Jacobian of 12 statistics over terms", by_terms(time_jacobian), smoke, &rows);
  run_series("Fit of 12 statistics over rays", by_rays(smoke ? 10000 : 1000000, fit(twelve_statistics())),
             smoke, &rows);
  // Ten terms cannot meet twelve statistics, so the fit has two.
  run_series("Fit of EE 50 and 90 % over terms",
             by_terms(fit({EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.9, 0}})), smoke, &rows);
  if (!out.empty()) std::ofstream(out) << rows.document().dump(1) << "\n";
  for (const std::string& failure : rows.failures()) fmt::print(stderr, "FAILED {}\n", failure);
  return rows.failures().empty() ? 0 : 1;
}

}  // namespace
}  // namespace aberfit::benchmarks

int main(int argc, char** argv) {
  bool smoke = false;
  std::string out;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i], out_key = "--benchmark_out=";
    if (argument == "--smoke")
      smoke = true;
    else if (argument.starts_with(out_key))
      out = argument.substr(out_key.size());
    else if (!argument.starts_with("--benchmark_")) {  // options of the other programs have no meaning here
      fmt::print(stderr, "unknown argument {}\n", argument);
      return 2;
    }
  }
  try {
    return aberfit::benchmarks::run(smoke, out);
  } catch (const std::exception& problem) {
    fmt::print(stderr, "{}\n", problem.what());
    return 1;
  }
}
