// Compares every method of SurfaceOperator with the pointwise one, and the polar one with factorial sums.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <thread>
#include <utility>

#include "aberfit/terms/operator_cost.h"
#include "operator_cases.h"
#include "zernike_exact.h"

using namespace aberfit;
using namespace operator_cases;

namespace {

// These are relative to the largest gradient and the largest height.
constexpr double kLowOrders = 1e-13;   // to n = 20
constexpr double kHighOrders = 1e-12;  // to n = 80
constexpr double kPlaneWaves = 1e-12;
constexpr double kAdjoint = 1e-13;  // relative to |L c| |g|

OperatorOptions with(ZernikeMethod method, int threads = 1) { return {threads, method, std::nullopt}; }
OperatorOptions with(FourierMethod method, int threads = 1) { return {threads, std::nullopt, method}; }

TermSet zernikes(std::vector<ZernikeMode> modes) { return {kRadius, std::move(modes), {}, {}}; }
TermSet everything(int n) { return {kRadius, zernike_modes(0, n), plane_waves(37), {4, 8}}; }
TermSet on_lattice(TermSet terms) {
  terms.fourier.clear();
  terms.fourier_pitch = 2.5;
  for (int j = 1; j <= 9; ++j)
    for (int i = -9; i <= 9; ++i) terms.fourier.push_back({2.5 * i, 2.5 * j});
  return terms;
}
/// Aliasing of the kernel is 3e-12 of the sum of all moduli.
double allowed_of(const TermSet& terms, double allowed) {
  return terms.fourier_pitch > 0 ? std::max(allowed, 1e-10) : allowed;
}

Eigen::VectorXd coefficients_for(const TermSet& terms) {
  return normals(terms.size(), "coefficients").matrix();
}

SurfaceField applied(const SurfaceOperator& surface) {
  SurfaceField field;
  surface.apply(coefficients_for(surface.terms()), &field);
  return field;
}

SurfaceField pointwise(const TermSet& terms, const PupilSample& pupil) {
  return applied(SurfaceOperator(terms, pupil, {1, ZernikeMethod::kFused, FourierMethod::kPhaseSums}));
}

double adjoint_error(const SurfaceOperator& surface) {
  const SurfaceField field = applied(surface), g = random_field(surface.points(), "weights");
  const double through_adjoint = coefficients_for(surface.terms()).dot(surface.apply_transpose(g));
  return std::abs(dot(field, g) - through_adjoint) / (norm(field) * norm(g));
}

PupilSample polar_pupil(const Aperture& aperture, std::int64_t rays) {
  PupilOptions options;
  options.rays = rays;
  return make_pupil(aperture, options);
}
const Aperture kDisc = CircleAperture{.diameter = 2 * kRadius, .margin = 0};

/// Cases of points, terms and options. Together they use every method and every mixture of families.
struct Case {
  const char* name;
  TermSet terms;
  PupilSample pupil;
  OperatorOptions options;
};
std::vector<Case> every_method() {
  const PupilSample disc = polar_pupil(kDisc, 9000), grid = scrambled_grid(111, 97);
  PupilSample scattered = rings(37, 83);
  scattered.structure = std::monostate{};
  return {{"polar", zernikes(zernike_modes(0, 20)), disc, with(ZernikeMethod::kPolar)},
          {"polar and others", everything(14), disc, with(ZernikeMethod::kPolar)},
          {"lattice", on_lattice({}), grid, with(FourierMethod::kLattice)},
          {"lattice and others", on_lattice(everything(10)), scattered, with(FourierMethod::kLattice)},
          {"lattice beside polar", on_lattice(everything(9)), disc, {1, ZernikeMethod::kPolar, {}}}};
}

// Memory from operator new while `counting`. This excludes Eigen's own arrays.
std::atomic<bool> counting = false;
std::atomic<std::size_t> counted = 0;

}  // namespace

