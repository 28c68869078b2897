// Times the steps of a fit in turns: statistics from coefficients (L, O, S), and statistics with the full
// Jacobian.
#include <fmt/format.h>

#include <memory>

#include "benchmark_case.h"
#include "model_evaluation.h"

namespace aberfit::benchmarks {
namespace {

struct Work {
  Scene scene;
  ModelEvaluation model;

  Work(int n_max, std::int64_t rays, bool all)
      : scene(n_max, circle_pupil(PupilLayout::kPolar, rays)),
        model(scene, all ? default_statistics(scene.mirror.focal_length * scene.focal_sigma / kRadius)
                         : twelve_statistics()) {}
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
        const double error = work->model.error();
        return [=](benchmark::State& state) {
          time_against(
              state, [&] { work->model.values_and_jacobian(); }, "values", [&] { work->model.values(); });
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
             const double error = work->model.error();
             return [=](benchmark::State& state) {
               time_against(
                   state, [&] { work->model.values_and_jacobian(); }, "one-sided differences",
                   [&] { work->model.differences(); });
               report_error(state, error, kDerivativeAllowed);
               report_rate(state, "rays", double(work->scene.pupil.size()));
             };
           });
}

}  // namespace aberfit::benchmarks
