#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "aberfit/method/constants.h"
#include "chart_families.h"

namespace aberfit::internal {
namespace {

constexpr double kShares[] = {0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 0.9999};
constexpr int kLargestOrder = 120;
constexpr int kModeCounts[] = {50, 100, 200, 400, 800, 1600, 3200, 6400, 12800, 20000};
// Of the statistics of plane waves, and of their times: in the mean over draws, draws matter more than rays.
constexpr std::int64_t kModeRays = 1024, kModeTimeRays = 8192;

std::uint64_t draw_seed(const ChartBench& bench, std::size_t draw) {
  return RandomStream(bench.task.fit.seed, "chart-draws").bits(draw);
}

// Columns: draws. Each is evaluated on one thread, so that they can run side by side.
Eigen::MatrixXd statistics_of_draws(const ChartBench& bench, const TermSet& terms, const PupilSample& pupil,
                                    const std::vector<Eigen::VectorXd>& coefficients) {
  Eigen::MatrixXd values(Eigen::Index(bench.statistics.size()), Eigen::Index(coefficients.size()));
  parallel_for(coefficients.size(), bench.threads, [&](std::size_t d) {
    ChartTrace at(bench, terms, pupil, 1);
    values.col(Eigen::Index(d)) = at.exact(coefficients[d], bench.statistics);
  });
  return values;
}

// Time of values and full Jacobian; NaN where they do not exist.
void time_jacobian(const ChartBench& bench, ChartTrace* at, const Eigen::VectorXd& c, double budget,
                   ChartRow* row) {
  Eigen::VectorXd values;
  Eigen::MatrixXd jacobian;
  bool exists = true;
  const ChartTime time = measure_time(budget, [&] {
    exists = at->smooth(c, bench.statistics, bench.smoothing, &values, &jacobian) && exists;
  });
  if (exists) set_time(time, row);
  at->set_sizes(row);
}

// The first EE radius's place among the statistics: what notes speak of. Negative: none.
Eigen::Index spoken_of(const std::vector<Statistic>& statistics) {
  Eigen::Index found = -1;
  for (std::size_t k = 0; k < statistics.size(); ++k)
    if (const auto* ee = std::get_if<EncircledEnergyRadius>(&statistics[k]);
        ee && ee->dz == 0 && (found < 0 || ee->fraction == 0.9))
      found = Eigen::Index(k);
  return found;
}

double seconds_of_probe(const ChartBench& bench, const TermSet& terms, const PupilSample& pupil,
                        const Eigen::VectorXd& c) {
  ChartTrace at(bench, terms, pupil, 1);
  return measure_time(0, [&] { at.exact(c, bench.statistics); }).median;
}

// Shares of the height variance that can move, by radial order.
class CapturedShare {
 public:
  explicit CapturedShare(const Groundwork& ground)
      : psd_(*ground.term_psd),
        radius_(ground.radius),
        movable_(1 - captured_fraction(psd_, radius_, 0, 1)) {}
  double operator()(int n) const { return captured_fraction(psd_, radius_, 2, n) / movable_; }
  int order_of(double share) const { return captured_order(psd_, radius_, share * movable_, kLargestOrder); }

