#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/parallel.h"
#include "aberfit/core/random.h"
#include "chart_families.h"

namespace aberfit {
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
  row->rays = at->pupil().size();
  row->terms = c.size();
  row->statistics = std::int64_t(bench.statistics.size());
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

}  // namespace

ChartFamily chart_orders(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  ChartFamily family{"zernike-order",
                     "Zernike orders",
                     "largest change of the draws' mean statistics without higher orders",
                     "values and full Jacobian by adjoints",
                     task.equivalence.margin,
                     "margin of equivalence",
                     {},
                     "",
                     ""};
  if (!bench.scene.prior_psd) {
    family.skipped = "There is no roughness whose orders could be left out.";
    return family;
  }
  const RadialPsd& psd = *bench.scene.psd;
  const double radius = bench.scene.radius, movable = 1 - captured_fraction(psd, radius, 0, 1);
  const auto captured = [&](int n) { return captured_fraction(psd, radius, 2, n) / movable; };
  std::vector<int> orders;
  for (const double share : kShares)
    orders.push_back(captured_order(psd, radius, share * movable, kLargestOrder));
  int today = 0;
  if (!bench.terms.zernike.empty()) today = bench.terms.zernike.back().n;
  if (today > 0) orders.push_back(today);
  std::sort(orders.begin(), orders.end());
  orders.erase(std::unique(orders.begin(), orders.end()), orders.end());
  std::erase_if(orders, [](int n) { return n < 2; });
  // What all are compared with goes beyond them.
  const auto beyond = [&] { return orders.back() + std::max(2, orders.back() / 8); };

  // Draws and rays that the budget allows at the highest order; fewer orders before fewer than four draws.
  constexpr std::int64_t kProbe = 4096;
  constexpr std::size_t kMostDraws = 32, kFewestDraws = 4;
  TermSet terms;
  terms.radius = radius;
  CoefficientPrior prior;
  std::size_t draws = 0;
  const PupilSample pupil = make_pupil(task.aperture, pupil_of_at_most(task, 4 * kProbe));
  const ChartClock clock(seconds);
  while (true) {
    terms.zernike = zernike_modes(2, beyond());
    prior = make_prior(terms, *bench.scene.prior_psd, task.terms.covariance);
    const double once =
        seconds_of_probe(bench, terms, pupil, prior.colour(draw_white(prior.size(), draw_seed(bench, 0))));
    draws = std::size_t(std::min(double(kMostDraws),
                                 0.5 * seconds * bench.threads / (0.6 * double(orders.size() + 1) * once)));
    if (draws >= kFewestDraws || orders.size() < 3 || orders.back() == today) break;
    orders.pop_back();
  }
  draws = std::max(draws, kFewestDraws);

  std::vector<Eigen::VectorXd> full;
  for (std::size_t d = 0; d < draws; ++d)
    full.push_back(prior.colour(draw_white(prior.size(), draw_seed(bench, d))));
  const Eigen::MatrixXd truth = statistics_of_draws(bench, terms, pupil, full);
  const int highest = beyond();
  const double left_out = 1 - captured(highest);
  for (const int n : orders) {
    bench.say(fmt::format("chart: Zernikes to n = {}, {} draws", n, draws));
    TermSet lower;
    lower.radius = radius;
    lower.zernike = zernike_modes(2, n);  // a prefix of the highest set: OSA order
    std::vector<Eigen::VectorXd> coefficients;
    for (const Eigen::VectorXd& c : full) coefficients.emplace_back(c.head(lower.size()));
    const Eigen::MatrixXd values = statistics_of_draws(bench, lower, pupil, coefficients);
    ChartRow row;
    row.family = family.name;
    row.method = "Zernikes";
    row.parameter = "n_max";
    row.unit = "1";
    row.value = n;
    const StatisticErrors errors =
        statistic_errors(values.rowwise().mean(), truth.rowwise().mean(), bench.statistics);
    row.reference = fmt::format("the same {} draws to n = {}", draws, highest);
    row.error_of_reference = left_out;
    row.note = fmt::format("captures {:.4g} % of the height variance", 100 * captured(n));
    if (const Eigen::Index k = spoken_of(bench.statistics); k >= 0) {
      const Eigen::ArrayXd ratio =
          values.row(k).transpose().array() / bench.targets.fitted[std::size_t(k)].value - 1;
      const double mean = ratio.mean(), count = double(draws);
      const double sigma = std::sqrt((ratio - mean).square().sum() / (count * (count - 1)));
      row.note += fmt::format("; mean {} of the draws {:+.2g} % off its target, +-{:.2g} %",
                              statistic_name(bench.statistics[std::size_t(k)]), 100 * mean, 100 * sigma);
    }
    row.is_default = n == today && bench.terms.fourier.empty() && bench.terms.spherical.empty();
    row.error = errors.worst;
    row.error_rms = errors.rms;
    ChartTrace at(bench, lower, pupil, bench.threads);
    time_jacobian(bench, &at, coefficients.front(), 0.5 * seconds / double(orders.size()), &row);
    family.rows.push_back(std::move(row));
  }
  mark_rows(&family);
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
    slope[Eigen::Index(d)] =
        (at.pupil().weight * (at.field().slope_x.square() + at.field().slope_y.square())).sum();
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

}  // namespace

