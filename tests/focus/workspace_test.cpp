// Tests that evaluations reuse memory and that the number of threads changes no bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"

using namespace aberfit;

// Largest single allocation. Sanitizers have their own malloc, so we count only operator new there.
static std::atomic<std::size_t> largest_allocation = 0;
static void* counted(std::size_t size, void* (*allocate)(std::size_t)) {
  std::size_t seen = largest_allocation;
  while (seen < size && !largest_allocation.compare_exchange_weak(seen, size)) {
  }
  return allocate(size);
}
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* __libc_malloc(std::size_t);
void* malloc(std::size_t size) { return counted(size, __libc_malloc); }
}
#else
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"  // after inlining the compiler cannot match the two
void* operator new(std::size_t size) {
  void* const memory = counted(size, std::malloc);
  if (!memory) throw std::bad_alloc();
  return memory;
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size, std::malloc); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace {

constexpr double kSigma = 4e-5;

struct Scene {
  RayBundle nominal, rays;
  Eigen::ArrayXd height;
};

Scene scene(Eigen::Index n, std::uint64_t draw) {
  Mirror mirror;
  mirror.focal_length = 2.8;
  const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, n, 3});
  SurfaceField field;
  field.resize(n);
  const RandomStream stream(draw, "workspace-test");
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [a, b] = stream.normal_pair(std::uint64_t(2 * i));
    field.slope_x[i] = kSigma / 5.6 * a;
    field.slope_y[i] = kSigma / 5.6 * b;
    field.height[i] = 1e-7 * stream.normal(std::uint64_t(2 * i + 1));
  }
  return {trace_nominal(mirror, pupil), trace(mirror, pupil, field), field.height};
}

std::vector<Statistic> statistics() {
  std::vector<Statistic> all;
  for (const double dz : {0.0, 6e-4, -6e-4, 2e-3})
    for (const double p : {0.2, 0.5, 0.9}) all.push_back(EncircledEnergyRadius{p, dz});
  all.insert(all.end(), {RingFwhm{}, RingFwhm{0.5, 60e-6}, RingThrough{50e-6, 0.7e-3}, ScatterRms{},
                         ScatterMean{}, SpotFwhm{0.3 * kSigma}, RmsRadius{-1e-3}, RmsHeight{}});
  return all;
}

bool same(const StatisticGradient& a, const StatisticGradient& b) {
  return a.rays.rays == b.rays.rays && a.rays.d_x == b.rays.d_x && a.rays.d_y == b.rays.d_y &&
         a.rays.d_tx == b.rays.d_tx && a.rays.d_ty == b.rays.d_ty && a.rays.dz == b.rays.dz &&
         a.rays.all_rays == b.rays.all_rays && a.d_height.size() == b.d_height.size() &&
         (a.d_height == b.d_height).all();
}

}  // namespace

TEST(FocusWorkspace, ThreadsAndReuseChangeNoBit) {
  FocusWorkspace kept;
  Eigen::VectorXd reused;
  std::vector<StatisticGradient> reused_gradients;
  for (const Eigen::Index n : {3000, 70000, 3001}) {
    const Scene s = scene(n, 1);
    for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
      const FocusInput input{s.rays, s.nominal, s.height, centre};
      for (const std::vector<Statistic>& asked :
           {statistics(), std::vector<Statistic>{EncircledEnergyRadius{}}}) {
        Eigen::VectorXd one;
        std::vector<StatisticGradient> gradients;
        ASSERT_TRUE(evaluate_smooth(input, asked, 0.1 * kSigma, 1, &one, &gradients));
        const Eigen::VectorXd exact = evaluate_exact(input, asked, 1);
        for (const int threads : {2, 3}) {
          ASSERT_TRUE(
              evaluate_smooth(input, asked, 0.1 * kSigma, threads, &kept, &reused, &reused_gradients));
          EXPECT_EQ(evaluate_exact(input, asked, threads), exact);
          ASSERT_EQ(reused.size(), one.size());
          for (std::size_t k = 0; k < asked.size(); ++k) {
            EXPECT_EQ(reused[Eigen::Index(k)], one[Eigen::Index(k)]) << statistic_name(asked[k]);
            EXPECT_TRUE(same(gradients[k], reused_gradients[k])) << statistic_name(asked[k]) << " " << n;
          }
        }
      }
    }
  }
}

TEST(FocusWorkspace, ValuesDoNotDependOnWhetherGradientsAreAsked) {
  const Scene s = scene(5000, 2);
  const FocusInput input{s.rays, s.nominal, s.height};
  Eigen::VectorXd with, without;
  std::vector<StatisticGradient> gradients;
  ASSERT_TRUE(evaluate_smooth(input, statistics(), 0.1 * kSigma, 1, &with, &gradients));
  ASSERT_TRUE(evaluate_smooth(input, statistics(), 0.1 * kSigma, 1, &without, nullptr));
  EXPECT_EQ(with, without);
}

TEST(FocusWorkspace, ASecondEvaluationOfTheSizeAllocatesNothingThatGrowsWithRays) {
  constexpr Eigen::Index kRays = 200000;
  constexpr std::size_t kSmall = 40000;  // bytes; the smallest array over rays has thousands of entries
  const Scene first = scene(kRays, 1), second = scene(kRays, 2);
  for (const int threads : {1, 2}) {
    for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
      FocusWorkspace workspace;
      Eigen::VectorXd values;
      std::vector<StatisticGradient> gradients;
      const std::vector<Statistic> asked = statistics();
      largest_allocation = 0;
      ASSERT_TRUE(evaluate_smooth({first.rays, first.nominal, first.height, centre}, asked, 0.02 * kSigma,
                                  threads, &workspace, &values, &gradients));
      EXPECT_GT(largest_allocation, kRays * sizeof(double) / 2);  // shows that the count works
      largest_allocation = 0;
      ASSERT_TRUE(evaluate_smooth({second.rays, second.nominal, second.height, centre}, asked, 0.02 * kSigma,
                                  threads, &workspace, &values, &gradients));
      EXPECT_LT(largest_allocation, kSmall) << threads;
    }
  }
}
