#include "cost_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "aberfit/core/errors.h"
#include "spectrum_target.h"
#include "validate.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

constexpr double kZoneDraws = 1000;
// Shares of the work, for scaling from one size to another: one term at one ray, and one statistic at one
// ray, in the same unit; share of the rays that a statistic's gradient touches. From the docstring of
// terms/surface_operator.cpp (6e9 term-points/s at any points; on rings a term costs less, so that
// predictions for many terms there are too long) and `aberfit chart fits/paper-physical/study.json`.
constexpr double kTermWork = 1, kStatisticWork = 120, kTouched = 0.05;

double iteration_work(const FitSize& s) {
  return s.rays * (s.terms * kTermWork * (1 + kTouched * s.fitted) + s.fitted * kStatisticWork);
}
double evaluation_work(const FitSize& s, double statistics) {
  return s.rays * (s.terms * kTermWork + statistics * kStatisticWork);
}

ordered_json read_chart(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "no file that can be read", "chart.json as `aberfit chart` writes it");
  try {
    return ordered_json::parse(in);
  } catch (const ordered_json::parse_error&) {
    throw InputError(file, "", "no JSON", "chart.json as `aberfit chart` writes it");
  }
}

}  // namespace

FitSize fit_size(const Study& study, const TermSet& terms, const TargetSets& targets, int threads) {
  FitSize size;
  size.rays = double(study.trace.pupil.rays);
  size.terms = double(terms.size());
  size.fitted = double(targets.fitted.size() + targets.guides.size());
  size.judged = double(targets.fitted.size() + targets.held_out.size());
  // As zone_slopes (validate.cpp) chooses them; no zones for purely spherical terms.
  const double order = terms.zernike.empty() ? 0 : terms.zernike.back().n;
  if (!terms.zernike.empty() || !terms.fourier.empty())
    size.zone_points = std::clamp(4 * order * order, 4096.0, 65536.0);
  size.threads = threads;
  return size;
}

