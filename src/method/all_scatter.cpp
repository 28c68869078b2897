#include "aberfit/method/all_scatter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/random.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/pupil_choice.h"

namespace aberfit {
namespace {

struct Drawing {
  std::shared_ptr<const BandSplit> split;
  TermSet terms;
  CoefficientPrior prior;
};

Drawing drawing_of(const FitCase& of) {
  const Task& task = of.task;
  Drawing drawing;
  drawing.split = drawn_split(task, of.ground);
  drawing.terms = drawn_waves(of.ground, *drawing.split);
  drawing.prior = CoefficientPrior(
      drawing.terms.size(), make_prior(drawing.terms, drawing.split->low(), CovarianceKind::kFull).blocks());
  return drawing;
}

class DrawnMirrors {
 public:
  DrawnMirrors(const FitCase& of, const std::vector<Statistic>& statistics)
      : of_(of), statistics_(statistics), drawing_(drawing_of(of)), bench_(bench()) {
    // Following rings from one mirror to the next halves the time. It is safe where the encircled energies of
    // single mirrors differ by less than their tolerances, because their rings then lie close together.
    if (of.ground.shares && of.ground.shares->spread < 1) workspace_.follow_rings();
  }

  // Returns the mean of the first `count` mirrors; statistics of the surface alone use the first `surfaces`.
  FreshStatistics mean(int count, int surfaces, Warnings* warnings) {
    draw_up_to(count, warnings);
    FreshStatistics fresh;
    fresh.rays = bench_->pupil.size();
    fresh.value = values_.rowwise().mean();
    fresh.standard_error = standard_error_of_mean(values_);
    fresh.degrees_of_freedom = count - 1;
    if (surfaces > count) replace_moments(surfaces, &fresh);
    return fresh;
  }

 private:
  std::unique_ptr<const Workbench> bench() const {
    const double pitch = wave_pitch(of_.task, drawing_.terms, all_targets(of_.targets), drawing_.split.get());
    auto made = std::make_unique<Workbench>(of_.task, FocusModel::kWaves, PupilOptions{}, pitch,
                                            drawing_.terms, of_.context.threads, drawing_.split);
    made->single_precision = in_single_precision(FocusModel::kWaves, of_.targets, made->pupil.size());
    return made;
  }

  Eigen::VectorXd coefficients(int d) const {
    const std::uint64_t seed = RandomStream(of_.task.fit.seed, "scatter-draws").bits(std::uint64_t(d));
    return drawing_.prior.colour(draw_white(drawing_.prior.size(), seed));
  }

  void replace_moments(int surfaces, FreshStatistics* fresh) {
    std::vector<Statistic> moments;
    std::vector<Eigen::Index> place;
    for (std::size_t k = 0; k < statistics_.size(); ++k) {
      if (!kind_of(statistics_[k]).is_moment()) continue;
      moments.push_back(statistics_[k]);
      place.push_back(Eigen::Index(k));
    }
    if (moments.empty()) return;
    const int known = int(values_.cols());
    Eigen::MatrixXd values(Eigen::Index(moments.size()), surfaces);
    for (std::size_t j = 0; j < place.size(); ++j)
      values.row(Eigen::Index(j)).head(known) = values_.row(place[j]);
    of_.context.say(fmt::format("heights and slopes of {} realisations", surfaces));
    const LightPath path = bench_->focus(of_.task);
    const auto model = make_forward_model(path, moments, of_.context.threads);
    int drawn = known;
    for (; drawn < surfaces && !of_.context.stopped(); ++drawn) {
      model->move_to(coefficients(drawn));
      values.col(drawn) = model->exact(nullptr);
    }
    values.conservativeResize(Eigen::NoChange, drawn);
    const Eigen::VectorXd mean = values.rowwise().mean(), error = standard_error_of_mean(values);
    for (std::size_t j = 0; j < place.size(); ++j) {
      fresh->value[place[j]] = mean[Eigen::Index(j)];
      fresh->standard_error[place[j]] = error[Eigen::Index(j)];
    }
  }

