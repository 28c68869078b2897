// Times L, term surfaces and their adjoint, by every method, against a long-double reference.
#include <fmt/format.h>

#include <memory>
#include <stdexcept>

#include "../terms/zernike_exact.h"
#include "aberfit/scene/zernike.h"
#include "benchmark_case.h"
#include "benchmark_scene.h"
#include "zernike_twin.h"

namespace aberfit::benchmarks {
namespace {

// Allowed error relative to the largest value (gradient). The disc coordinates carry eps / 2. A gradient of
// degree n changes by up to n^2 of its size per unit at the rim (Markov), so n^2 eps / 2 is the worst case;
// half of it is allowed, plus rounding of the sum.
double allowed_error(int n_max) { return 1e-14 + n_max * n_max * 2.2e-16 / 4; }
constexpr double kFourierAllowed = 1e-13;  // rounding of phases of up to 8 cycles, 2 pi 8 eps, and of the sum
constexpr double kAdjointAllowed = 1e-13;  // of |L c| |g|

struct Work {
  TermSet terms;
  PupilSample pupil;
  SurfaceOperator surface;
  Eigen::VectorXd coefficients;
  SurfaceField field;    // L c
  SurfaceField weights;  // g
  Eigen::VectorXd transposed;

  Work(TermSet set, PupilSample points, const OperatorOptions& options)
      : terms(std::move(set)),
        pupil(std::move(points)),
        surface(terms, pupil, options),
        coefficients(random_coefficients(terms.size())),
        weights(random_field(pupil.size(), 2)) {
    surface.apply(coefficients, &field);
    transposed = surface.apply_transpose(weights);
  }
  double forward_error(int samples) const {
    return relative_error(terms, coefficients, pupil.x, pupil.y, field, samples);
  }
  double adjoint_error() const {
    const auto dot = [](const SurfaceField& a, const SurfaceField& b) {
      return (a.height * b.height + a.slope_x * b.slope_x + a.slope_y * b.slope_y).sum();
    };
    const double scale = std::sqrt(dot(field, field) * dot(weights, weights));
    return std::abs(dot(field, weights) - coefficients.dot(transposed)) / scale;
  }
};

// Adds the rows of one method to compute L: forward and adjoint.
void add_operator(const std::string& what, const std::string& setting, const std::string& unit,
                  const std::function<TermSet()>& terms, PupilLayout layout, std::int64_t rays,
                  const OperatorOptions& options, double allowed, int samples) {
  const auto make = [=]() -> std::shared_ptr<Work> {
    try {
      return std::make_shared<Work>(terms(), circle_pupil(layout, rays), options);
    } catch (const std::invalid_argument&) {
      return nullptr;
    }
  };
  // Reason why a row has no time: the method is refused, or another one was used.
  const auto trouble = [options](const Work* work) -> std::string {
    if (!work) return "refused for these points";
    const OperatorChoice& choice = work->surface.choice();
    if (options.zernike && choice.zernike != options.zernike)
      return "not available, the operator took: " + to_string(*choice.zernike);
    if (options.fourier && choice.fourier != options.fourier)
      return "not available, the operator took: " + to_string(*choice.fourier);
    return "";
  };
  const auto work_count = [](const Work& work) {
    const TermSet& set = work.terms;
    return double(set.zernike.size() + set.fourier.size()) * double(work.pupil.size());
  };
  add_case(fmt::format("{} sum and gradient/{}", what, setting), [=]() -> Timed {
    const std::shared_ptr<Work> work = make();
    const double error = work ? work->forward_error(samples) : 0;
    return [=](benchmark::State& state) {
      if (const std::string why = trouble(work.get()); !why.empty()) return state.SkipWithError(why.c_str());
      time_alone(state, [&] { work->surface.apply(work->coefficients, &work->field); });
      report_error(state, error, allowed);
      report_rate(state, unit, work_count(*work));
      report_prediction(state, work->surface.choice().forward_seconds);
    };
  });
  add_case(fmt::format("{} adjoint/{}", what, setting), [=]() -> Timed {
    const std::shared_ptr<Work> work = make();
    const double error = work ? work->adjoint_error() : 0;
    return [=](benchmark::State& state) {
      if (const std::string why = trouble(work.get()); !why.empty()) return state.SkipWithError(why.c_str());
      time_alone(state, [&] { work->transposed = work->surface.apply_transpose(work->weights); });
      report_error(state, error, kAdjointAllowed);
      report_rate(state, unit, work_count(*work));
      report_prediction(state, work->surface.choice().adjoint_seconds);
    };
  });
}

// Term by term with the library's plain implementation, without vector code.
void term_by_term(const Work& work, SurfaceField* field) {
  field->resize(work.pupil.size());
  for (Eigen::Index i = 0; i < work.pupil.size(); ++i) {
    ZernikeValue sum;
    for (std::size_t j = 0; j < work.terms.zernike.size(); ++j) {
      const ZernikeValue z =
          zernike(work.terms.zernike[j], work.pupil.x[i] / kRadius, work.pupil.y[i] / kRadius);
      const double c = work.coefficients[Eigen::Index(j)];
      sum.value += c * z.value, sum.dx += c * z.dx, sum.dy += c * z.dy;
    }
    field->height[i] = sum.value, field->slope_x[i] = sum.dx / kRadius, field->slope_y[i] = sum.dy / kRadius;
  }
}

// The dense matrix of the operator, which numerical codes usually store.
struct DenseMatrix {
  Eigen::MatrixXd height, slope_x, slope_y;