 private:
  const RadialPsd& psd_;
  double radius_, movable_;
};

TermSet zernikes_to(const ChartBench& bench, int order) {
  return {bench.ground.radius, zernike_modes(2, order), {}, {}};
}

// Highest order of the study's own Zernikes; 0 without any.
int order_of_today(const ChartBench& bench) {
  return bench.terms.zernike.empty() ? 0 : bench.terms.zernike.back().n;
}

std::vector<int> orders_to_try(const CapturedShare& captured, int today) {
  std::set<int> orders = {today};
  for (const double share : kShares) orders.insert(captured.order_of(share));
  return {orders.lower_bound(2), orders.end()};
}

// Draws up to an order beyond all that are tried, which those are compared with.
struct OrderDraws {
  int highest = 0;
  double left_out = 0;  // share of the height variance beyond it
  TermSet terms;
  PupilSample pupil;
  std::vector<Eigen::VectorXd> coefficients;
};

// As many draws as the budget allows at the highest order; fewer orders before fewer than four draws.
OrderDraws affordable_order_draws(const ChartBench& bench, double seconds, std::vector<int>* orders) {
  constexpr std::int64_t kProbe = 4096;
  constexpr std::size_t kMostDraws = 32, kFewestDraws = 4;
  const Task& task = bench.task;
  OrderDraws result;
  result.pupil = make_pupil(task.aperture, pupil_of_at_most(task, 4 * kProbe));
  CoefficientPrior prior;
  std::size_t draws = 0;
  while (true) {
    result.highest = orders->back() + std::max(2, orders->back() / 8);
    result.terms = zernikes_to(bench, result.highest);
    prior = make_prior(result.terms, *bench.ground.prior_psd, task.terms.covariance);
    const double once = seconds_of_probe(bench, result.terms, result.pupil,
                                         prior.colour(draw_white(prior.size(), draw_seed(bench, 0))));
    draws = std::size_t(std::min(double(kMostDraws),
                                 0.5 * seconds * bench.threads / (0.6 * double(orders->size() + 1) * once)));
    if (draws >= kFewestDraws || orders->size() < 3 || orders->back() == order_of_today(bench)) break;
    orders->pop_back();
  }
  draws = std::max(draws, kFewestDraws);
  for (std::size_t d = 0; d < draws; ++d)
    result.coefficients.push_back(prior.colour(draw_white(prior.size(), draw_seed(bench, d))));
  return result;
}

// How far the draws' mean of the statistic spoken of is off its target; empty without one.
std::string note_of_mean(const ChartBench& bench, const Eigen::MatrixXd& values) {
  const Eigen::Index k = spoken_of(bench.statistics);
  if (k < 0) return "";
  const Eigen::ArrayXd ratio =
      values.row(k).transpose().array() / bench.targets.fitted[std::size_t(k)].value - 1;
  const double mean = ratio.mean(), count = double(values.cols());
  const double sigma = std::sqrt((ratio - mean).square().sum() / (count * (count - 1)));
  return fmt::format("; mean {} of the draws {:+.2g} % off its target, +-{:.2g} %",
                     statistic_name(bench.statistics[std::size_t(k)]), 100 * mean, 100 * sigma);
}

// The draws to order n against `truth`, their statistics to the highest order. budget: for timing [s].
ChartRow order_row(const ChartBench& bench, const OrderDraws& draws, int n, const Eigen::MatrixXd& truth,
                   double budget) {
  const TermSet lower = zernikes_to(bench, n);  // a prefix of the highest set: OSA order
  std::vector<Eigen::VectorXd> coefficients;
  for (const Eigen::VectorXd& c : draws.coefficients) coefficients.emplace_back(c.head(lower.size()));
  const Eigen::MatrixXd values = statistics_of_draws(bench, lower, draws.pupil, coefficients);
  ChartRow row = row_of("Zernikes", "n_max", n);
  set_errors(statistic_errors(values.rowwise().mean(), truth.rowwise().mean(), bench.statistics),
             fmt::format("the same {} draws to n = {}", draws.coefficients.size(), draws.highest),
             draws.left_out, &row);
  row.note = note_of_mean(bench, values);
  row.is_default = n == order_of_today(bench) && bench.terms.fourier.empty() && bench.terms.spherical.empty();
  ChartTrace at(bench, lower, draws.pupil, bench.threads);
  time_jacobian(bench, &at, coefficients.front(), budget, &row);
  return row;
}

}  // namespace

ChartFamily chart_orders(const ChartBench& bench, double seconds) {
  ChartFamily family = family_of("zernike-order", "Zernike orders",
                                 "largest change of the draws' mean statistics without higher orders",
                                 "values and full Jacobian by adjoints", bench.margin());
  if (!bench.ground.prior_psd) {
    family.skipped = "There is no roughness whose orders could be left out.";
    return family;
  }
  const CapturedShare captured(bench.ground);
  std::vector<int> orders = orders_to_try(captured, order_of_today(bench));
  OrderDraws draws = affordable_order_draws(bench, seconds, &orders);
  draws.left_out = 1 - captured(draws.highest);
  const Eigen::MatrixXd truth = statistics_of_draws(bench, draws.terms, draws.pupil, draws.coefficients);
  for (const int n : orders) {
    bench.say(fmt::format("chart: Zernikes to n = {}, {} draws", n, draws.coefficients.size()));
    ChartRow row = order_row(bench, draws, n, truth, 0.5 * seconds / double(orders.size()));
    row.note = fmt::format("captures {:.4g} % of the height variance", 100 * captured(n)) + row.note;
    family.rows.push_back(std::move(row));
  }
  return family;
}

namespace {

// Statistics of draws of plane waves, relative to their targets, with the chance of the draws' slopes taken
// out: the RMS slope of a draw over the aperture is known, and so is its mean (control variate).
struct ModeDraws {
  Eigen::VectorXd mean, standard_error;
  double spread = 0;  // of the statistic spoken of
};

ModeDraws draw_modes(const ChartBench& bench, const TermSet& terms, const CoefficientPrior& prior,
                     const PupilSample& pupil, std::size_t draws, std::size_t first) {
  const auto count = Eigen::Index(draws);
  Eigen::MatrixXd values(Eigen::Index(bench.statistics.size()), count);
  Eigen::ArrayXd slope(count);
  parallel_for(draws, bench.threads, [&](std::size_t d) {
    ChartTrace at(bench, terms, pupil, 1);
    const Eigen::VectorXd c = prior.colour(draw_white(prior.size(), draw_seed(bench, first + d)));
    values.col(Eigen::Index(d)) = at.exact(c, bench.statistics);
    slope[Eigen::Index(d)] = mean_square_slope(at.pupil(), at.field());
  });
  // Mean square slope of the set: A and B have the same variance.
  double expected = 0;
  for (const CoefficientPrior::Block& block : prior.blocks())
    for (std::size_t i = 0; i < block.index.size(); ++i) {
      const FourierMode mode = terms.fourier[std::size_t(block.index[i] / 2)];
      const double k2 = 4 * std::numbers::pi * std::numbers::pi * (mode.fx * mode.fx + mode.fy * mode.fy);
      expected += 0.5 * k2 * block.factor.row(Eigen::Index(i)).squaredNorm();
    }
  const Eigen::ArrayXd control = slope / expected - 1;
  const Eigen::ArrayXd centred = control - control.mean();
  ModeDraws result{Eigen::VectorXd(values.rows()), Eigen::VectorXd(values.rows()), 0};
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    const Eigen::ArrayXd v = values.row(k).transpose();
    const double weight = (v * centred).sum() / centred.square().sum();
    const Eigen::ArrayXd left = v - weight * control;
    result.mean[k] = left.mean();
    result.standard_error[k] =
        std::sqrt((left - left.mean()).square().sum() / (double(count) * double(count - 1)));
    if (k == spoken_of(bench.statistics))
      result.spread = std::sqrt((v - v.mean()).square().sum() / double(count - 1)) / v.mean();
  }
  return result;
}

// Sets of plane waves over the whole band, by their number.
struct WaveSets {
  const RadialPsd& psd;
  double radius;
  std::uint64_t seed;

