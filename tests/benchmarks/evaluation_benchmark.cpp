// What a fit does at every step: values of the statistics from coefficients (L, O, S), and values with the
// full Jacobian, timed in turns.
#include <fmt/format.h>

#include <memory>

#include "../../src/fit/focus_residuals.h"
#include "benchmark_case.h"
#include "benchmark_scene.h"

namespace aberfit::benchmarks {
namespace {

constexpr double kWidth = 0.02;  // of focal_sigma

struct Work {
  Scene scene;
  FitProblem problem;
  FocusModel model;
  Eigen::VectorXd white, values;
  Eigen::MatrixXd jacobian;

  Work(int n_max, std::int64_t rays, bool all)
      : scene(n_max, circle_pupil(PupilLayout::kPolar, rays)),
        problem(scene.problem(
            targets_of(scene,
                       all ? default_statistics(scene.mirror.focal_length * scene.focal_sigma / kRadius)
                           : twelve_statistics(),
                       2, 1e-3))),
        model(problem, kWidth * scene.focal_sigma, 1),
        white(draw_white(scene.prior.size(), 1)) {}

  void forward() { model(white, &values, nullptr); }
  void linearise() { model(white, &values, &jacobian); }

  // One-sided differences of every coefficient: what a solver without derivatives pays (and how wrong it is
  // does not matter here).
  void difference_all() {
    forward();
    const Eigen::VectorXd here = values;
    Eigen::VectorXd moved = white;
    for (Eigen::Index j = 0; j < white.size(); ++j) {
      moved[j] += 1e-4;
      model(moved, &values, nullptr);
      jacobian.col(j) = (values - here) / 1e-4;
      moved[j] = white[j];
    }
  }

  double jacobian_error() {
    linearise();
    const Eigen::VectorXd here = values, along = draw_white(white.size(), 3);
    const auto moved = [&](double t) {
      Eigen::VectorXd there;
      model(white + t * along, &there, nullptr);
      return there;
    };
    return derivative_error(moved, here, jacobian * along);
  }
};

}  // namespace

void register_cases(bool smoke) {
  const std::int64_t rays = 65536;
  for (const int n_max : {20, 60}) {
    for (const bool all : {false, true}) {
      const std::string setting =
          fmt::format("{} statistics, n = {}, {} polar rays", all ? 66 : 12, n_max, grouped(rays));
      add_case("Values and Jacobian/" + setting, [=]() -> Timed {
        const auto work = std::make_shared<Work>(n_max, rays, all);
        const double error = work->jacobian_error();
        return [=](benchmark::State& state) {
          time_against(
              state, [&] { work->linearise(); }, "values", [&] { work->forward(); });
          report_error(state, error, kDerivativeAllowed);
          report_rate(state, "rays", double(work->scene.pupil.size()));
        };
      });
    }
  }
  const std::int64_t few = smoke ? 4096 : 15000;
  add_case(fmt::format("Jacobian against differences/12 statistics, n = 20, {} polar rays", grouped(few)),
           [=]() -> Timed {
             const auto work = std::make_shared<Work>(20, few, false);
             const double error = work->jacobian_error();
             return [=](benchmark::State& state) {
               time_against(
                   state, [&] { work->linearise(); }, "one-sided differences",
                   [&] { work->difference_all(); });
               report_error(state, error, kDerivativeAllowed);
               report_rate(state, "rays", double(work->scene.pupil.size()));
             };
           });
}

}  // namespace aberfit::benchmarks