  explicit DenseMatrix(const SurfaceOperator& surface)
      : height(surface.points(), surface.terms().size()), slope_x(height), slope_y(height) {
    SurfaceField column;
    for (Eigen::Index j = 0; j < height.cols(); ++j) {
      surface.apply(Eigen::VectorXd::Unit(height.cols(), j), &column);
      height.col(j) = column.height, slope_x.col(j) = column.slope_x, slope_y.col(j) = column.slope_y;
    }
  }
  void apply(const Eigen::VectorXd& c, SurfaceField* field) const {
    field->height.matrix().noalias() = height * c;
    field->slope_x.matrix().noalias() = slope_x * c;
    field->slope_y.matrix().noalias() = slope_y * c;
  }
};

void add_twins() {
  for (const int n_max : {20, 40}) {
    add_case(fmt::format("Zernike sum against an Eigen matrix/n = {}, 15,000 points", n_max), [=]() -> Timed {
      const auto work = std::make_shared<Work>(zernike_terms(n_max),
                                               circle_pupil(PupilLayout::kRandom, 15000), OperatorOptions{});
      const auto dense = std::make_shared<DenseMatrix>(work->surface);
      const double error = work->forward_error(256);
      return [=](benchmark::State& state) {
        SurfaceField other;
        other.resize(work->pupil.size());
        time_against(
            state, [&] { work->surface.apply(work->coefficients, &work->field); }, "dense Eigen",
            [&] { dense->apply(work->coefficients, &other); });
        report_error(state, error, allowed_error(n_max));
        report_rate(state, "term-points", double(work->terms.size() * work->pupil.size()));
      };
    });
  }
  add_case("Zernike sum against straight loops/n = 20, 2,048 points", []() -> Timed {
    const auto work = std::make_shared<Work>(zernike_terms(20), circle_pupil(PupilLayout::kRandom, 2048),
                                             OperatorOptions{});
    const double error = work->forward_error(256);
    return [=](benchmark::State& state) {
      SurfaceField other;
      time_against(
          state, [&] { work->surface.apply(work->coefficients, &work->field); }, "loops",
          [&] { term_by_term(*work, &other); });
      report_error(state, error, allowed_error(20));
      report_rate(state, "term-points", double(work->terms.size() * work->pupil.size()));
    };
  });
}

// Compares the reference of these errors with factorial sums in 200 digits.
void add_reference() {
  for (const int n : {20, 80}) {
    add_case(fmt::format("Reference, long double twin/modes of n = {}", n), [=]() -> Timed {
      return [=](benchmark::State& state) {
        double error = 0;
        time_alone(state, [&] {
          for (const double rho : {0.3, 0.99, 1.0}) {
            const double x = rho * 0.6, y = rho * 0.8;
            const zernike_exact::Point at(x, y, n);
            for (int m = n % 2; m <= n; m += std::max(2, n / 20 * 2)) {
              const auto exact = zernike_exact::evaluate(zernike_exact::radial({n, m}), at);
              Eigen::VectorXd unit = Eigen::VectorXd::Zero((n + 1) * (n + 2) / 2);
              unit[(n * (n + 2) + m) / 2] = 1;
              const LongPoint twin = zernike_sum(n, unit, x, y);
              // Values reach sqrt(2 (n + 1)), gradients n (n + 2) / 2 times that.
              const double largest = std::sqrt(2.0 * (n + 1));
              const auto off = [](Long a, const zernike_exact::Real& b) {
                return std::abs(double(zernike_exact::Real(a) - b));
              };
              error = std::max({error, off(twin.height, exact.value) / largest,
                                off(twin.slope_x, exact.dx) / (largest * n),
                                off(twin.slope_y, exact.dy) / (largest * n)});
            }
          }
        });
        // This is small compared with every error that it judges.
        report_error(state, error, 1e-15);
      };
    });
  }
}

}  // namespace

void register_cases(bool smoke) {
  add_reference();
  for (const int n_max : {8, 20, 40, 60, 80, 300}) {
    const std::int64_t rays = n_max == 300 ? 8192 : 65536;
    const auto terms = [n_max] { return zernike_terms(n_max); };
    const int samples = smoke || n_max == 300 ? 64 : 512;
    const auto setting = [&](const char* method) {
      return fmt::format("n = {}, {} points, {}", n_max, grouped(rays), method);
    };
    add_operator("Zernike", setting("any points"), "term-points", terms, PupilLayout::kRandom, rays, {},
                 allowed_error(n_max), samples);
    add_operator("Zernike", setting("polar"), "term-points", terms, PupilLayout::kPolar, rays,
                 {1, ZernikeMethod::kPolar, {}}, allowed_error(n_max), samples);
  }
  for (const int modes : {400, 20000}) {
    const auto terms = [modes] {
      TermSet set;
      set.radius = kRadius;
      set.fourier = fourier_modes(RadialPsd(UniformPsd{100e-9, 2.5, 39.92}), modes, 1);
      return set;
    };
    const auto setting = [&](const char* method) {
      return fmt::format("{} modes, 15,000 points, {}", grouped(modes), method);
    };
    const int samples = modes == 400 ? 512 : smoke ? 16 : 64;
    add_operator("Fourier", setting("any points"), "mode-points", terms, PupilLayout::kRandom, 15000, {},
                 kFourierAllowed, samples);
  }
  const auto lattice = [] {
    TermSet set;
    set.radius = kRadius;
    set.fourier_pitch = 1 / (2 * kRadius);
    set.fourier = fourier_lattice(RadialPsd(UniformPsd{100e-9, 2.5, 56 / (2 * kRadius)}), set.fourier_pitch);
    return set;
  };
  add_operator("Fourier", "56 cycles across, 65,536 points, lattice", "mode-points", lattice,
               PupilLayout::kGrid, 65536, {1, {}, FourierMethod::kLattice}, 1e-10, 16);
  add_twins();
}

}  // namespace aberfit::benchmarks
