// Compares encircled-energy radii and ring widths with slow methods that visit every ray: full sorts and
// bisection in long double, with a separate kernel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "../../src/focus/focus_kernel.h"
#include "../../src/focus/ray_blocks.h"
#include "../../src/focus/ring_through.h"
#include "../../src/focus/scatter_angle.h"
#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"

using namespace aberfit;
using namespace aberfit::internal;

namespace {

using Real = long double;

enum class Kind { kGaussian, kTies, kZeroWeights, kLost, kOnePoint, kHeavyTail };
constexpr Kind kKinds[] = {Kind::kGaussian, Kind::kTies,     Kind::kZeroWeights,
                           Kind::kLost,     Kind::kOnePoint, Kind::kHeavyTail};
constexpr double kSigma = 4e-5, kSlope = 0.035;

RayBundle bundle(Kind kind, Eigen::Index n) {
  const RandomStream stream(std::uint64_t(kind) * 1000 + std::uint64_t(n), "brute-force-test");
  RayBundle rays;
  for (Eigen::ArrayXd* a : {&rays.x, &rays.y, &rays.tx, &rays.ty, &rays.weight}) a->resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto u = std::uint64_t(4 * i);
    const auto position = stream.normal_pair(u), slope = stream.normal_pair(u + 1);
    rays.x[i] = position[0], rays.y[i] = position[1];
    rays.tx[i] = slope[0], rays.ty[i] = slope[1];
    rays.weight[i] = 0.2 + stream.uniform(100000000 + u);
    if (kind == Kind::kTies && i >= n / 2) {
      rays.x[i] = -rays.x[i - n / 2];
      rays.y[i] = -rays.y[i - n / 2];
      rays.tx[i] = -rays.tx[i - n / 2];
      rays.ty[i] = -rays.ty[i - n / 2];
    }
    if (kind == Kind::kZeroWeights && i % 3 == 1) rays.weight[i] = 0;
    if (kind == Kind::kLost && i % 5 == 2)
      rays.x[i] = rays.y[i] = rays.tx[i] = rays.ty[i] = rays.weight[i] = 0;
    if (kind == Kind::kOnePoint) rays.x[i] = 1.25, rays.y[i] = 0.5, rays.tx[i] = rays.ty[i] = 0.25;
  }
  if (kind == Kind::kHeavyTail) rays.x[n / 2] *= 1e6;
  rays.x *= kSigma;
  rays.y *= kSigma;
  rays.tx *= kSlope;
  rays.ty *= kSlope;
  rays.weight /= rays.weight.sum();
  return rays;
}

struct Plane {
  std::vector<double> radius;
  Real total = 0;
};
Plane plane_of(const RayBundle& rays, double dz, Centre centre) {
  Plane plane;
  Real cx = 0, cy = 0;
  for (Eigen::Index i = 0; i < rays.size(); ++i) plane.total += rays.weight[i];
  for (Eigen::Index i = 0; centre == Centre::kCentroid && i < rays.size(); ++i) {
    cx += rays.weight[i] * (Real(rays.x[i]) + Real(dz) * rays.tx[i]) / plane.total;
    cy += rays.weight[i] * (Real(rays.y[i]) + Real(dz) * rays.ty[i]) / plane.total;
  }
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const Real x = Real(rays.x[i]) + Real(dz) * rays.tx[i] - cx,
               y = Real(rays.y[i]) + Real(dz) * rays.ty[i] - cy;
    plane.radius.push_back(double(std::sqrt(x * x + y * y)));
  }
  return plane;
}

double order_statistic(const RayBundle& rays, const Plane& plane, double fraction) {
  std::vector<std::pair<double, Eigen::Index>> sorted;
  for (std::size_t i = 0; i < plane.radius.size(); ++i) sorted.push_back({plane.radius[i], Eigen::Index(i)});
  std::sort(sorted.begin(), sorted.end());
  const Real wanted = fraction * plane.total;
  Real sum = 0, before = 0, radius = 0;
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const Real here = sum + Real(rays.weight[sorted[k].second]) / 2;
    sum += rays.weight[sorted[k].second];
    if (here >= wanted) {
      if (k == 0 || here == before) return sorted[k].first;
      return double(radius + (sorted[k].first - radius) * (wanted - before) / (here - before));
    }
    before = here;
    radius = sorted[k].first;
  }
  return double(radius);
}