  TermSet terms(int count) const { return {radius, {}, fourier_modes(psd, count, seed), {}}; }
  CoefficientPrior prior(const TermSet& terms) const { return make_prior(terms, psd, CovarianceKind::kFull); }
};

// Number of plane waves of a study that has nothing else.
std::optional<int> count_of_today(const ChartBench& bench) {
  if (!bench.task.terms.fourier || !bench.terms.zernike.empty() || bench.terms.fourier_pitch > 0)
    return std::nullopt;
  return bench.task.terms.fourier->count.value_or(law::kUsualWaves);
}

std::vector<int> counts_to_try(const std::optional<int>& today) {
  std::set<int> counts(std::begin(kModeCounts), std::end(kModeCounts));
  if (today) counts.insert(*today);
  return {counts.begin(), counts.end()};
}

// How many draws of every count the budget allows; counts that it does not reach are left out.
std::size_t affordable_mode_draws(const ChartBench& bench, const WaveSets& sets, const PupilSample& pupil,
                                  double seconds, std::vector<int>* counts) {
  constexpr std::size_t kMostDraws = 256, kFewestDraws = 24;
  const auto draw_seconds = [&](int count) {
    const TermSet terms = sets.terms(count);
    const CoefficientPrior prior = sets.prior(terms);
    return seconds_of_probe(bench, terms, pupil, prior.colour(draw_white(prior.size(), 1)));
  };
  // One draw costs a + b count.
  const double few = draw_seconds(50), more = draw_seconds(1600);
  const double per_mode = std::max(0.0, more - few) / 1550;
  while (true) {
    double once = 0;  // one draw of every count, and of the reference
    for (const int count : *counts) once += few + per_mode * count;
    once += few + per_mode * counts->back();
    const double affordable = 0.6 * seconds * bench.threads / once;
    if (affordable >= double(kFewestDraws) || counts->size() < 4)
      return std::size_t(std::clamp(affordable, double(kFewestDraws), double(kMostDraws)));
    counts->pop_back();
  }
}

// Largest standard error of the difference of two means, relative as errors are.
double chance(const ModeDraws& truth, const ModeDraws& here, const std::vector<Statistic>& statistics) {
  double largest = 0;
  for (Eigen::Index k = 0; k < truth.mean.size(); ++k)
    if (const double scale = statistic_scale(statistics[std::size_t(k)], truth.mean[k]); scale > 0)
      largest = std::max(largest, std::hypot(truth.standard_error[k], here.standard_error[k]) / scale);
  return largest;
}

// Draws of so many waves against `truth`, the mean of other draws of the finest set.
ChartRow mode_row(const ChartBench& bench, int count, const ModeDraws& here, const ModeDraws& truth,
                  const std::string& reference) {
  ChartRow row = row_of("plane waves", "count", count);
  // The largest of many would be chance.
  const double rms = statistic_errors(here.mean, truth.mean, bench.statistics).rms;
  set_errors({rms}, reference, chance(truth, here, bench.statistics), &row);
  if (const Eigen::Index k = spoken_of(bench.statistics); k >= 0)
    row.note = fmt::format("{} of a draw spreads by {:.3g} %",
                           statistic_name(bench.statistics[std::size_t(k)]), 100 * here.spread);
  return row;
}

}  // namespace