FitRates measure_rates(const ChartBench& bench, double seconds) {
  const Study& study = bench.study;
  FitRates rates;
  rates.size = fit_size(study, bench.terms, bench.targets, bench.threads);
  rates.targets = bench.targets_seconds;
  rates.prior = bench.prior_seconds;
  rates.source = "measured on this study";

  bench.say("chart: an evaluation and a Jacobian");
  ChartTrace at(bench, bench.terms, make_pupil(study.aperture, study.trace.pupil), bench.threads);
  std::vector<Statistic> both = bench.statistics;
  for (const Target& guide : bench.targets.guides) both.push_back(guide.statistic);
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  const double share = 0.06 * seconds;
  rates.exact = measure_time(share, [&] { at.exact(bench.coefficients, bench.statistics); }).median;
  rates.forward = measure_time(share, [&] {
                    at.smooth(bench.coefficients, both, bench.smoothing, &values, nullptr);
                  }).median;
  rates.jacobian = measure_time(share, [&] {
                     at.smooth(bench.coefficients, both, bench.smoothing, &values, &jacobian);
                   }).median;

  // The fit itself, as far as the time goes.
  const SpectrumTarget spectrum =
      make_spectrum_target(study, bench.scene, bench.terms, bench.prior, bench.threads);
  FitProblem problem{study.mirror,         at.pupil(),           at.surface(),       bench.prior,
                     bench.targets.fitted, bench.targets.guides, study.trace.centre, bench.scene.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  FitOptions how;
  how.prior = study.fit.prior;
  how.max_iterations = study.fit.max_iterations;
  how.bound = study.fit.bound_sigmas;
  how.threads = bench.threads;
  double last = 0;
  int done = 0;
  const double limit = 0.5 * seconds;
  how.progress = [&](const FitProgress& p) {
    bench.say(fmt::format("chart: fit, iteration {}, {:.1f} s", p.iteration, p.seconds));
    if (p.iteration > done) {
      done = p.iteration;
      last = p.seconds;
    }
    return p.seconds < limit;
  };
  const FitResult fit = calibrate(problem, draw_white(bench.prior.size(), study.fit.seed), how);
  rates.iterations_known = fit.status == FitStatus::kConverged || fit.status == FitStatus::kNotConverged;
  rates.iterations = rates.iterations_known ? std::max(1, fit.iterations) : built_in_rates().iterations;
  if (rates.iterations_known)
    rates.iteration = fit.seconds / rates.iterations;
  else
    rates.iteration = done > 0 ? last / done : 2 * rates.jacobian;

  bench.say("chart: fresh rays");
  std::vector<Statistic> judged = bench.statistics;
  for (const Target& target : bench.targets.held_out) judged.push_back(target.statistic);
  const double whole = 8 * rates.exact * rates.size.judged / std::max(1.0, double(bench.statistics.size()));
  const double part = std::clamp(0.15 * seconds / whole, 0.01, 1.0);
  const auto fresh_rays = std::int64_t(std::max(4096.0, 4 * rates.size.rays * part));
  const ChartClock fresh_clock(0);
  const FreshStatistics fresh =
      evaluate_fresh(study, bench.terms, bench.coefficients, judged, fresh_rays, bench.threads, nullptr);
  rates.fresh = fresh_clock.elapsed() * 4 * rates.size.rays / double(std::max<Eigen::Index>(1, fresh.rays));

  if (rates.size.zone_points > 0) {
    bench.say("chart: zones");
    SurfaceField field;
    const ChartClock one_clock(0);
    at.surface().apply(bench.coefficients, &field);
    rates.zones = kZoneDraws * one_clock.elapsed() * rates.size.zone_points / double(at.pupil().size());
    if (rates.zones < 0.25 * seconds) {
      const ChartClock zone_clock(0);
      zone_slopes(study, bench.terms, bench.prior, bench.coefficients, bench.threads);
      rates.zones = zone_clock.elapsed();
    }
  }
  return rates;
}

FitRates built_in_rates() {
  // `aberfit chart fits/paper-physical/study.json`, two AVX-512 cores.
  FitRates rates;
  rates.size = {65536, 432, 111, 157, 4096, 2};
  rates.targets = 0.014;
  rates.prior = 0.0005;
  rates.iteration = 0.033;
  rates.iterations = 10;  // 4 to 25 over the studies of fits/
  rates.exact = 0.0038;
  rates.fresh = 0.15;
  rates.zones = 0.029;
  rates.forward = 0.0031;
  rates.jacobian = 0.0105;
  rates.source = "measured with fits/paper-physical on two AVX-512 cores";
  return rates;
}

ordered_json to_json(const FitRates& r) {
  return {{"size",
           {{"rays", r.size.rays},
            {"terms", r.size.terms},
            {"fitted", r.size.fitted},
            {"judged", r.size.judged},
            {"zone_points", r.size.zone_points},
            {"threads", r.size.threads}}},
          {"targets_seconds", r.targets},
          {"prior_seconds", r.prior},
          {"forward_seconds", r.forward},
          {"jacobian_seconds", r.jacobian},
          {"exact_seconds", r.exact},
          {"iteration_seconds", r.iteration},
          {"iterations", r.iterations},
          {"iterations_known", r.iterations_known},
          {"fresh_seconds", r.fresh},
          {"zones_seconds", r.zones}};
}

FitRates read_rates(const std::string& file_or_folder, const ordered_json& study, bool* same_study) {
  namespace fs = std::filesystem;
  const std::string file =
      fs::is_directory(file_or_folder) ? (fs::path(file_or_folder) / "chart.json").string() : file_or_folder;
  const ordered_json chart = read_chart(file);
  FitRates r;
  try {
    if (chart.at("kind") != "chart") throw InputError(file, "/kind", chart["kind"].dump(), "\"chart\"");
    const ordered_json &rates = chart.at("rates"), &size = rates.at("size");
    // A chart that was edited must not end as a prediction of nothing or of minus a second.
    const auto number = [&](const ordered_json& from, const char* key) {
      const double value = from.at(key).get<double>();
      const bool size_of = &from == &size;
      const bool counts = size_of && std::string(key) != "zone_points";
      if (!std::isfinite(value) || value < 0 || (counts && value < 1))
        throw InputError(file, std::string("/rates/") + (size_of ? "size/" : "") + key, from[key].dump(),
                         counts ? "a number from 1 up" : "a number from 0 up");
      return value;
    };
    r.size = {number(size, "rays"),   number(size, "terms"),       number(size, "fitted"),
              number(size, "judged"), number(size, "zone_points"), number(size, "threads")};
    r.targets = number(rates, "targets_seconds");
    r.prior = number(rates, "prior_seconds");
    r.forward = number(rates, "forward_seconds");
    r.jacobian = number(rates, "jacobian_seconds");
    r.exact = number(rates, "exact_seconds");
    r.iteration = number(rates, "iteration_seconds");
    r.iterations = number(rates, "iterations");
    r.iterations_known = rates.at("iterations_known").get<bool>();
    r.fresh = number(rates, "fresh_seconds");
    r.zones = number(rates, "zones_seconds");
    *same_study = chart.at("study") == study;
  } catch (const ordered_json::exception&) {
    throw InputError(file, "", "no rates of a chart", "chart.json as `aberfit chart` writes it");
  }
  r.source = *same_study ? "measured on this study, " + file : "scaled from another study, " + file;
  if (!*same_study) {
    r.iterations_known = false;
    r.iterations = built_in_rates().iterations;
  }
  return r;
}

std::vector<std::pair<std::string, double>> predict_fit(const FitRates& r, const FitSize& size) {
  const auto ratio = [](double a, double b) { return b > 0 ? a / b : 0.0; };
  const double threads = r.size.threads / size.threads;
  const double judging = ratio(evaluation_work(size, size.judged), evaluation_work(r.size, r.size.judged));
  return {
      {"targets", r.targets * ratio(size.fitted + size.judged, r.size.fitted + r.size.judged) * threads},
      // Blocks of one m each, half as many integrals as terms times orders.
      {"prior", r.prior * std::pow(ratio(size.terms, r.size.terms), 1.5)},
      {"iterations",
       r.iterations * r.iteration * ratio(iteration_work(size), iteration_work(r.size)) * threads},
      {"start and result",
       2 * r.exact * ratio(evaluation_work(size, size.fitted), evaluation_work(r.size, r.size.fitted)) *
           threads},
      {"fresh rays", r.fresh * judging * threads},
      {"zones", r.zones * ratio(size.zone_points * size.terms, r.size.zone_points * r.size.terms) * threads}};
}

double predict_map_fit(double points, double terms, int threads) {
  // Measured with `aberfit fit` on maps of 1e4 to 1e5 points, n_max 20 to 60, two AVX-512 cores: design and
  // QR take 4 flops and a block's share of the triangles' reduction per point and pair of terms.
  constexpr double kPairRate = 2e9;                 // points x terms^2 per second and thread
  constexpr double kSingularRate = 2e8;             // terms^3 per second: the singular values of the triangle
  constexpr double kDenseTerms = 1500;              // beyond: conjugate gradients, fit/map_fit.cpp
  constexpr double kSweeps = 200, kTermRate = 4e9;  // of L and its adjoint
  const double all = terms + 3;                     // piston and tilt are fitted along
  if (all <= kDenseTerms) return points * all * all / (kPairRate * threads) + all * all * all / kSingularRate;
  return kSweeps * 2 * points * all / (kTermRate * threads);
}

}  // namespace aberfit
