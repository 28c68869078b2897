#include "aberfit/method/all_scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/random.h"
#include "aberfit/method/judge.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"

namespace aberfit {
namespace {

// What surfaces of the whole PSD are drawn from.
struct Drawing {
  std::shared_ptr<const BandSplit> split;
  TermSet terms;
  CoefficientPrior prior;
};

Drawing drawing_of(const FitCase& of) {
  const Task& task = of.task;
  Drawing drawing;
  drawing.split = drawn_split(task, of.ground);
  drawing.terms.radius = of.ground.radius;
  drawing.terms.fourier =
      fourier_modes(drawing.split->low(), kDrawnWaves, FourierSampling::kGrid, task.fit.seed);
  drawing.prior = CoefficientPrior(
      drawing.terms.size(), make_prior(drawing.terms, drawing.split->low(), CovarianceKind::kFull).blocks());
  return drawing;
}

FreshStatistics statistics_of_draws(const FitCase& of, const std::vector<Statistic>& statistics,
                                    Warnings* warnings) {
  const Drawing drawing = drawing_of(of);
  const Workbench bench(of.task, FocusModel::kWaves, {},
                        wave_pitch(of.task, drawing.terms, all_targets(of.targets), drawing.split.get()),
                        drawing.terms, of.context.threads, drawing.split);
  Eigen::MatrixXd values(Eigen::Index(statistics.size()), kScatterDraws);
  for (int d = 0; d < kScatterDraws; ++d) {
    of.context.say(fmt::format("draw {} of {}", d + 1, kScatterDraws));
    const std::uint64_t seed = RandomStream(of.task.fit.seed, "scatter-draws").bits(std::uint64_t(d));
    values.col(d) = bench.exact(of.task, drawing.prior.colour(draw_white(drawing.prior.size(), seed)),
                                statistics, of.context.threads, d == 0 ? warnings : nullptr);
  }
  FreshStatistics fresh;
  fresh.rays = bench.pupil.size();
  fresh.value = values.rowwise().mean();
  fresh.standard_error =
      ((values.colwise() - fresh.value).rowwise().squaredNorm() / (kScatterDraws * (kScatterDraws - 1.0)))
          .cwiseSqrt();
  fresh.degrees_of_freedom = kScatterDraws - 1;
  return fresh;
}

std::shared_ptr<const TermPlan> no_terms(const FitCase& of) {
  TermPlan plan;
  plan.asked.automatic = true;
  plan.terms.radius = of.ground.radius;
  plan.prior = CoefficientPrior(0, {});
  return std::make_shared<const TermPlan>(std::move(plan));
}

}  // namespace

std::shared_ptr<const BandSplit> drawn_split(const Task& task, const Groundwork& ground) {
  const RadialPsd& psd = *ground.psd;
  const double low = std::max(psd.f_min(), std::isfinite(psd.f_max()) ? 1e-3 * psd.f_max() : 0.0);
  const double cut =
      std::clamp(kDrawnCycles / (2 * ground.radius), std::min(2 * low, psd.f_max()), psd.f_max());
  return std::make_shared<const BandSplit>(psd, cut, task.mirror, task.aperture, task.wavelength,
                                           ground.mean_spot);
}

Attempt judge_all_scatter(const FitCase& of) {
  const int threads = of.context.threads;
  Attempt attempt;
  attempt.terms = no_terms(of);
  FitOutcome& result = attempt.result;
  result = outcome_of(of, make_plan(of.task, attempt.terms));
  const TermSet& none = attempt.terms->terms;
  attempt.bench = std::make_shared<const Workbench>(
      of.task, FocusModel::kWaves, PupilOptions{},
      wave_pitch(of.task, none, all_targets(of.targets), of.ground.split.get()), none, threads,
      of.ground.split);
  result.rays = attempt.bench->pupil.size();
  result.fit.status = FitStatus::kConverged;
  result.fit.message = "nothing to fit: no frequency needs a term";
  attempt.met = true;
  attempt.mismatch = 0;
  const JudgedSet fitted(of.targets.fitted, {});
  const Eigen::VectorXd own =
      attempt.bench->exact(of.task, {}, fitted.statistics(), threads, &result.warnings);
  result.start = result.fitted = fitted.shown(own);
  attempt.own = fitted.judged(own);
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  attempt.fresh = statistics_of_draws(of, judged.statistics(), &result.warnings);
  result.metrics = judged.judge(attempt.fresh, of.task.equivalence);
  result.validated = attempt.fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  result.verdict = overall(result.metrics);
  return attempt;
}

}  // namespace aberfit