ChartFamily chart_modes(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  ChartFamily family = family_of("fourier-count", "Number of plane waves for the whole band",
                                 "RMS relative error of the mean statistics of draws",
                                 "values and full Jacobian by adjoints", bench.margin());
  if (!bench.ground.prior_psd || !std::isfinite(bench.ground.prior_psd->f_max())) {
    family.skipped = "There is no roughness with a band that plane waves could sample.";
    return family;
  }
  const std::optional<int> today = count_of_today(bench);
  const WaveSets sets{*bench.ground.prior_psd, bench.ground.radius, task.fit.seed};
  std::vector<int> counts = counts_to_try(today);
  const PupilSample pupil = make_pupil(task.aperture, pupil_of_at_most(task, kModeRays));
  const PupilSample time_pupil = make_pupil(task.aperture, pupil_of_at_most(task, kModeTimeRays));
  const std::size_t draws = affordable_mode_draws(bench, sets, pupil, seconds, &counts);

  const TermSet finest = sets.terms(counts.back());
  bench.say(fmt::format("chart: {} plane waves, {} draws", counts.back(), draws));
  const ModeDraws truth = draw_modes(bench, finest, sets.prior(finest), pupil, draws, draws);  // other draws
  const std::string reference =
      fmt::format("{} plane waves, {} other draws on {} rays", counts.back(), draws, pupil.size());
  for (const int count : counts) {
    bench.say(fmt::format("chart: {} plane waves, {} draws", count, draws));
    const TermSet terms = sets.terms(count);
    const CoefficientPrior prior = sets.prior(terms);
    ChartRow row = mode_row(bench, count, draw_modes(bench, terms, prior, pupil, draws, 0), truth, reference);
    row.is_default = today == count;
    ChartTrace at(bench, terms, time_pupil, bench.threads);
    time_jacobian(bench, &at, prior.colour(draw_white(prior.size(), draw_seed(bench, 0))),
                  0.4 * seconds / double(counts.size()), &row);
    family.rows.push_back(std::move(row));
  }
  family.remark =
      "Differences below error_of_reference are chance. Too few waves show first in the spread of the draws "
      "(see "
      "the notes), which a fit to targets takes out.";
  return family;
}

}  // namespace aberfit::internal