Real indicator(Real u) {  // integral of 35/32 (1-t^2)^3 from -1 to u
  if (u <= -1 || u >= 1) return u < 0 ? 0 : 1;
  const Real u3 = u * u * u;
  return 0.5L + (35.0L / 32.0L) * (u - u3 + 0.6L * u3 * u * u - u3 * u3 * u / 7);
}

Real smooth_count(const RayBundle& rays, const Plane& plane, Real radius, double width) {
  Real count = 0;
  for (std::size_t i = 0; i < plane.radius.size(); ++i) {
    const Real r = plane.radius[i];
    count += rays.weight[Eigen::Index(i)] * indicator((radius - r) * (radius + r) / (2 * radius * width));
  }
  return count;
}

std::string name(Kind kind, Eigen::Index n, double extra) {
  return "kind " + std::to_string(int(kind)) + ", " + std::to_string(n) + " rays, " + std::to_string(extra);
}

constexpr Eigen::Index kSizes[] = {1, 2, 3, 5, 8, 17, 50, 1000, 40000};

}  // namespace

TEST(BruteForce, ExactRadiiAreThoseOfAFullSort) {
  const std::vector<double> fractions = {0.013, 0.2171, 0.5077, 0.6533, 0.9037, 0.9941};
  for (const Kind kind : kKinds) {
    for (const Eigen::Index n : kSizes) {
      const RayBundle rays = bundle(kind, n);
      for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
        if (kind == Kind::kOnePoint && centre == Centre::kCentroid) continue;  // rounding errors only
        if (n <= 2 && centre == Centre::kCentroid) continue;               // likewise with one weighted ray
        if (kind == Kind::kTies && centre == Centre::kCentroid) continue;  // these radii tie up to rounding
        std::vector<Statistic> statistics;
        std::vector<double> expected;
        for (const double dz : {0.0, 1e-3, -4e-3}) {
          const Plane plane = plane_of(rays, dz, centre);
          for (const double p : fractions) {
            statistics.push_back(EncircledEnergyRadius{p, dz});
            expected.push_back(order_statistic(rays, plane, p));
          }
        }
        const Eigen::ArrayXd none;
        const Eigen::VectorXd found = evaluate_exact({rays, rays, none, centre}, statistics, 2);
        // Rounding: 1e-15 of radii; for sums of n weights 1e-16 n times the distance of neighbours.
        for (std::size_t k = 0; k < expected.size(); ++k)
          EXPECT_NEAR(found[Eigen::Index(k)] / expected[k], 1.0, 1e-11) << name(kind, n, fractions[k % 6]);
      }
    }
  }
}

TEST(BruteForce, SmoothRadiiAreRootsOfTheFullCount) {
  const std::vector<double> fractions = {0.0413, 0.2171, 0.5077, 0.9037, 0.9541};
  for (const Kind kind : kKinds) {
    for (const Eigen::Index n : kSizes) {
      if (n > 1000 && kind != Kind::kGaussian && kind != Kind::kHeavyTail) continue;  // too slow
      const RayBundle rays = bundle(kind, n);
      for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
        if (kind == Kind::kOnePoint && centre == Centre::kCentroid) continue;  // rounding errors only
        if (n <= 2 && centre == Centre::kCentroid) continue;  // likewise with one weighted ray
        for (const double width : {0.02 * kSigma, 1e-3 * kSigma, 0.3 * kSigma, 3 * kSigma}) {
          for (const double dz : {0.0, 1e-3}) {
            const Plane plane = plane_of(rays, dz, centre);
            std::vector<Statistic> statistics;
            for (const double p : fractions) statistics.push_back(EncircledEnergyRadius{p, dz});
            const Eigen::ArrayXd none;
            Eigen::VectorXd found;
            evaluate_smooth({rays, rays, none, centre}, statistics, width, 1, &found, nullptr);
            for (std::size_t k = 0; k < fractions.size(); ++k) {
              const Real wanted = fractions[k] * plane.total;
              Real low = 0, high = 1e3 * kSigma;
              if (kind == Kind::kHeavyTail) high = 1e8 * kSigma;
              for (int step = 0; step < 75; ++step) {
                const Real middle = (low + high) / 2;
                (smooth_count(rays, plane, middle, width) > wanted ? high : low) = middle;
              }
              const double radius = double((low + high) / 2), step = 1e-5 * width;
              const double density = double(smooth_count(rays, plane, radius + step, width) -
                                            smooth_count(rays, plane, radius - step, width)) /
                                     (2 * step);
              // If no ray lies near, every radius between two rays is a root, so we do not compare.
              if (!(density * width > 1e-4)) continue;
              // The header's error bound, and rounding of the count over its slope.
              const double tolerance = 1e-11 + 4e-15 / (density * radius);
              EXPECT_NEAR(found[Eigen::Index(k)] / radius, 1.0, tolerance)
                  << name(kind, n, fractions[k]) << " width " << width / kSigma << " dz " << dz;
            }
          }
          if (n > 1000) break;
        }
      }
    }
  }
}