// Not inlined, because the compiler would warn about memory of one function freed by another.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (counting) counted += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// Sanitizers have their own version for std::stable_sort, whose memory ours would free.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  if (counting) counted += size;
  return std::malloc(size);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  if (counting) counted += size;
  const auto unit = std::size_t(alignment);
  if (void* memory = std::aligned_alloc(unit, (size + unit - 1) / unit * unit)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

TEST(OperatorMethods, PolarMatchesFactorialSums) {
  struct {
    int n;
    double bound;
    Aperture aperture;
  } const cases[] = {
      {20, kLowOrders, kDisc},
      {80, kHighOrders, kDisc},
      {20, kLowOrders,
       AnnulusAperture{.diameter = 2 * kRadius, .inner_diameter = 0.6 * kRadius, .margin = 0}},
  };
  for (const auto& [n, bound, aperture] : cases) {
    std::vector<ZernikeMode> some;  // every n and m occurs
    const std::vector<ZernikeMode> all = zernike_modes(0, n);
    for (std::size_t j = 0; j<all.size(); j += n> 40 ? 5 : 1) some.push_back(all[j]);
    const TermSet terms = zernikes(some);
    const PupilSample pupil = polar_pupil(aperture, 2000);
    const Eigen::VectorXd c = coefficients_for(terms);
    const SurfaceField field = applied(SurfaceOperator(terms, pupil, with(ZernikeMethod::kPolar)));

    std::vector<zernike_exact::Radial> modes;
    for (const ZernikeMode mode : some) modes.push_back(zernike_exact::radial(mode));
    const double scale = largest_gradient(field);
    for (Eigen::Index i = 0; i < pupil.size(); i += 199) {
      // The point is divided by the radius exactly, because its rounding is not an error of the operator.
      zernike_exact::Point at(0, 0, 0);
      at.x = zernike_exact::Real(pupil.x[i]) / kRadius, at.y = zernike_exact::Real(pupil.y[i]) / kRadius;
      at.rho_squared = at.x * at.x + at.y * at.y;
      for (int m = 0; m < n; ++m) {
        const auto a = at.re.back(), b = at.im.back();
        at.re.push_back(at.x * a - at.y * b), at.im.push_back(at.x * b + at.y * a);
      }
      zernike_exact::Real dx = 0, dy = 0, height = 0;
      for (std::size_t j = 0; j < modes.size(); ++j) {
        const auto value = zernike_exact::evaluate(modes[j], at);
        height += c[Eigen::Index(j)] * value.value;
        dx += c[Eigen::Index(j)] * value.dx, dy += c[Eigen::Index(j)] * value.dy;
      }
      EXPECT_LE(std::abs(field.slope_x[i] - double(dx / kRadius)), bound * scale) << n << " " << i;
      EXPECT_LE(std::abs(field.slope_y[i] - double(dy / kRadius)), bound * scale) << n << " " << i;
      EXPECT_LE(std::abs(field.height[i] - double(height)), bound * field.height.abs().maxCoeff());
    }
  }
}

TEST(OperatorMethods, PolarFoldsOrdersBeyondHalfTheSpokes) {
  // m goes up to 20 with one to forty points per ring, and numbers of rings lie around the block size of 16.
  const TermSet terms = zernikes(zernike_modes(0, 20));
  for (const int spokes : {1, 2, 3, 7, 8, 19, 20, 21, 40})
    for (const int count : {1, 3, 16, 17}) {
      const PupilSample pupil = rings(count, spokes);
      const SurfaceOperator surface(terms, pupil, with(ZernikeMethod::kPolar));
      EXPECT_LE(relative_difference(applied(surface), pointwise(terms, pupil)), kLowOrders)
          << spokes << " spokes, " << count << " rings";
      EXPECT_LE(adjoint_error(surface), kAdjoint) << spokes << " spokes, " << count << " rings";
    }
}

TEST(OperatorMethods, PolarMatchesPointwiseAtHighOrders) {
  for (const std::int64_t rays : {3000, 65536}) {
    const TermSet terms = zernikes(zernike_modes(2, 80));
    const PupilSample pupil = polar_pupil(kDisc, rays);
    const SurfaceOperator surface(terms, pupil, with(ZernikeMethod::kPolar));
    EXPECT_LE(relative_difference(applied(surface), pointwise(terms, pupil)), kHighOrders);
    EXPECT_LE(adjoint_error(surface), kAdjoint);
  }
}

TEST(OperatorMethods, PolarTakesAnySubsetOfModesInAnyOrder) {
  const TermSet terms = zernikes({{7, -5}, {12, 0}, {2, 2}, {40, 38}, {1, 1}, {40, -2}, {0, 0}, {12, 0}});
  const PupilSample pupil = rings(20, 30);
  const SurfaceOperator surface(terms, pupil, with(ZernikeMethod::kPolar));
  EXPECT_LE(relative_difference(applied(surface), pointwise(terms, pupil)), kHighOrders);
  EXPECT_LE(adjoint_error(surface), kAdjoint);
}

TEST(OperatorMethods, PolarStaysAccurateNearTheVertex) {
  const TermSet terms = zernikes(zernike_modes(0, 12));
  for (const double rho : {0.0, 1e-300, 1e-12, 1e-3}) {
    PupilSample pupil = rings(2, 24);
    auto structure = std::get<PolarRings>(pupil.structure);
    structure.rho[0] = rho * kRadius;
    for (int j = 0; j < 24; ++j) {
      const double angle = 2 * std::numbers::pi * j / 24 + structure.turn[0];
      pupil.x[j] = structure.rho[0] * std::cos(angle), pupil.y[j] = structure.rho[0] * std::sin(angle);
    }
    pupil.structure = structure;
    const SurfaceField field = applied(SurfaceOperator(terms, pupil, with(ZernikeMethod::kPolar)));
    EXPECT_LE(relative_difference(field, pointwise(terms, pupil)), kLowOrders) << rho;
  }
}

TEST(OperatorMethods, EveryMethodMatchesPointwiseAndIsItsAdjoint) {
  for (const Case& c : every_method()) {
    const SurfaceOperator surface(c.terms, c.pupil, c.options);
    if (c.options.zernike) {
      EXPECT_EQ(surface.choice().zernike, c.options.zernike) << c.name;
    }
    if (c.options.fourier) {
      EXPECT_EQ(surface.choice().fourier, c.options.fourier) << c.name;
    }
    EXPECT_LE(relative_difference(applied(surface), pointwise(c.terms, c.pupil)),
              allowed_of(c.terms, kPlaneWaves))
        << c.name;
    EXPECT_LE(adjoint_error(surface), allowed_of(c.terms, kAdjoint)) << c.name;
  }
}

TEST(OperatorMethods, ListedRaysGiveTheAdjointOfZeroWeightsElsewhere) {
  for (const Case& c : every_method()) {
    const SurfaceOperator surface(c.terms, c.pupil, c.options);
    const auto points = std::uint32_t(surface.points());
    // Few rays, then nearly all: the operator computes point by point, then all points. One ray occurs twice.
    for (const std::uint32_t step : {points / 3, 1u}) {
      std::vector<std::uint32_t> rays{5};
      for (std::uint32_t i = points - 1; i > step; i -= step) rays.push_back(i);
      const SurfaceField listed = random_field(Eigen::Index(rays.size()), "listed");
      SurfaceField all;
      all.resize(surface.points());
      all.height.setZero(), all.slope_x.setZero(), all.slope_y.setZero();
      for (std::size_t i = 0; i < rays.size(); ++i) {
        all.height[rays[i]] += listed.height[Eigen::Index(i)];
        all.slope_x[rays[i]] += listed.slope_x[Eigen::Index(i)];
        all.slope_y[rays[i]] += listed.slope_y[Eigen::Index(i)];
      }
      const OperatorOptions plain{1, ZernikeMethod::kFused, FourierMethod::kPhaseSums};
      const Eigen::VectorXd expected = SurfaceOperator(c.terms, c.pupil, plain).apply_transpose(all);
      const Eigen::VectorXd found = surface.apply_transpose(rays, listed);
      EXPECT_LE((found - expected).norm(), allowed_of(c.terms, kAdjoint) * expected.norm())
          << c.name << " " << rays.size();
    }
    EXPECT_EQ(surface.apply_transpose(std::vector<std::uint32_t>{}, SurfaceField{}),
              Eigen::VectorXd::Zero(c.terms.size()));
  }
}

TEST(OperatorMethods, ThreadCountChangesNoBit) {
  for (const Case& c : every_method()) {
    const SurfaceOperator single(c.terms, c.pupil, c.options);
    const SurfaceField expected = applied(single), g = random_field(single.points(), "weights");
    for (const int threads : {2, 3}) {
      OperatorOptions options = c.options;
      options.threads = threads;
      const SurfaceOperator surface(c.terms, c.pupil, options);
      const SurfaceField field = applied(surface);
      EXPECT_TRUE((field.height == expected.height).all()) << c.name;
      EXPECT_TRUE((field.slope_x == expected.slope_x).all()) << c.name;
      EXPECT_TRUE((field.slope_y == expected.slope_y).all()) << c.name;
      EXPECT_EQ(surface.apply_transpose(g), single.apply_transpose(g)) << c.name;
    }
  }
}

TEST(OperatorMethods, OneOperatorServesSeveralThreads) {
  for (const Case& c : every_method()) {
    const SurfaceOperator surface(c.terms, c.pupil, c.options);
    const SurfaceField expected = applied(surface), g = random_field(surface.points(), "weights");
    const Eigen::VectorXd sums = surface.apply_transpose(g);
    int equal[3] = {};
    {
      std::vector<std::jthread> users;
      for (int& mine : equal)
        users.emplace_back([&] {
          for (int i = 0; i < 5; ++i)
            mine +=
                (applied(surface).slope_x == expected.slope_x).all() && surface.apply_transpose(g) == sums;
        });
    }
    for (const int mine : equal) EXPECT_EQ(mine, 5) << c.name;
  }
}

TEST(OperatorMethods, LaterCallsAskForNoMemoryThatGrows) {
  // Allocations may not grow with terms (hundreds) or points (thousands): only a closure and a list of parts.
  constexpr std::size_t kSmall = 1024;
  for (const Case& c : every_method()) {
    const SurfaceOperator surface(c.terms, c.pupil, c.options);
    const Eigen::VectorXd coefficients = coefficients_for(c.terms);
    const SurfaceField g = random_field(surface.points(), "weights");
    std::vector<std::uint32_t> rays(std::size_t(surface.points()));
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = std::uint32_t(i);
    SurfaceField field;
    Eigen::VectorXd sums;
    std::size_t asked[2];
    for (std::size_t& bytes : asked) {
      counted = 0, counting = true;
      surface.apply(coefficients, &field);
      surface.apply_transpose(g, &sums);
      surface.apply_transpose(rays, g, &sums);
      counting = false;
      bytes = counted;
    }
    EXPECT_GT(asked[0], kSmall) << c.name;
    EXPECT_LE(asked[1], kSmall) << c.name;
  }
}

TEST(OperatorMethods, RejectsStructuresThatDoNotFit) {
  const TermSet terms = everything(4);
  const PupilSample polar = rings(5, 12), grid = scrambled_grid(9, 9);
  EXPECT_THROW(SurfaceOperator(terms, grid, with(ZernikeMethod::kPolar)), std::invalid_argument);
  EXPECT_THROW(SurfaceOperator(terms, polar, with(FourierMethod::kLattice)), std::invalid_argument);

  PupilSample moved = polar;
  moved.x[7] += 1e-9;
  EXPECT_THROW(SurfaceOperator(terms, moved, {}), std::invalid_argument);
  PupilSample cut = polar;
  cut.x.conservativeResize(59), cut.y.conservativeResize(59);
  EXPECT_THROW(SurfaceOperator(terms, cut, {}), std::invalid_argument);
  PupilSample outside = grid;
  std::get<CartesianGrid>(outside.structure).column[0] = 9;
  EXPECT_THROW(SurfaceOperator(terms, outside, {}), std::invalid_argument);
}
