// Times S: exact and smooth statistics and their gradients over the rays.
#include <fmt/format.h>

#include <memory>

#include "benchmark_case.h"
#include "benchmark_scene.h"

namespace aberfit::benchmarks {
namespace {

constexpr double kWidth = 0.02;  // of focal_sigma
// Smoothing changes the radii by 1e-4, O(width^2). Some 250 rays inside the kernel and the lumps of one
// surface add 1e-3.
constexpr double kSmoothAllowed = 2e-3;

struct Work {
  Scene scene;
  SurfaceField field;
  RayBundle nominal, rays;
  std::vector<Statistic> statistics;
  FocusWorkspace workspace;
  Eigen::VectorXd values;
  std::vector<StatisticGradient> gradients;

  Work(PupilLayout layout, std::int64_t count, bool all)
      : scene(20, circle_pupil(layout, count)),
        field(scene.draw(1)),
        nominal(trace_nominal(scene.mirror, scene.pupil)),
        rays(trace(scene.mirror, scene.pupil, field)),
        statistics(all ? default_statistics(scene.mirror.focal_length * scene.focal_sigma / kRadius)
                       : twelve_statistics()) {}

  FocusInput input() const { return {rays, nominal, field.height}; }
  double width() const { return kWidth * scene.focal_sigma; }
  bool smooth(bool with_gradients) {
    return evaluate_smooth(input(), statistics, width(), 1, &workspace, &values,
                           with_gradients ? &gradients : nullptr);
  }
  Eigen::VectorXd exact() const { return evaluate_exact(input(), statistics, 1); }

  // Largest relative difference between a smooth and an exact statistic.
  double smooth_error() {
    if (!smooth(false)) return std::nan("");
    return ((values - exact()).array() / exact().array()).abs().maxCoeff();
  }

  // The rays move along a smooth direction field.
  double gradient_error() {
    if (!smooth(true)) return std::nan("");
    const SurfaceField along = scene.draw(2);
    const auto moved = [&](double t) {
      SurfaceField there = field;
      there.height += t * along.height, there.slope_x += t * along.slope_x,
          there.slope_y += t * along.slope_y;
      const RayBundle bundle = trace(scene.mirror, scene.pupil, there);
      Eigen::VectorXd result;
      evaluate_smooth({bundle, nominal, there.height}, statistics, width(), 1, &result, nullptr);
      return result;
    };
    Eigen::VectorXd analytic(values.size());
    for (std::size_t k = 0; k < gradients.size(); ++k) {
      const StatisticGradient& gradient = gradients[k];
      double sum = gradient.d_height.size() > 0 ? (gradient.d_height * along.height).sum() : 0.0;
      const SurfaceField pulled = trace_adjoint(scene.mirror, scene.pupil, field, gradient.rays);
      const std::vector<std::uint32_t>& listed = gradient.rays.rays;  // none: entry i is that of ray i
      for (Eigen::Index i = 0; i < pulled.size(); ++i) {
        const Eigen::Index ray = listed.empty() ? i : Eigen::Index(listed[std::size_t(i)]);
        sum += pulled.height[i] * along.height[ray] + pulled.slope_x[i] * along.slope_x[ray] +
               pulled.slope_y[i] * along.slope_y[ray];
      }
      analytic[Eigen::Index(k)] = sum;
    }
    return derivative_error(moved, values, analytic);
  }
};

}  // namespace

void register_cases(bool /*smoke*/) {
  struct Rays {
    PupilLayout layout;
    std::int64_t count;
    const char* name;
  };
  for (const Rays& pupil : {Rays{PupilLayout::kRandom, 15000, "15,000 random rays"},
                            Rays{PupilLayout::kPolar, 65536, "65,536 polar rays"}}) {
    for (const bool all : {false, true}) {
      const std::string setting =
          fmt::format("{}, {}", all ? "66 statistics (default)" : "12 statistics", pupil.name);
      const auto make = [=] { return std::make_shared<Work>(pupil.layout, pupil.count, all); };
      add_case("Exact values/" + setting, [=]() -> Timed {
        const auto work = make();
        return [=](benchmark::State& state) {
          Eigen::VectorXd values;
          time_alone(state, [&] { values = work->exact(); });
          // By definition, the energy inside the EE radius is its fraction, to one ray.
          double error = 0;
          for (std::size_t k = 0; k < work->statistics.size(); ++k) {
            const auto* ee = std::get_if<EncircledEnergyRadius>(&work->statistics[k]);
            if (!ee) continue;
            const RayBundle& rays = work->rays;
            const Eigen::ArrayXd r2 =
                (rays.x + ee->dz * rays.tx).square() + (rays.y + ee->dz * rays.ty).square();
            const double radius = values[Eigen::Index(k)];
            error = std::max(error,
                             std::abs((r2 <= radius * radius).select(rays.weight, 0.0).sum() - ee->fraction));
          }
          report_error(state, error, work->rays.weight.maxCoeff());
          report_rate(state, "rays", double(work->rays.size()));
        };
      });
      add_case("Smooth values/" + setting, [=]() -> Timed {
        const auto work = make();
        const double error = work->smooth_error();
        return [=](benchmark::State& state) {
          time_alone(state, [&] { work->smooth(false); });
          report_error(state, error, kSmoothAllowed);
          report_rate(state, "rays", double(work->rays.size()));
        };
      });
      add_case("Smooth values and gradients/" + setting, [=]() -> Timed {
        const auto work = make();
        const double error = work->gradient_error();
        return [=](benchmark::State& state) {
          time_against(
              state, [&] { work->smooth(true); }, "values alone", [&] { work->smooth(false); });
          report_error(state, error, kDerivativeAllowed);
          report_rate(state, "rays", double(work->rays.size()));
        };
      });
    }
  }
}

}  // namespace aberfit::benchmarks
