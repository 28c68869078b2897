#include "aberfit/chart/cost_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "aberfit/core/errors.h"
#include "aberfit/method/fresh_statistics.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/spectrum_target.h"
#include "aberfit/method/term_search.h"
#include "chart_families.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

constexpr double kBenchZoneDraws = 1000;

// Typical iterations of fits that end within their tolerances: 3 to 12 of explicit terms by rays (studies of
// fits/), 24 and 33 by waves (a uniform band of 25 nm with n <= 28, a Gaussian PSD of 30 nm with n <= 57,
// both 0.4 m f/7). The sets that a search looks at closely are the ones that just pass or just fail: 20 to
// 100.
// Far fewer unknowns than statistics leave no freedom: 81 in fits/spherical.
constexpr double kIterations = 10, kWaveIterations = 30, kSearchIterations = 30, kFewTermsIterations = 80;
// Sets that a search fits in full: 3 to 6 by rays (fits/ without `terms`), 4 by waves (the uniform band).
constexpr int kFullFits = 5, kWaveFits = 4;
// Of these as many meet every tolerance, are judged, and need twice the rays they started with.
constexpr int kPassing = 2;
// Plane waves: 32, 64, ... to where they pass (181 for 20 nm uniform from 2.5 to 200 /m), then in between.
constexpr int kFewestModes = 32, kTypicalModes = 256;

FitSize fit_size(const Study& study, const TermSet& terms, const TargetSets& targets, int threads) {
  FitSize size;
  size.rays = double(study.trace.pupil.rays);
  size.terms = double(terms.size());
  size.fitted = double(targets.fitted.size() + targets.guides.size());
  size.judged = double(targets.fitted.size() + targets.held_out.size());
  size.zone_points = zone_points(terms);
  size.threads = threads;
  return size;
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

FitRates measure_rates(const ChartBench& bench, double seconds) {
  const Study& study = bench.study;
  FitRates rates;
  rates.size = fit_size(study, bench.terms, bench.targets, bench.threads);
  rates.expected = fit_work(study, bench.scene, bench.terms, bench.targets, bench.threads);
  rates.measured.targets = bench.targets_seconds;
  rates.measured.prior = bench.prior_seconds;
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
  rates.iterations = rates.iterations_known ? std::max(1, fit.iterations) : kIterations;
  if (rates.iterations_known)
    rates.measured.iteration = fit.seconds / rates.iterations;
  else
    rates.measured.iteration = done > 0 ? last / done : 2 * rates.jacobian;

  bench.say("chart: fresh rays");
  std::vector<Statistic> judged = bench.statistics;
  for (const Target& target : bench.targets.held_out) judged.push_back(target.statistic);
  const double whole = 8 * rates.exact * rates.size.judged / std::max(1.0, double(bench.statistics.size()));
  const double part = std::clamp(0.15 * seconds / whole, 0.01, 1.0);
  const auto fresh_rays = std::int64_t(std::max(4096.0, 4 * rates.size.rays * part));
  const ChartClock fresh_clock(0);
  const FreshStatistics fresh =
      evaluate_fresh(study, bench.terms, bench.coefficients, judged, fresh_rays, bench.threads, nullptr);
  rates.measured.fresh =
      fresh_clock.elapsed() * 4 * rates.size.rays / double(std::max<Eigen::Index>(1, fresh.rays));

  if (rates.size.zone_points > 0) {
    bench.say("chart: zones");
    SurfaceField field;
    const ChartClock one_clock(0);
    at.surface().apply(bench.coefficients, &field);
    rates.measured.zones =
        kBenchZoneDraws * one_clock.elapsed() * rates.size.zone_points / double(at.pupil().size());
    if (rates.measured.zones < 0.25 * seconds) {
      const ChartClock zone_clock(0);
      zone_slopes(study, bench.terms, bench.prior, bench.coefficients, bench.threads);
      rates.measured.zones = zone_clock.elapsed();
    }
  }
  return rates;
}

FitRates built_in_rates() {
  FitRates rates;
  rates.measured = rates.expected = {1, 1, 1, 1, 1, 1, 1, 1};
  rates.iterations = kIterations;
  rates.source = "of two AVX-512 cores";
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
          {"targets_seconds", r.measured.targets},
          {"prior_seconds", r.measured.prior},
          {"forward_seconds", r.forward},
          {"jacobian_seconds", r.jacobian},
          {"exact_seconds", r.exact},
          {"iteration_seconds", r.measured.iteration},
          {"iterations", r.iterations},
          {"iterations_known", r.iterations_known},
          {"fresh_seconds", r.measured.fresh},
          {"zones_seconds", r.measured.zones},
          {"expected",
           {{"targets_seconds", r.expected.targets},
            {"prior_seconds", r.expected.prior},
            {"iteration_seconds", r.expected.iteration},
            {"fresh_seconds", r.expected.fresh},
            {"zones_seconds", r.expected.zones}}}};
}

