// Times O, and L with O: rays from a rough parabola to the focal plane, against a trace in long double.
#include <fmt/format.h>

#include <memory>

#include "aberfit/trace/central_difference.h"
#include "benchmark_case.h"
#include "benchmark_scene.h"
#include "zernike_twin.h"

namespace aberfit::benchmarks {
namespace {

constexpr std::int64_t kRays = 1000000;
constexpr double kAbsolute = 1e-15;  // allowed position error [m] ...
constexpr double kRelative = 1e-13;  // ... plus so much of the position

struct Work {
  Mirror mirror = parabola();
  PupilSample pupil;
  SurfaceOperator surface;
  Eigen::VectorXd coefficients;
  SurfaceField field;
  RayBundle rays;
  int threads;

  Work(std::int64_t count, int thread_count)
      : pupil(circle_pupil(PupilLayout::kRandom, count)),
        surface(zernike_terms(20), pupil, {thread_count, {}, {}}),
        coefficients(random_coefficients(surface.terms().size())),
        threads(thread_count) {
    apply();
    reflect_all();
  }
  void apply() { surface.apply(coefficients, &field); }
  void reflect_all() { trace(mirror, pupil, field, threads, &rays); }

  // Largest position error over what is allowed, among `samples` rays.
  double clearance(int samples) const {
    Long worst = 0;
    for (Eigen::Index i = 0; i < rays.size(); i += std::max<Eigen::Index>(1, rays.size() / samples)) {
      const LongPoint rough = surface_twin(surface.terms(), coefficients, pupil.x[i], pupil.y[i]);
      const Long x = pupil.x[i], y = pupil.y[i], f = mirror.focal_length;
      // Parabola: z = rho^2 / 4f; law of reflection with the unit normal, direction d - 2 (d.n) n.
      const Long z = (x * x + y * y) / (4 * f) + rough.height;
      const Long p = x / (2 * f) + rough.slope_x, q = y / (2 * f) + rough.slope_y;
      const Long length = std::sqrt(1 + p * p + q * q), nx = -p / length, ny = -q / length, nz = 1 / length;
      const Long along = -2 * -nz;  // light comes along (0, 0, -1)
      const Long dx = along * nx, dy = along * ny, dz = -1 + along * nz, path = (f - z) / dz;
      const Long exact_x = x + path * dx, exact_y = y + path * dy;
      const Long off = std::hypot(exact_x - rays.x[i], exact_y - rays.y[i]);
      if (!(off >= 0)) return std::nan("");
      worst = std::max(worst, off / (kAbsolute + kRelative * std::hypot(exact_x, exact_y)));
    }
    return double(worst);
  }
};

}  // namespace

void register_cases(bool smoke) {
  const int samples = smoke ? 2000 : 20000;
  for (const int threads : {1, 2}) {
    const std::string setting =
        fmt::format("{} random rays, {} thread{}", grouped(kRays), threads, threads > 1 ? "s" : "");
    add_case("Parabola with 231 Zernikes to focus/" + setting, [=]() -> Timed {
      const auto work = std::make_shared<Work>(kRays, threads);
      const double clearance = work->clearance(samples);
      return [=](benchmark::State& state) {
        time_alone(state, [&] { work->apply(), work->reflect_all(); });
        report_error(state, clearance, 1);  // in units of 1e-15 m + 1e-13 of the position
        report_rate(state, "rays", double(kRays));
      };
    });
    add_case("Normals by central differences of 1 um/" + setting, [=]() -> Timed {
      const auto work = std::make_shared<Work>(kRays, threads);
      const auto differences = std::make_shared<SurfaceField>();
      const auto run = [=] {
        *differences = central_difference_field(work->mirror, work->pupil, work->surface.terms(),
                                                work->coefficients, 1e-6, threads);
      };
      run();
      const double error =
          (differences->slope_x - work->field.slope_x).square().mean() / work->field.slope_x.square().mean();
      return [=](benchmark::State& state) {
        time_alone(state, run);
        report_error(state, std::sqrt(error), 1e-6);  // truncation and rounding, tests/stability
        report_rate(state, "rays", double(kRays));
      };
    });
    add_case("Reflection alone/" + setting, [=]() -> Timed {
      const auto work = std::make_shared<Work>(kRays, threads);
      const double clearance = work->clearance(samples);
      return [=](benchmark::State& state) {
        time_alone(state, [&] { work->reflect_all(); });
        report_error(state, clearance, 1);
        report_rate(state, "rays", double(kRays));
      };
    });
  }
}

}  // namespace aberfit::benchmarks