ChartFamily chart_modes(const ChartBench& bench, double seconds) {
  const Task& task = bench.task;
  ChartFamily family{"fourier-count",
                     "Number of plane waves for the whole band",
                     "RMS relative error of the mean statistics of draws",
                     "values and full Jacobian by adjoints",
                     task.equivalence.margin,
                     "margin of equivalence",
                     {},
                     "",
                     ""};
  if (!bench.scene.prior_psd || !std::isfinite(bench.scene.prior_psd->f_max())) {
    family.skipped = "There is no roughness with a band that plane waves could sample.";
    return family;
  }
  const RadialPsd& psd = *bench.scene.prior_psd;
  const bool own = task.terms.fourier && bench.terms.zernike.empty();
  const FourierSampling sampling = own ? task.terms.fourier->sampling : FourierSampling::kLog;
  const auto set_of = [&](int count) {
    TermSet terms;
    terms.radius = bench.scene.radius;
    terms.fourier = fourier_modes(psd, count, sampling, task.fit.seed);
    return terms;
  };
  const auto prior_of = [&](const TermSet& terms) { return make_prior(terms, psd, CovarianceKind::kFull); };
  std::vector<int> counts(std::begin(kModeCounts), std::end(kModeCounts));
  if (own) counts.push_back(task.terms.fourier->count);
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  const PupilSample pupil = make_pupil(task.aperture, pupil_of_at_most(task, kModeRays));
  const PupilSample time_pupil = make_pupil(task.aperture, pupil_of_at_most(task, kModeTimeRays));

  // One draw costs a + b count. Counts that the budget does not reach are left out.
  constexpr std::size_t kMostDraws = 256, kFewestDraws = 24;
  const auto draw_seconds = [&](int count) {
    const TermSet terms = set_of(count);
    const CoefficientPrior prior = prior_of(terms);
    return seconds_of_probe(bench, terms, pupil, prior.colour(draw_white(prior.size(), 1)));
  };
  const double few = draw_seconds(50), more = draw_seconds(1600);
  const double per_mode = std::max(0.0, more - few) / 1550;
  std::size_t draws = kFewestDraws;
  while (true) {
    double once = 0;  // one draw of every count, and of the reference
    for (const int count : counts) once += few + per_mode * count;
    once += few + per_mode * counts.back();
    const double affordable = 0.6 * seconds * bench.threads / once;
    draws = std::size_t(std::clamp(affordable, double(kFewestDraws), double(kMostDraws)));
    if (affordable >= double(kFewestDraws) || counts.size() < 4) break;
    counts.pop_back();
  }

  const TermSet finest = set_of(counts.back());
  bench.say(fmt::format("chart: {} plane waves, {} draws", counts.back(), draws));
  const ModeDraws truth = draw_modes(bench, finest, prior_of(finest), pupil, draws, draws);  // other draws
  for (const int count : counts) {
    bench.say(fmt::format("chart: {} plane waves, {} draws", count, draws));
    const TermSet terms = set_of(count);
    const CoefficientPrior prior = prior_of(terms);
    const ModeDraws here = draw_modes(bench, terms, prior, pupil, draws, 0);
    ChartRow row;
    row.family = family.name;
    row.method = "plane waves";
    row.parameter = "count";
    row.unit = "1";
    row.value = count;
    const StatisticErrors errors = statistic_errors(here.mean, truth.mean, bench.statistics);
    row.error = errors.rms;  // the largest of many would be chance
    row.error_rms = errors.rms;
    row.reference =
        fmt::format("{} plane waves, {} other draws on {} rays", counts.back(), draws, pupil.size());
    row.error_of_reference = 0;
    for (Eigen::Index k = 0; k < truth.mean.size(); ++k)
      if (const double scale = statistic_scale(bench.statistics[std::size_t(k)], truth.mean[k]); scale > 0)
        row.error_of_reference = std::max(
            row.error_of_reference, std::hypot(truth.standard_error[k], here.standard_error[k]) / scale);
    if (const Eigen::Index k = spoken_of(bench.statistics); k >= 0)
      row.note = fmt::format("{} of a draw spreads by {:.3g} %",
                             statistic_name(bench.statistics[std::size_t(k)]), 100 * here.spread);
    row.is_default = own && count == task.terms.fourier->count;
    ChartTrace at(bench, terms, time_pupil, bench.threads);
    time_jacobian(bench, &at, prior.colour(draw_white(prior.size(), draw_seed(bench, 0))),
                  0.4 * seconds / double(counts.size()), &row);
    family.rows.push_back(std::move(row));
  }
  family.remark =
      "Differences below error_of_reference are chance. Too few waves show first in the spread of the draws "
      "(see "
      "the notes), which a fit to targets takes out.";
  mark_rows(&family);
  return family;
}

}  // namespace aberfit