FitRates read_rates(const std::string& file_or_folder, const ordered_json& study, bool* same_study) {
  namespace fs = std::filesystem;
  const std::string file =
      fs::is_directory(file_or_folder) ? (fs::path(file_or_folder) / "chart.json").string() : file_or_folder;
  const ordered_json chart = read_chart(file);
  FitRates r;
  try {
    if (chart.at("kind") != "chart") throw InputError(file, "/kind", chart["kind"].dump(), "\"chart\"");
    const ordered_json &rates = chart.at("rates"), &size = rates.at("size"), &expected = rates.at("expected");
    // A chart that was edited must not end as a prediction of nothing or of minus a second.
    const auto number = [&](const ordered_json& from, const char* key) {
      const double value = from.at(key).get<double>();
      const bool counts = &from == &size && std::string(key) != "zone_points";
      if (!std::isfinite(value) || value < 0 || (counts && value < 1))
        throw InputError(file,
                         std::string("/rates/") +
                             (&from == &size       ? "size/"
                              : &from == &expected ? "expected/"
                                                   : "") +
                             key,
                         from[key].dump(), counts ? "a number from 1 up" : "a number from 0 up");
      return value;
    };
    r.size = {number(size, "rays"),   number(size, "terms"),       number(size, "fitted"),
              number(size, "judged"), number(size, "zone_points"), number(size, "threads")};
    const auto work = [&](const ordered_json& from) {
      FitWork w;
      w.targets = number(from, "targets_seconds");
      w.prior = number(from, "prior_seconds");
      w.iteration = number(from, "iteration_seconds");
      w.fresh = number(from, "fresh_seconds");
      w.zones = number(from, "zones_seconds");
      return w;
    };
    r.measured = work(rates);
    r.expected = work(expected);
    r.forward = number(rates, "forward_seconds");
    r.jacobian = number(rates, "jacobian_seconds");
    r.exact = number(rates, "exact_seconds");
    r.iterations = number(rates, "iterations");
    r.iterations_known = rates.at("iterations_known").get<bool>();
    *same_study = chart.at("study") == study;
  } catch (const ordered_json::exception&) {
    throw InputError(file, "", "no rates of a chart", "chart.json as `aberfit chart` writes it");
  }
  r.source = *same_study ? "measured on this study, " + file : "scaled from another study, " + file;
  if (!*same_study) {
    r.iterations_known = false;
    r.iterations = kIterations;
  }
  return r;
}

namespace {

/// Full fits of one set on one number of rays.
struct Fits {
  Study study;
  TermSet terms;
  double count = 1, judged = 1;  // how many, and how many of these are judged
};

Study on_rays(Study study, std::int64_t rays) {
  study.trace.automatic_rays = false;
  study.trace.pupil.rays = rays;
  return study;
}

// fit_on_enough_rays (attempt.cpp) of `count` sets, of which `passing` are judged and tried on twice the
// rays.
void add_fits(const Study& study, const Scene& scene, const TermSet& terms, double count, double passing,
              std::vector<Fits>* fits) {
  if (!study.trace.automatic_rays || scene.use.physics == FocusPhysics::kWaves) {
    fits->push_back({study, terms, count, passing});
    return;
  }
  const std::int64_t first = first_rays(terms.size());
  fits->push_back({on_rays(study, first), terms, count, passing});
  fits->push_back({on_rays(study, more_rays(first)), terms, passing, passing});
}

TermSet terms_of(const Study& study, const Scene& scene) {
  double captured = 0;
  return make_terms(study, scene, &captured);
}

// Where searches by rays end: 18 of 15 to 28, 18 of 6 to 31, 24 of 17 to 74, 36 and 40 of 31 to 56 (studies
// of fits/). By waves they start at the high end and end near it: 26 of 15 to 28. Where even the last order
// is short of the height variance, none passes, and the search goes on to its end (95 of 27 to 100,
// fits/measured-zygo).
int typical_order(const OrderRange& range, bool waves) {
  if (waves || range.high >= kLargestSearchedOrder) return range.high;
  return std::max(2, int(std::lround(std::sqrt(double(range.low) * range.high))));
}

// The sets of a search: short ones by `screens`, full ones by the return value.
std::vector<Fits> search_fits(const Study& study, const Scene& scene, std::vector<Fits>* screens) {
  const bool waves = scene.use.physics == FocusPhysics::kWaves;
  const OrderRange range = expected_orders(scene);
  std::vector<Fits> fits;
  if (range.wide) {  // doubling, then half as many steps in between
    for (int count = kFewestModes; count <= kTypicalModes; count *= 2) {
      const Study with = with_fourier_modes(study, count);
      const bool last = count == kTypicalModes;
      add_fits(with, scene, terms_of(with, scene), last ? kPassing + 1 : 1, last ? kPassing : 0, &fits);
    }
    return fits;
  }
  const int end = typical_order(range, waves);
  for (int order = 2; !waves && order < end; order = next_order(order)) {
    const Study with = with_zernikes(study, order);
    const TermSet terms = terms_of(with, scene);
    screens->push_back({on_rays(with, screening_rays(terms.size())), terms, 1, 0});
  }
  const Study with = with_zernikes(study, end);
  add_fits(with, scene, terms_of(with, scene), waves ? kWaveFits : kFullFits, kPassing, &fits);
  return fits;
}

}  // namespace