TEST(BruteForce, RingCrossingsHalveThePeakOfTheFullShare) {
  for (const Kind kind : {Kind::kGaussian, Kind::kTies, Kind::kZeroWeights, Kind::kLost, Kind::kHeavyTail}) {
    for (const Eigen::Index n : {50, 300, 1001, 20000}) {
      const RayBundle rays = bundle(kind, n);
      const RaySums sums = sum_rays(rays, 1);
      for (const double width : {0.05 * kSigma, 0.5 * kSigma, 1.4 * kSigma}) {
        const Ring ring{1.5 * kSigma, 0.1 * kSigma, -0.05 * kSigma};
        RingBuffers buffers;
        const auto found = smooth_ring_width(rays, sums, ring, width, 1, &buffers, false, nullptr, nullptr);
        const auto share = [&](double z) {
          Real sum = 0;
          for (Eigen::Index i = 0; i < n; ++i) {
            const Real x = Real(rays.x[i]) + Real(z) * rays.tx[i] - ring.centre_x;
            const Real y = Real(rays.y[i]) + Real(z) * rays.ty[i] - ring.centre_y;
            sum += rays.weight[i] *
                   indicator((Real(ring.radius) * ring.radius - x * x - y * y) / (2 * ring.radius * width));
          }
          return sum;
        };
        const auto counted = exact_ring_width(rays, sums, ring, 1, &buffers);
        ASSERT_TRUE(counted.has_value());
        if (!found) {
          EXPECT_LE(n, 300);  // with few rays there may be no smooth peak near the counted one
          continue;
        }
        EXPECT_NEAR(double(share(found->peak)) / found->peak_share, 1.0, 1e-13);
        EXPECT_NEAR(double(share(found->lower)) / found->peak_share, 0.5, 1e-12)
            << name(kind, n, width / kSigma);
        EXPECT_NEAR(double(share(found->upper)) / found->peak_share, 0.5, 1e-12)
            << name(kind, n, width / kSigma);
        const double step = 1e-3 * found->fwhm;  // a maximum, up to fourth order
        EXPECT_LE(double(share(found->peak + step) + share(found->peak - step)),
                  2 * found->peak_share * (1 + 1e-6));
        EXPECT_NEAR(found->upper - found->lower, found->fwhm, 1e-12 * found->fwhm);
      }
    }
  }
}

TEST(BruteForce, RingCountsAreThoseOfEveryPlane) {
  // Uses the same planes, but tests every ray next to a crossing.
  const RayBundle rays = bundle(Kind::kGaussian, 5000);
  const RaySums sums = sum_rays(rays, 1);
  const Ring ring{2 * kSigma, 0, 0};
  RingBuffers buffers;
  const auto found = exact_ring_width(rays, sums, ring, 3, &buffers);
  ASSERT_TRUE(found.has_value());
  const auto inside = [&](double z) {
    const Eigen::ArrayXd x = rays.x + z * rays.tx, y = rays.y + z * rays.ty;
    return (x.square() + y.square() <= ring.radius * ring.radius).select(rays.weight, 0.0).sum();
  };
  // Single rays are steps: about six lie between neighbouring planes.
  EXPECT_NEAR(inside(found->lower) / found->peak_share, 0.5, 12.0 / 5000);
  EXPECT_NEAR(inside(found->upper) / found->peak_share, 0.5, 12.0 / 5000);
  EXPECT_NEAR(inside(found->peak) / found->peak_share, 1.0, 12.0 / 5000);
}

