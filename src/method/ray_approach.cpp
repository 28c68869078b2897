#include "ray_approach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/method/pupil_choice.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {
namespace {

// In units of focal_sigma. From 0.01 to 0.2, and with four times the rays, four fits of a spot of g 14 end at
// 3.7 to 6 tolerances; narrow kernels need more steps, wide ones more time each.
constexpr double kKernel = 0.03;
constexpr int kMostFits = 6;
constexpr int kMostIterations = 16;
// Of their tolerances. What rays and light differ by changes by some tolerances from the first surface to the
// next: nothing is gained by a first fit that is closer.
constexpr double kFirstStop = 2, kStop = 0.9;
// A fit that does not bring the light nearer by a fifth is a matter of chance; two in a row are the end.
constexpr double kWorthwhile = 0.8;
constexpr int kMostInVain = 2;
// Tolerances beyond which a start is no better than the draw: 100 to 600 away, and closer after two steps.
constexpr double kNoNearer = 40;

// What is met and what guides between, as one list.
std::vector<Target> joined(const FitProblem& problem) {
  std::vector<Target> all = problem.targets;
  all.insert(all.end(), problem.guides.begin(), problem.guides.end());
  return all;
}

// What light says of a statistic less what rays say, by their theories; 0 where one has no value.
Eigen::VectorXd difference_of_theories(const Groundwork& ground, const std::vector<Target>& by_light) {
  Eigen::VectorXd difference(Eigen::Index(by_light.size()));
  for (std::size_t k = 0; k < by_light.size(); ++k) {
    const double by_rays = (*ground.theory)(by_light[k].statistic);
    difference[Eigen::Index(k)] = std::isfinite(by_rays) ? by_light[k].value - by_rays : 0;
  }
  return difference;
}

void shift(const std::vector<Target>& targets, const Eigen::VectorXd& by, FitProblem* problem) {
  const std::size_t fitted = problem->targets.size();
  for (std::size_t k = 0; k < targets.size(); ++k) {
    Target& target = k < fitted ? problem->targets[k] : problem->guides[k - fitted];
    target.value = targets[k].value - by[Eigen::Index(k)];
  }
}

// Largest mismatch of some targets, in tolerances.
double worst_of(const std::vector<Target>& targets, std::size_t from, std::size_t to,
                const Eigen::VectorXd& values) {
  double worst = 0;
  for (std::size_t k = from; k < to; ++k)
    worst = std::max(worst, std::abs(values[Eigen::Index(k)] - targets[k].value) / targets[k].tolerance);
  return worst;
}

}  // namespace

std::optional<RayStart> approach_by_rays(const FitCase& of, const FitPlan& plan, double met_within,
                                         const FitProblem& waves, const Eigen::VectorXd& draw) {
  const int threads = of.context.threads;
  PupilOptions rays = plan.pupil;
  rays.rays = rays_that_lead(plan.terms->terms.size());
  const Workbench bench(of.task, FocusModel::kRays, rays, 0, plan.terms->terms, threads, of.ground.split);
  FitProblem problem{bench.focus(of.task), waves.prior, waves.targets, waves.guides, waves.focal_sigma};
  const std::vector<Target> targets = joined(waves);
  const std::vector<Statistic> statistics = statistics_of(targets);
  const auto by_rays = make_forward_model(problem.light, statistics, threads);
  DiffractionWorkspace workspace;
  workspace.follow_rings();
  LightPath light = waves.light;
  light.workspace = &workspace;
  const auto by_light = make_forward_model(light, statistics, threads);

  FitOptions how;
  how.prior = of.task.fit.prior;
  how.bound = of.task.fit.bound_sigmas;
  how.smoothing = {kKernel};
  how.max_iterations = std::min(kMostIterations, plan.most_iterations);
  how.guides_within = plan.guides_within;
  how.threads = threads;
  how.progress = [&of](const FitProgress&) { return !of.context.stopped(); };

  RayStart nearest{draw, {0, kInfinity}};
  double best = kInfinity;  // of what ends a fit by waves: guides count as they do there
  Eigen::VectorXd white = draw, difference = difference_of_theories(of.ground, targets), of_rays, of_light;
  for (int in_vain = 0; nearest.begun.fits < kMostFits && in_vain < kMostInVain && !of.context.stopped();) {
    shift(targets, difference, &problem);
    how.stop_at = nearest.begun.fits == 0 ? kFirstStop : kStop;
    const FitResult fit = calibrate(problem, white, how);
    // What was cancelled has come nearer, too: that is what a run that ends here keeps.
    if (!has_solution(fit) && fit.status != FitStatus::kCancelled) break;
    by_rays->move_to(fit.coefficients);
    by_light->move_to(fit.coefficients);
    if (!by_rays->evaluate(kKernel * waves.focal_sigma, &of_rays) || !by_light->evaluate(0, &of_light)) break;
    ++nearest.begun.fits;
    const std::size_t fitted = waves.targets.size();
    const double mismatch = worst_of(targets, 0, fitted, of_light);
    const double guides = worst_of(targets, fitted, targets.size(), of_light);
    const double to_go = std::max(mismatch, guides * met_within / plan.guides_within);
    of.context.say(
        fmt::format("fit {} by rays: in light {:.3g} tolerances away", nearest.begun.fits, mismatch));
    in_vain = to_go < kWorthwhile * best ? 0 : in_vain + 1;
    white = fit.white;
    difference = of_light - of_rays;
    if (to_go >= best) continue;
    best = to_go;
    nearest.white = white;
    nearest.begun.mismatch = mismatch;
    if (to_go <= met_within) break;
  }
  if (best > kNoNearer) return std::nullopt;
  return nearest;
}

}  // namespace aberfit::internal