FitPrediction predict_fit(const Study& study, const Scene& scene, const TermSet& terms,
                          const TargetSets& targets, const FitRates& r, int threads) {
  const bool rays = scene.use.physics == FocusPhysics::kRays;
  // A chart is of rays: of other physics it only tells how fast the machine is.
  const double speed = r.expected.iteration > 0 ? r.measured.iteration / r.expected.iteration : 1;
  const auto rate = [&](double FitWork::*stage) {
    return !rays ? speed : r.expected.*stage > 0 ? r.measured.*stage / r.expected.*stage : 0.0;
  };
  FitPrediction p;
  p.search = study.terms.automatic && scene.psd;
  std::vector<Fits> screens, fits;
  if (p.search)
    fits = search_fits(study, scene, &screens);
  else
    add_fits(study, scene, terms, 1, 1, &fits);
  p.iterations_known = r.iterations_known && rays && !p.search;
  const bool few = 2 * std::size_t(terms.size()) <= targets.fitted.size() + targets.guides.size();
  p.iterations = p.search             ? kSearchIterations
                 : p.iterations_known ? r.iterations
                 : few                ? kFewTermsIterations
                 : rays               ? r.iterations
                                      : kWaveIterations;
  p.more_rays = study.trace.automatic_rays && scene.use.physics != FocusPhysics::kWaves;

  const int most = std::max(1, study.fit.max_iterations);
  const double iterations = std::min(p.iterations, double(most));
  double screening = 0, prior = 0, solving = 0, ends = 0, fresh = 0;
  for (const Fits& fit : screens) {
    const FitWork work = fit_work(fit.study, scene, fit.terms, targets, threads);
    screening +=
        work.prior * rate(&FitWork::prior) +
        (work.iteration * std::min(kScreeningIterations, most) + work.ends) * rate(&FitWork::iteration);
  }
  FitWork last;
  for (const Fits& fit : fits) {
    last = fit_work(fit.study, scene, fit.terms, targets, threads);
    prior += fit.count * last.prior * rate(&FitWork::prior);
    solving += fit.count * iterations * last.iteration * rate(&FitWork::iteration);
    ends += fit.count * last.ends * rate(&FitWork::iteration);
    fresh += fit.judged * last.fresh * rate(&FitWork::fresh);
  }
  p.stages.emplace_back("targets", last.targets * rate(&FitWork::targets));
  if (!screens.empty()) p.stages.emplace_back("short fits", screening);
  p.stages.emplace_back("prior", prior);
  p.stages.emplace_back("iterations", solving);
  p.stages.emplace_back("start and result", ends);
  p.stages.emplace_back("fresh rays", fresh);
  if (last.judgement > 0) p.stages.emplace_back("needed model", last.judgement * speed);
  if (last.realisations > 0) p.stages.emplace_back("realisations", last.realisations * speed);
  p.stages.emplace_back("zones", last.zones * rate(&FitWork::zones));
  for (const auto& [stage, seconds] : p.stages) p.seconds += seconds;
  return p;
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