TEST(BruteForce, AnglesAreThoseOfTheArctangentAtEverySize) {
  for (const double size : {0.0, 1e-9, 1e-5, 1e-2, 0.06, 0.3, 3.0}) {
    for (const Eigen::Index n : {1, 7, 8, 1003}) {
      RayBundle rays = bundle(Kind::kGaussian, n), nominal = bundle(Kind::kTies, n);
      nominal.tx *= 3;
      rays.tx = nominal.tx + size * rays.tx / kSlope;
      rays.ty = nominal.ty + size * rays.ty / kSlope;
      Real squares = 0, firsts = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        const Real dx = Real(rays.tx[i]) - nominal.tx[i], dy = Real(rays.ty[i]) - nominal.ty[i];
        const Real vx = nominal.tx[i], vy = nominal.ty[i], cz = dx * vy - dy * vx;
        const Real angle =
            std::atan2(std::sqrt(dx * dx + dy * dy + cz * cz), 1 + rays.tx[i] * vx + rays.ty[i] * vy);
        squares += rays.weight[i] * angle * angle;
        firsts += rays.weight[i] * angle;
      }
      const AngleSums sums = sum_angles(rays, nominal, 1);
      EXPECT_NEAR(sums.squares, double(squares), 1e-14 * double(squares)) << size;
      EXPECT_NEAR(sums.firsts, double(firsts), 1e-14 * double(firsts)) << size;
    }
  }
}

TEST(BruteForce, EveryInstructionSetGivesTheSameStatisticsToRounding) {
  const RayBundle rays = bundle(Kind::kGaussian, 512), nominal = bundle(Kind::kTies, 512);
  const RayBlock block{rays.x.data(), rays.y.data(), rays.tx.data(), rays.ty.data(), rays.weight.data(), 512};
  const BinnedPlane plane{1e-3, 1e-6, -2e-6, 1e-12, 1e-6, 0};
  const DiscShape disc{0, 0, kSigma * kSigma, 1 / (0.4 * kSigma * kSigma)};
  const PlaneWindow windows[2] = {{1e-3, 1e-4}, {-2e-3, 1e-4}};
  const auto run = [&](InstructionSet set) {
    const FocusKernels& k = focus_kernels(set);
    std::vector<double> out;
    double r2[512], d[512], sums[3] = {}, inside[2] = {}, angle[2] = {};
    std::int32_t a[512], b[512];
    k.bins(block, plane, r2, a);
    for (int i = 0; i < 512; ++i) out.push_back(r2[i]);
    k.count(r2, block.weight, 512, disc, sums);
    out.insert(out.end(), {sums[0], sums[1]});
    k.intervals(block, 0, 0, 4 * kSigma * kSigma, -0.01, 1e4, 200, a, b);
    for (int i = 0; i < 512; ++i) out.insert(out.end(), {1.0 + a[i], 1.0 + b[i]});
    k.classify(block, 0, 0, 0.8 * kSigma * kSigma, 1.2 * kSigma * kSigma, 2, windows, a, inside);
    for (int i = 0; i < 512; ++i) out.push_back(1.0 + a[i]);
    out.insert(out.end(), {inside[0], inside[1]});
    double total[3] = {};
    k.share(block, 1e-3, disc, total);
    k.share_density(block, 1e-3, disc, d);
    out.insert(out.end(), {total[0], total[1], total[2], d[5], d[100]});
    k.angles(block, nominal.tx.data(), nominal.ty.data(), angle);
    out.insert(out.end(), {angle[0], angle[1]});
    return out;
  };
  const std::vector<double> baseline = run(InstructionSet::kBaseline);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    const std::vector<double> other = run(set);
    ASSERT_EQ(other.size(), baseline.size());
    for (std::size_t i = 0; i < baseline.size(); ++i)
      EXPECT_NEAR(other[i], baseline[i], 1e-12 * std::abs(baseline[i])) << i;
  }
}

TEST(BruteForce, RaysThatAreNoNumbersAreSaidSo) {
  RayBundle rays = bundle(Kind::kGaussian, 500);
  for (Eigen::Index i = 0; i < 500; i += 2) rays.x[i] = std::nan("");
  const Eigen::ArrayXd none;
  Eigen::VectorXd values;
  for (const Centre centre : {Centre::kNominal, Centre::kCentroid}) {
    EXPECT_FALSE(std::isfinite(
        evaluate_exact({rays, rays, none, Centre::kCentroid}, {EncircledEnergyRadius{0.9, 0}}, 1)[0]));
    EXPECT_FALSE(evaluate_smooth({rays, rays, none, centre}, {EncircledEnergyRadius{0.9, 0}, RmsRadius{}},
                                 1e-6, 1, &values, nullptr));
  }
}