  void draw_up_to(int count, Warnings* warnings) {
    int d = int(values_.cols());
    values_.conservativeResize(Eigen::Index(statistics_.size()), std::max(count, d));
    for (; d < count; ++d) {
      of_.context.say(fmt::format("realisation {} of {}", d + 1, count));
      LightPath path = bench_->focus(of_.task);
      path.workspace = &workspace_;
      values_.col(d) = focus_statistics(path, coefficients(d), statistics_, of_.context.threads,
                                        d == 0 ? warnings : nullptr);
    }
  }

  const FitCase& of_;
  const std::vector<Statistic>& statistics_;
  Drawing drawing_;
  std::unique_ptr<const Workbench> bench_;
  DiffractionWorkspace workspace_;
  Eigen::MatrixXd values_;
};

// Number of mirrors that reduces half of every interval to its fraction of the margin. It depends on the
// spread of the first group alone, not on their mean (Stein 1945); repeated tests of an undecided verdict
// would raise a 5 % error to 11 %.
double enough_draws(const EquivalenceMetric& metric) {
  const double half = 0.5 * (metric.interval[1] - metric.interval[0]) / metric.margin;
  return std::isfinite(half) ? law::kGroups * std::pow(half / law::kShareOfMargin, 2) : 0;
}

std::shared_ptr<const TermPlan> no_terms(const FitCase& of) {
  TermPlan plan;
  plan.terms.radius = of.ground.radius;
  plan.prior = CoefficientPrior(0, {});
  return std::make_shared<const TermPlan>(std::move(plan));
}

}  // namespace

std::shared_ptr<const BandSplit> drawn_split(const Task& task, const Groundwork& ground) {
  const RadialPsd& psd = *ground.psd;
  const double low = std::max(psd.f_min(), std::isfinite(psd.f_max()) ? 1e-3 * psd.f_max() : 0.0);
  const double cut =
      std::clamp(law::kDrawnCycles / (2 * ground.radius), std::min(2 * low, psd.f_max()), psd.f_max());
  return std::make_shared<const BandSplit>(psd, cut, task.mirror, task.aperture, task.wavelength,
                                           ground.mean_spot);
}

TermSet drawn_waves(const Groundwork& ground, const BandSplit& split) {
  TermSet waves;
  waves.radius = ground.radius;
  const double low = std::max(split.low().f_min(), 0.0), high = split.low().f_max();
  // The grid of the aperture's box, or a coarser one where that has too many waves up to kDrawnCycles.
  waves.fourier_pitch =
      std::max(1 / (2 * ground.radius), std::sqrt((high - low) * (high + low)) / law::kDrawnCycles);
  waves.fourier = fourier_lattice(split.low(), waves.fourier_pitch);
  return waves;
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
  result.fitted.rays = attempt.bench->pupil.size();
  result.fitted.fit.status = FitStatus::kConverged;
  result.fitted.fit.message = "there is nothing to fit, because no frequency needs a term";
  attempt.mismatch = 0;
  const JudgedSet fitted(of.targets.fitted, {});
  const Eigen::VectorXd own =
      attempt.bench->exact(of.task, {}, fitted.statistics(), threads, &result.warnings);
  result.fitted.start = result.fitted.values = fitted.shown(own);
  attempt.own = fitted.judged(own);
  const JudgedSet judged(of.targets.fitted, of.targets.held_out);
  DrawnMirrors drawn(of, judged.statistics());
  const auto judge = [&](double draws, double surfaces) {
    attempt.fresh =
        drawn.mean(int(std::ceil(std::min(draws, double(law::kMostDraws)))),
                   int(std::ceil(std::min(surfaces, double(law::kMostSurfaces)))), &result.warnings);
    result.judgement.metrics = judged.judge(attempt.fresh, of.task.equivalence);
  };
  judge(law::kGroups, law::kGroups);
  double draws = law::kGroups, surfaces = law::kGroups;
  for (std::size_t k = 0; k < result.judgement.metrics.size(); ++k) {
    double& most = kind_of(judged.targets()[k].statistic).is_moment() ? surfaces : draws;
    most = std::max(most, enough_draws(result.judgement.metrics[k]));
  }
  if (std::max(draws, surfaces) > law::kGroups) judge(draws, surfaces);
  result.judgement.verdict = overall(result.judgement.metrics);
  result.fitted.validated = attempt.fresh.value.head(Eigen::Index(of.targets.fitted.size()));
  return attempt;
}

}  // namespace aberfit
