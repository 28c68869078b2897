#include "aberfit/chart/cost_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/prior_draws.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/spectrum_target.h"
#include "aberfit/method/term_search.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/operator_cost.h"
#include "aberfit/waves/diffraction_psf.h"
#include "chart_families.h"

namespace aberfit {
using namespace internal;

namespace {

// Typical iterations of fits that end within their tolerances: 3 to 12 of explicit terms by rays (studies of
// fits/), 6 to 30 by waves (generated scenes). The sets that a search by rays looks at closely are the ones
// that just pass or just fail: 20 to 100 of plane waves, 6 to 40 of Zernikes (tests/stability). Far fewer
// unknowns than statistics leave no freedom: 81 in fits/spherical, 12 to 100 in thirteen of tests/stability,
// half of them 16 to 83.
constexpr double kIterations = 10, kWaveIterations = 15, kClimbIterations = 18, kFewTermsIterations = 40;
constexpr double kPlaneWaveIterations = 38, kPlaneWaveNearMiss = 70;
// Short fits end early where they stay away: a third of the iterations that they may take (tests/stability).
constexpr double kShortIterations = kScreeningIterations / 3.0;
// Searches by waves (tests/stability, sixty scenes): a set that is far off is given up after 12, one that
// misses by little or between its targets gets a second look or another grid, and the one that just passes
// often does, too; those with more terms take 10 to 20.
constexpr double kFarOff = 14, kNarrowly = 26, kWithEase = 17;
// The same of sets that begin where rays have led them (ten of tests/stability): 0 to 6, and 5 to 11 of those
// that are given up.
constexpr double kLedAndPassing = 3, kLedAndFarOff = 8;
// Of plane waves, which end further from their tolerances (eleven of tests/stability took half as long again
// as with three).
constexpr double kPlaneWavesLed = 9;
// Sets of Zernikes that a search by rays fits in full: 3 to 6 (studies of fits/ without `terms`), 2 to 7, of
// roughness with fewer modes than statistics 5 to 15 (tests/stability). One of them misses by little, none to
// 4 do, and goes on with twice the rays, of which many rest early.
struct Closely {
  int sets;
  double near_miss_iterations;
};
constexpr Closely kClosely{4, 20}, kCloselyOfFewModes{6, 60};
// Of these as many meet every tolerance, are judged, and need twice the rays they started with.
constexpr int kPassing = 2;
// Sets of a search by waves pass from this share of the orders it expects on: 0.1 to 0.8, half of them 0.25
// to 0.6, of forty orders and more on fewer than 100,000 cells 0.02 to 0.7, half of eleven to 0.13
// (tests/stability). Those below stay 2 to 10 tolerances away, but from this share of the order that passes
// on they meet what is fitted and miss by little.
constexpr double kPassFrom = 0.4, kPassFromOfMany = 0.25, kTypicalMismatch = 3, kNearlyFrom = 0.75;
constexpr int kManyOrders = 40;
constexpr int kFewestModes = 32;  // plane waves: 32, 64, ... to where they pass, then in between

// The fit itself, as far as the time goes: at most `limit` [s].
void time_fit(const ChartBench& bench, const ChartTrace& at, double limit, FitRates* rates) {
  const Task& task = bench.task;
  const SpectrumTarget spectrum =
      make_spectrum_target(task, bench.ground, bench.terms, bench.prior, bench.threads);
  LightPath light{task.mirror, at.pupil(), at.surface()};
  light.centre = task.trace.centre;
  FitProblem problem{light, bench.prior, aims_of(bench.targets.fitted), aims_of(bench.targets.guides),
                     bench.ground.focal_sigma};
  problem.spectrum = spectrum.spectrum.get();
  problem.spectrum_target = spectrum.value;
  problem.spectrum_tolerance = spectrum.tolerance;
  FitOptions how;
  how.prior = task.fit.prior;
  how.max_iterations = task.fit.max_iterations;
  how.bound = task.fit.bound_sigmas;
  how.threads = bench.threads;
  double last = 0;
  int done = 0;
  how.progress = [&](const FitProgress& p) {
    bench.say(fmt::format("chart: fit, iteration {}, {:.1f} s", p.iteration, p.seconds));
    if (p.iteration > done) {
      done = p.iteration;
      last = p.seconds;
    }
    return p.seconds < limit;
  };
  const FitResult fit = calibrate(problem, draw_white(bench.prior.size(), task.fit.seed), how);
  rates->iterations_known = fit.status == FitStatus::kConverged || fit.status == FitStatus::kNotConverged;
  rates->iterations = rates->iterations_known ? std::max(1, fit.iterations) : kIterations;
  if (rates->iterations_known)
    rates->measured.iteration = fit.seconds / rates->iterations;
  else
    rates->measured.iteration = done > 0 ? last / done : 2 * rates->jacobian;
}

}  // namespace

namespace internal {

FitRates measure_rates(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  const TargetSets& targets = bench.targets;
  FitRates rates;
  rates.size = {double(rays_of(task.trace.pupil)),
                double(bench.terms.size()),
                double(targets.fitted.size() + targets.guides.size()),
                double(targets.fitted.size() + targets.held_out.size()),
                zone_points(bench.terms),
                double(bench.threads)};
  rates.expected = fit_work(task, bench.ground, bench.terms, task.trace.pupil, targets, bench.threads);
  rates.measured.targets = bench.targets_seconds;
  rates.measured.prior = bench.prior_seconds;
  rates.source = "measured on this study";

  bench.say("chart: an evaluation and a Jacobian");
  ChartTrace at(bench, task.trace.pupil);
  std::vector<Statistic> both;
  for (const auto* set : {&targets.fitted, &targets.guides})
    for (const Target& target : *set) both.push_back(aim_of(target).statistic);
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  const double share = 0.06 * seconds;
  rates.exact = measure_time(share, [&] { at.exact(); }).median;
  rates.forward = measure_time(share, [&] {
                    at.smooth(bench.coefficients, both, bench.smoothing, &values, nullptr);
                  }).median;
  rates.jacobian = measure_time(share, [&] {
                     at.smooth(bench.coefficients, both, bench.smoothing, &values, &jacobian);
                   }).median;

  time_fit(bench, at, 0.5 * seconds, &rates);

  bench.say("chart: fresh rays");
  const JudgedSet judged(targets.fitted, targets.held_out);
  const double whole = 8 * rates.exact * rates.size.judged / std::max(1.0, double(bench.statistics.size()));
  const double part = std::clamp(0.15 * seconds / whole, 0.01, 1.0);
  const auto fresh_rays = std::int64_t(std::max(4096.0, 4 * rates.size.rays * part));
  const ChartClock fresh_clock(0);
  const FreshStatistics fresh =
      statistics_with_error(lit_mirror(task, nullptr), {FocusModel::kRays, fresh_rays, task.trace.pupil.seed},
                            bench.terms, bench.coefficients, judged.statistics(), bench.threads, nullptr);
  rates.measured.fresh =
      fresh_clock.elapsed() * 4 * rates.size.rays / double(std::max<Eigen::Index>(1, fresh.rays));
  return rates;
}

}  // namespace internal

FitRates built_in_rates() {
  FitRates rates;
  rates.measured = rates.expected = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  rates.iterations = kIterations;
  rates.source = "of two AVX-512 cores";
  return rates;
}

namespace {

// [s] that the processor has worked for this thread.
double worked() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

// Of work in this thread. What else runs on the machine takes turns with it, which does not count, and
// slows it down, which the least of several has the least of.
double least_time(double budget, const std::function<void()>& run) {
  constexpr int kFewest = 5;
  double least = HUGE_VAL;
  const ChartClock clock(budget);
  for (int k = 0; k < kFewest || clock.elapsed() < budget; ++k) {
    const double begin = worked();
    run();
    least = std::min(least, worked() - begin);
  }
  return least;
}

// Times of this machine over those of the constants.
struct Speed {
  double rays = 0, waves = 0, large = 0, products = 0;
};

const CircleAperture kCircle{0.1};
constexpr double kBudget = 0.03;  // [s] for each

// L at scattered points.
double speed_of_rays() {
  const TermSet terms{0.5 * kCircle.diameter, zernike_modes(2, 16), {}, {}};
  const PupilSample points = make_pupil(kCircle, {PupilLayout::kSobol, 8192, 1});
  const Eigen::VectorXd coefficients = Eigen::VectorXd::Constant(terms.size(), 1e-9);
  const SurfaceOperator surface(terms, points.x, points.y, 1);
  SurfaceField field;
  return least_time(kBudget, [&] { surface.apply(coefficients, &field); }) /
         choose_operator(terms, PointLayout{points.size()}).forward_seconds;
}

// A focal plane with the gradients of what rings in it hold.
double speed_of_waves(int cells, int rings) {
  constexpr double kFocalLength = 0.7, kWavelength = 600e-9;
  const DiffractionPupil pupil = diffraction_pupil(kCircle, kFocalLength, kCircle.diameter / cells);
  std::vector<Statistic> inside;
  for (int k = 1; k <= rings; ++k) inside.push_back(RingThrough{k * 1e-5, 0});
  Eigen::ArrayXd heights = 4e-6 * pupil.sample.x.square();
  DiffractionWorkspace workspace;
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> gradients;
  return least_time(kBudget,
                    [&] {
                      heights[0] += 1e-12;  // another surface: nothing of the last one serves
                      evaluate_diffraction({pupil, kFocalLength, kWavelength}, heights, inside, 1, &workspace,
                                           &values, &gradients);
                    }) /
         wave_seconds(cells, rings);
}

double speed_of_products() {
  constexpr int kWeights = 64;
  const TermSet terms{0.5 * kCircle.diameter, zernike_modes(2, 24), {}, {}};
  const PupilSample cells = diffraction_pupil(kCircle, 0.7, kCircle.diameter / 64).sample;
  const SurfaceOperator surface(terms, cells, OperatorOptions{1, {}, {}});
  const std::vector<Eigen::ArrayXd> weights(kWeights, Eigen::ArrayXd::Constant(cells.size(), 1.0));
  return least_time(kBudget, [&] { surface.apply_transpose_heights(weights); }) /
         product_seconds(cells.size(), terms.size(), kWeights);
}

Speed speed_of_thread() {
  return {speed_of_rays(), speed_of_waves(kSmallGrid, 6), speed_of_waves(kLargeGrid, 2), speed_of_products()};
}

}  // namespace

// All threads at once, as in a fit: processors that share a core do half as much each.
FitRates machine_rates(int threads) {
  std::vector<Speed> speeds(std::size_t(std::max(1, threads)));
  parallel_for(speeds.size(), threads, [&](std::size_t k) { speeds[k] = speed_of_thread(); });
  Speed slowest;
  for (const Speed& speed : speeds)
    for (double Speed::*part : {&Speed::rays, &Speed::waves, &Speed::large, &Speed::products})
      slowest.*part = std::max(slowest.*part, speed.*part);
  FitRates rates = built_in_rates();
  const double rays = slowest.rays;
  rates.measured = {rays, rays, rays, rays, rays, rays, rays, rays, rays, rays};
  rates.waves = slowest.waves;
  rates.pace = {slowest.large / slowest.waves, slowest.products / slowest.waves, rays / slowest.waves};
  rates.source = "measured just now";
  return rates;
}

namespace {

/// Full fits of one set on one number of rays.
struct Fits {
  TermSet terms;
  PupilOptions rays;
  double count = 1, judged = 1;           // how many, and how many of these are judged
  std::optional<double> iterations = {};  // of each, where it is known better than of all
  bool not_shortened = false;             // takes as many although rays have led it
};

PupilOptions of_rays(const Task& task, std::int64_t rays) {
  PupilOptions pupil = task.trace.pupil;
  pupil.rays = rays;
  return pupil;
}

// fit_on_enough_rays (attempt.cpp) of `count` sets, of which `passing` are judged and tried on twice the
// rays.
void add_fits(const Task& task, const Groundwork& ground, const TermSet& terms, double count, double passing,
              std::optional<double> iterations, std::vector<Fits>* fits) {
  if (task.trace.pupil.rays || ground.use.model == FocusModel::kWaves) {
    fits->push_back({terms, task.trace.pupil, count, passing, iterations});
    return;
  }
  const std::int64_t first = first_rays(terms.size());
  fits->push_back({terms, of_rays(task, first), count, passing, iterations});
  fits->push_back({terms, of_rays(task, more_rays(first)), passing, passing, iterations});
}

TermSet terms_of(const Task& task, const Groundwork& ground, const TermsSpec& asked) {
  double captured = 0;
  return make_terms(task, ground, asked, &captured);
}

// Where searches by rays end: 18 of 15 to 28, 18 of 6 to 31, 24 of 17 to 74, 36 and 40 of 31 to 56 (studies
// of fits/). Where even the last order is short of the height variance, none passes by rays, and the search
// goes on to its end (95 of 27 to 100, fits/measured-zygo), as it does where the roughness has fewer modes
// than there are statistics to meet.
int typical_order(const OrderRange& range, bool few_modes) {
  if (range.high >= kLargestSearchedOrder || few_modes) return range.high;
  return std::max(2, int(std::lround(std::sqrt(double(range.low) * range.high))));
}

// Where the spectrum has all but a hundredth of its slope variance, to a tenth.
double end_of_slopes(const RadialPsd& psd) {
  const double all = psd_moments(psd).slope_variance, end = std::min(psd.f_max(), 1e12);
  const auto holds = [&](double f) { return psd_moments(psd.band(0, f)).slope_variance >= 0.99 * all; };
  double high = std::max(psd.f_min(), 1e-6);
  while (high < end && !holds(high)) high *= 1.1;
  return std::min(high, end);
}

// By waves of a spot without a core whose planes are near: the first set passed in all of 17 scenes of
// tests/stability, 44 to 2,946 cycles across.
bool first_plane_waves_do(const Groundwork& ground, const TargetSets& targets) {
  const double near = 1.001 * ground.default_planes() * ground.plane_unit();
  return ground.has_no_core() &&
         std::all_of(targets.fitted.begin(), targets.fitted.end(), [near](const Target& target) {
           return std::abs(plane_of_light(target.statistic).value_or(0)) <= near;
         });
}

// Plane waves where a search ends: a tenth more than cycles across that terms stand for. By waves 108 of 95,
// 91 of 92, 76 of 66, 38 of 52 and 43, 32 of 39 and 64, 256 of 125; by rays 64 of 48 and 77, 76 of 45, 181 of
// 100 and 148, 304 of 305 and 1536, 609 of 1139, and of thirteen from 300 on 108 to 609, half of them 181 to
// 304 (tests/stability).
int typical_modes(const Groundwork& ground, const TargetSets& targets) {
  if (first_plane_waves_do(ground, targets)) return kFewestModes;
  constexpr double kMostOfWaves = 256, kFewestOfRays = 64, kMostOfRays = 300, kPerCycle = 1.1;
  const double cycles = kPerCycle * 2 * ground.radius * end_of_slopes(*ground.term_psd);
  return int(std::lround(ground.use.model == FocusModel::kWaves
                             ? std::clamp(cycles, double(kFewestModes), kMostOfWaves)
                             : std::clamp(cycles, kFewestOfRays, kMostOfRays)));
}

// The sets that search_terms fits where every look is a full fit, if all from `end` on pass and all below
// stay as far away: without a pace, which depends on how fast they come nearer, and on the first grids, which
// some go beyond. Where few modes carry a deep spot, the last orders pass or none does, and the nearest is
// fitted once more or four times (six of tests/stability).
std::vector<Fits> strided_fits(const Task& task, const Groundwork& ground, const TargetSets& targets,
                               const OrderRange& range, bool few_modes) {
  std::map<int, TermSet> sets;
  TermTrials trials;
  trials.cells = [&](const TermsSpec& asked) {
    return first_cells(task, ground, terms_of(task, ground, asked), targets);
  };
  const Eigen::Index cells =
      range.wide ? 0 : trials.cells(zernikes_up_to(range.low, task.terms.covariance, range.first));
  const bool stay_away = few_modes && cells >= kVeryManyCells;
  const int orders = range.high - range.low;
  const double pass_from = orders >= kManyOrders && cells < kVeryManyCells ? kPassFromOfMany : kPassFrom;
  const int end = range.wide  ? typical_modes(ground, targets)
                  : stay_away ? range.high
                              : range.low + int(pass_from * orders);
  trials.confirm = [&](const TermsSpec& asked) {
    FrontierPoint point;
    point.terms = point.order = asked.zernike ? *asked.zernike->n_max : asked.fourier->count;
    const TermSet& terms = sets.emplace(point.order, terms_of(task, ground, asked)).first->second;
    point.rays = first_cells(task, ground, terms, targets);
    point.passes = point.order >= end;
    point.fitted_mismatch = kTypicalMismatch;
    return point;
  };
  std::vector<Fits> fits;
  const Frontier frontier = search_terms(task.terms.covariance, task.equivalence.margin, range, trials);
  for (auto point = frontier.points.rbegin(); point != frontier.points.rend(); ++point) {
    const bool narrowly = point->order == end || (!point->passes && point->order >= kNearlyFrom * end);
    const double judged = point->passes || narrowly ? 1 : 0;
    const bool again = narrowly && point->rays < kManyCells;  // a second look
    fits.push_back({sets.at(point->order), task.trace.pupil, 1, judged,
                    again                       ? kNarrowly
                    : narrowly || point->passes ? kWithEase
                                                : kFarOff});
  }
  if (stay_away)  // the nearest is judged, wherever it ends
    fits.push_back({fits.front().terms, task.trace.pupil, 1, 1, kNarrowly, true});
  return fits;
}

void add_near_miss(const Task& task, const TermSet& terms, double iterations, std::vector<Fits>* fits) {
  const std::int64_t rays = task.trace.pupil.rays.value_or(more_rays(first_rays(terms.size())));
  fits->push_back({terms, of_rays(task, rays), 1, 0, iterations});
}

// Few waves follow the rays that a width of the spot is seen by: their sets meet it on half a million of them
// and miss it by a percent on fresh ones, so that each goes on to the most, mostly in three to twenty steps,
// and the first that passes there is taken (four of tests/stability, with other
// seeds among them, of 220 to 590 cycles; of 62 the first set does).
void add_fits_on_every_number_of_rays(const Task& task, const TermSet& terms, std::vector<Fits>* fits) {
  for (std::int64_t rays = first_rays(terms.size()); rays <= kMostAutomaticRays; rays = more_rays(rays))
    fits->push_back({terms, of_rays(task, rays), 1, 1, kIterations});
}

bool asks_for_width_of_spot(const TargetSets& targets) {
  return std::any_of(targets.fitted.begin(), targets.fitted.end(),
                     [](const Target& target) { return std::holds_alternative<SpotFwhm>(target.statistic); });
}

// Plane waves by rays: from few of them on, doubling to where they pass, then twice in between.
std::vector<Fits> plane_wave_fits(const Task& task, const Groundwork& ground, const TargetSets& targets) {
  constexpr int kFirstSetDoes = 128;  // modes of 116 cycles, between the 62 and the 220
  std::vector<Fits> fits;
  const int end = typical_modes(ground, targets);
  if (!task.trace.pupil.rays && end > kFirstSetDoes && asks_for_width_of_spot(targets)) {
    for (int count = kFewestModes; count < 2 * end; count *= 2)
      add_fits_on_every_number_of_rays(task, terms_of(task, ground, plane_waves(count)), &fits);
    return fits;
  }
  for (int count = kFewestModes; count < end; count *= 2)
    add_fits(task, ground, terms_of(task, ground, plane_waves(count)), 1, 0, kPlaneWaveIterations, &fits);
  const TermSet last = terms_of(task, ground, plane_waves(end));
  add_fits(task, ground, last, kPassing + 1, kPassing, kPlaneWaveIterations, &fits);
  add_near_miss(task, last, kPlaneWaveNearMiss, &fits);
  return fits;
}

// The sets of a search: short ones by `screens`, full ones by the return value.
std::vector<Fits> search_fits(const Task& task, const Groundwork& ground, const TargetSets& targets,
                              std::vector<Fits>* screens) {
  const bool waves = ground.use.model == FocusModel::kWaves;
  const OrderRange range = expected_orders(ground);
  const bool few_modes = ground.numbers.n_eff < double(targets.fitted.size());
  if (waves) return strided_fits(task, ground, targets, range, few_modes);
  if (range.wide) return plane_wave_fits(task, ground, targets);
  const auto zernikes = [&](int order) {
    return terms_of(task, ground, zernikes_up_to(order, task.terms.covariance, range.first));
  };
  const int end = typical_order(range, few_modes);
  for (int order = 2; order < end; order = next_order(order)) {
    const TermSet terms = zernikes(order);
    screens->push_back({terms, of_rays(task, screening_rays(terms.size())), 1, 0});
  }
  std::vector<Fits> fits;
  const Closely& closely = few_modes ? kCloselyOfFewModes : kClosely;
  add_fits(task, ground, zernikes(end), closely.sets, kPassing, kClimbIterations, &fits);
  add_near_miss(task, zernikes(end), closely.near_miss_iterations, &fits);
  return fits;
}

// Of terms that a study names, where more is known than what is typical. Those that lack the band take as
// many as those that are few; plane waves by rays, where a search would end with as many, as its sets do.
std::optional<double> iterations_of_asked(const Task& task, const Groundwork& ground, const TermSet& terms,
                                          const TargetSets& targets) {
  constexpr double kLacking = 0.9, kNearItsEnd = 1.5;
  if (!ground.psd) return std::nullopt;
  if (ground.use.model == FocusModel::kRays) {
    const bool near_its_end = !terms.fourier.empty() &&
                              double(terms.fourier.size()) <= kNearItsEnd * typical_modes(ground, targets);
    return near_its_end ? std::optional(kPlaneWaveIterations) : std::nullopt;
  }
  double captured = 1;
  make_terms(task, ground, task.terms, &captured);
  return captured < kLacking ? std::optional(kFewTermsIterations) : std::nullopt;
}

}  // namespace

FitPrediction predict_fit(const Task& task, const Groundwork& ground, const TermSet& terms,
                          const TargetSets& targets, const FitRates& r, int threads) {
  const bool rays = ground.use.model == FocusModel::kRays;
  // A chart is of rays: of waves it only tells how fast the machine is.
  const double speed = r.waves > 0                ? r.waves
                       : r.expected.iteration > 0 ? r.measured.iteration / r.expected.iteration
                                                  : 1;
  const auto rate = [&](double FitWork::*stage) {
    return !rays ? speed : r.expected.*stage > 0 ? r.measured.*stage / r.expected.*stage : 0.0;
  };
  FitPrediction p;
  const auto add = [&p](const char* stage, double seconds) {
    p.stages.emplace_back(stage, seconds);
    p.seconds += seconds;
  };
  if (ground.all_scatters()) {
    const TermSet none = terms_of(task, ground, {});
    const FitWork work = fit_work(task, ground, none, task.trace.pupil, targets, threads, r.pace);
    add("targets", work.targets * speed);
    add("draws", work.draws * speed);
    add("scatter", work.scatter * speed);
    return p;
  }
  p.search = task.terms.automatic() && ground.psd;
  p.iterations_known = r.iterations_known && rays && !p.search;
  const bool few = 2 * std::size_t(terms.size()) <= targets.fitted.size() + targets.guides.size();
  std::vector<Fits> screens, fits;
  if (p.search)
    fits = search_fits(task, ground, targets, &screens);
  else
    add_fits(task, ground, terms, 1, 1,
             p.iterations_known || few ? std::nullopt : iterations_of_asked(task, ground, terms, targets),
             &fits);
  p.iterations = p.search ? (rays ? fits.front().iterations.value_or(kClimbIterations) : kWithEase)
                 : p.iterations_known ? r.iterations
                 : few                ? kFewTermsIterations
                       : fits.front().iterations.value_or(rays ? r.iterations : kWaveIterations);
  p.more_rays = !task.trace.pupil.rays && ground.use.model != FocusModel::kWaves;

  const int most = std::max(1, task.fit.max_iterations);
  const double iterations = std::min(p.iterations, double(most));
  double screening = 0, prior = 0, solving = 0, ends = 0, fresh = 0;
  for (const Fits& fit : screens) {
    const FitWork work = fit_work(task, ground, fit.terms, fit.rays, targets, threads, r.pace);
    screening +=
        work.prior * rate(&FitWork::prior) +
        (work.iteration * std::min(kShortIterations, double(most)) + work.ends) * rate(&FitWork::iteration);
  }
  FitWork last;
  for (const Fits& fit : fits) {
    last = fit_work(task, ground, fit.terms, fit.rays, targets, threads, r.pace);
    prior += fit.count * last.prior * rate(&FitWork::prior);
    // Who names terms may have named too few.
    const double led = !(p.search && fit.judged > 0) ? kLedAndFarOff
                       : fit.terms.fourier.empty()   ? kLedAndPassing
                                                     : kPlaneWavesLed;
    const bool is_led = last.led > 0 && (p.search || !few);
    const double steps = is_led && !fit.not_shortened ? led : fit.iterations.value_or(iterations);
    if (is_led && !fit.not_shortened) p.iterations = led;
    solving += fit.count * std::min(steps, double(most)) * last.iteration * rate(&FitWork::iteration);
    ends += fit.count * (last.led + last.ends) * rate(&FitWork::iteration);
    fresh += fit.judged * last.fresh * rate(&FitWork::fresh);
  }
  add("targets", last.targets * rate(&FitWork::targets));
  if (!screens.empty()) add("short fits", screening);
  add("prior", prior);
  add("iterations", solving);
  add("start and result", ends);
  add("fresh rays", fresh);
  if (last.judgement > 0) add("needed model", last.judgement * speed);
  if (last.realisations > 0) add("realisations", last.realisations * rate(&FitWork::iteration));
  if (last.scatter > 0) add("scatter", last.scatter * speed);
  add("zones", last.zones * rate(&FitWork::zones));
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
