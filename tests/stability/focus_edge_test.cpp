// Radii where no ray falls, smoothing that goes to zero, two foci, and mirrors that are nearly perfect.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/forward/forward_model.h"
#include "edge.h"
#include "fit/fit_scene.h"

namespace aberfit::test {
namespace {

constexpr double kSpot = 1e-6;  // [m]

RayBundle empty_bundle(Eigen::Index count) {
  RayBundle rays;
  for (Eigen::ArrayXd* part : {&rays.x, &rays.y, &rays.tx, &rays.ty}) part->setZero(count);
  rays.weight = Eigen::ArrayXd::Constant(count, 1.0 / double(count));
  return rays;
}

double exact(const RayBundle& rays, const Statistic& statistic, Warnings* warnings = nullptr) {
  return evaluate_exact({rays, rays, {}}, {statistic}, 1, warnings)[0];
}

TEST(StabilityEdge, RadiusInAGap) {
  // Nine tenths of the light in a Gaussian core, a tenth in a ring 100 times larger. Two samples of 10,000
  // rays of the same light: the radius that holds a fraction near 0.9 is a matter of chance, but the energy
  // in a given radius is not. Targets of radii are met and judged by energy (`aim_of`).
  Edge edge("radius_in_a_gap", "fraction of the light [1]",
            "difference of the light inside; grey: relative difference of the radii [1]");
  edge.linear_parameter();
  constexpr Eigen::Index kRays = 10000;
  const auto sample = [](std::uint64_t seed) {
    RayBundle rays = empty_bundle(kRays);
    const RandomStream stream(seed, "radius-in-a-gap");
    for (Eigen::Index i = 0; i < kRays; ++i) {
      const auto [u, v] = stream.uniform_pair(std::uint64_t(i));
      const bool core = stream.uniform(std::uint64_t(kRays + i)) < 0.9;
      const double r = core ? kSpot * std::sqrt(-2 * std::log(u)) : 100 * kSpot * (1 + 0.1 * u);
      rays.x[i] = r * std::cos(2 * std::numbers::pi * v), rays.y[i] = r * std::sin(2 * std::numbers::pi * v);
    }
    return rays;
  };
  const RayBundle one = sample(1), other = sample(2);
  const double between = exact(other, RingThrough{50 * kSpot, 0}) - exact(one, RingThrough{50 * kSpot, 0});
  ASSERT_GT(std::abs(between), 1e-3) << "the two samples have the same core: take another seed";
  for (const double p :
       {0.5, 0.6, 0.7, 0.8, 0.85, 0.88, 0.89, 0.895, 0.898, 0.9, 0.902, 0.905, 0.91, 0.92, 0.95, 0.99}) {
    const double radius = exact(one, EncircledEnergyRadius{p, 0});
    // The promise is 4 standard errors of a difference of two fractions (binomial).
    edge.add({p, std::abs(exact(other, RingThrough{radius, 0}) - p), 4 * std::sqrt(2 * p * (1 - p) / kRays),
              false, std::abs(exact(other, EncircledEnergyRadius{p, 0}) / radius - 1)});
  }
  // At this fraction the radius is inside the core for one sample and beyond the gap for the other.
  const double core = exact(one, RingThrough{50 * kSpot, 0}) + 0.5 * between;
  const double radius = exact(one, EncircledEnergyRadius{core, 0});
  edge.add({core, std::abs(exact(other, RingThrough{radius, 0}) - core), 4 * std::sqrt(2 * 0.09 / kRays),
            false, std::abs(exact(other, EncircledEnergyRadius{core, 0}) / radius - 1)});
  edge.expect();
}

TEST(StabilityEdge, RadiusAtACaustic) {
  // The density of the rays goes as 1/sqrt(a - r) below the caustic r = a. The smooth statistic is wrong by a
  // multiple of width^2, as evaluate.h says, until the kernel reaches the caustic (w = 0.01), and by no more
  // beyond. A kernel of a thousand spots is refused.
  Edge edge("radius_at_a_caustic", "half-width of the kernel / radius of the caustic [1]",
            "shift of ee90 / radius of the caustic [1]");
  constexpr Eigen::Index kRays = 200000;
  RayBundle rays = empty_bundle(kRays);
  for (Eigen::Index i = 0; i < kRays; ++i) {
    const double u = 1 - (double(i) + 0.5) / kRays, v = double(i) * 0.6180339887498949;
    const double r = kSpot * (1 - u * u);  // E(r) = 1 - sqrt(1 - r/a)
    rays.x[i] = r * std::cos(2 * std::numbers::pi * v), rays.y[i] = r * std::sin(2 * std::numbers::pi * v);
  }
  for (const double width : geometric_steps(1e-4, 1e4, 33)) {
    Eigen::VectorXd value;
    EdgeRow row{width, std::nan(""), 3.5 * width * width, true};
    if (evaluate_smooth({rays, rays, {}}, {EncircledEnergyRadius{0.9, 0}}, width * kSpot, 1, &value,
                        nullptr)) {
      row.told = false;
      row.error = std::abs(value[0] / kSpot - 0.99);
    }
    edge.add(row);
  }
  edge.expect();
}

TEST(StabilityEdge, RadiusAtTies) {
  // All rays lie between two circles. A stretch along x alone changes ee90 by half of it, the mean of cos^2
  // over all directions. When the rays tie, a difference of exact radii sees only the ray that happens to be
  // first.
  Edge edge("radius_at_ties", "width of the ring of rays / its radius [1]",
            "relative error of the derivative of ee90 [1]");
  constexpr Eigen::Index kRays = 100000;
  constexpr double kStretch = 1e-3, kWidth = 0.01;  // kernel over radius
  for (const double ring : geometric_steps(0.5, 1e-8, 14)) {
    RayBundle rays = empty_bundle(kRays);
    for (Eigen::Index i = 0; i < kRays; ++i) {
      const double v = 2 * std::numbers::pi * double(i) * 0.6180339887498949;
      const double r = kSpot * (1 + ring * (double(i) + 0.5) / kRays);
      rays.x[i] = r * std::cos(v), rays.y[i] = r * std::sin(v);
    }
    const double radius = exact(rays, EncircledEnergyRadius{0.9, 0}), truth = 0.5 * radius;
    Eigen::VectorXd value;
    std::vector<StatisticGradient> gradient;
    ASSERT_TRUE(evaluate_smooth({rays, rays, {}}, {EncircledEnergyRadius{0.9, 0}}, kWidth * kSpot, 1, &value,
                                &gradient));
    EXPECT_LT(std::abs(value[0] - radius), kWidth * kSpot) << "shifted by more than the width";
    const RayGradient& g = gradient[0].rays;
    double along = 0;
    for (std::size_t i = 0; i < g.rays.size(); ++i) along += g.d_x[i] * rays.x[g.rays[i]];
    RayBundle stretched = rays;
    stretched.x *= 1 + kStretch;
    const double difference = (exact(stretched, EncircledEnergyRadius{0.9, 0}) - radius) / kStretch;
    // The directions are uniform to a few parts in the number of rays under the kernel.
    edge.add({ring, std::abs(along / truth - 1), 0.01, false, std::abs(difference / truth - 1)});
  }
  edge.expect();
}

// RMS of the relative error of d ee90/d log s over `spots` Gaussian spots of `count` rays. s is a stretch
// along x alone, and ee90 changes by half of it.
double gradient_error(Eigen::Index count, int spots, double width) {
  double squares = 0;
  for (int k = 0; k < spots; ++k) {
    RayBundle rays = empty_bundle(count);
    RandomStream(std::uint64_t(k + 1), "smoothing-to-zero")
        .normal_pairs(0, int(count), rays.x.data(), rays.y.data());
    rays.x *= kSpot, rays.y *= kSpot;
    Eigen::VectorXd value;
    std::vector<StatisticGradient> gradient;
    EXPECT_TRUE(evaluate_smooth({rays, rays, {}}, {EncircledEnergyRadius{0.9, 0}}, width * kSpot, 1, &value,
                                &gradient));
    const RayGradient& g = gradient[0].rays;
    double along = 0;
    for (std::size_t i = 0; i < g.rays.size(); ++i) along += g.d_x[i] * rays.x[g.rays[i]];
    squares += std::pow(along / (0.5 * kGaussianEe90 * kSpot) - 1, 2);
  }
  return std::sqrt(squares / spots);
}

TEST(StabilityEdge, SmoothingToZero) {
  // The gradient of ee90 is a mean over the N_k rays that the kernel touches. Here it is the mean of cos^2,
  // with a relative error of sqrt(1/(2 N_k)); in the end N_k is one, whatever the spot. N_k = N p(r) w, p(r)
  // = 0.2146/sigma at ee90. The program's own finest smoothing is FitOptions{}.smoothing.back() with 65,536
  // rays.
  Edge edge("smoothing_to_zero", "half-width of the kernel / spot sigma, grey: 8192 rays [1]",
            "RMS relative error of the gradient of ee90 [1]");
  constexpr Eigen::Index kRays = 8192, kRaysOfFits = 65536;
  const double density = 0.1 * kGaussianEe90, own = FitOptions{}.smoothing.back();
  const auto law = [=](double rays, double width) { return std::sqrt(1 / (2 * rays * density * width)); };
  const double error = gradient_error(kRaysOfFits, 6, own);
  for (const double width : geometric_steps(1e-6, 0.5, 14))
    edge.add({width, error, 2 * law(kRaysOfFits, own), false, gradient_error(kRays, 24, width)});
  edge.follows({"sqrt(1/(2 N p(r) w))", [=](double w) { return law(kRays, w); }, 2e-3, 0.2, 1.5});
  edge.expect();
}

// Fraction inside the ring of a full cone that crosses the axis at dz = focus; ring and largest slope are 1.
double inside(double dz, double focus) { return std::min(1.0, 1 / std::pow(dz - focus, 2)); }

TEST(StabilityEdge, TwoFoci) {
  // 55 and 45 % of the energy have foci apart, by a distance in units of ring / slope. First the profile has
  // a dip, then a dip below half. The truth is the width of the closed profile between its outermost half
  // crossings.
  Edge edge("two_foci", "distance of the foci / (ring / slope) [1]",
            "width of the ring profile over that of all its light, less 1 [1]");
  edge.linear_parameter();
  constexpr Eigen::Index kRays = 40000;
  constexpr double kRing = 1e-5, kSlope = 1e-3;
  for (double distance = 0.5; distance < 8.1; distance += 0.5) {
    RayBundle rays = empty_bundle(kRays);
    for (Eigen::Index i = 0; i < kRays; ++i) {
      const double t = kSlope * std::sqrt((double(i / 2) + 0.5) / (kRays / 2));
      rays.tx[i] = t, rays.weight[i] = (i % 2 ? 0.45 : 0.55) / (kRays / 2);
      if (i % 2) rays.x[i] = -t * distance * kRing / kSlope;
    }
    const auto profile = [&](double z) { return 0.55 * inside(z, 0) + 0.45 * inside(z, distance); };
    double peak = 0, first = 1e9, last = -1e9;
    constexpr double kStep = 1e-3;
    for (double z = -10; z < 20; z += kStep) peak = std::max(peak, profile(z));
    for (double z = -10; z < 20; z += kStep)
      if (profile(z) >= 0.5 * peak) first = std::min(first, z), last = z;
    Warnings warnings;
    const double found = exact(rays, RingFwhm{0.9, kRing}, &warnings) * kSlope / kRing;
    edge.add({distance, std::abs(found / (last - first) - 1), 2e-3,
              warnings.size() == 1 && warnings[0].code == "ring-fwhm-crossings"});
  }
  edge.expect();
}

TEST(StabilityEdge, NearlyPerfectMirrors) {
  // Radii in focus are of degree 1 in the coefficients, so their derivatives along the coefficients equal the
  // radii. Rounding of the ray positions, 2e-17 m, disturbs this. The reference is a surface of a nanometre.
  Edge edge("nearly_perfect_mirrors", "RMS height of the surface [m]",
            "relative error of radii and their gradients [1]");
  const FitScene scene(6, {}, 4096, PupilLayout::kSobol);
  const LightPath path{scene.mirror, scene.pupil, scene.surface};
  const auto model = make_forward_model(
      path, {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.9, 0}, RmsRadius{0}}, 1);
  const Eigen::VectorXd draw = scene.prior.colour(draw_white(scene.prior.size(), 1));
  const double rms = draw.norm();  // orthonormal terms
  Eigen::Matrix<double, 6, 1> found, reference = found.setZero();
  for (const double height : geometric_steps(1e-9, 1e-21, 25)) {
    const Eigen::VectorXd c = draw * (height / rms);
    model->move_to(c);
    Eigen::VectorXd values;
    EdgeRow row{height, std::nan(""), 1e-3, true};
    if (model->evaluate(0.1 * scene.focal_sigma * height / rms, &values)) {
      found.head(3) = values / height;
      model->gradients([&](std::size_t k, const Eigen::VectorXd& gradient) {
        found[3 + Eigen::Index(k)] = gradient.dot(c) / height;
      });
      if (reference.isZero()) reference = found;
      row.told = false;
      row.error = (found.array() / reference.array() - 1).abs().maxCoeff();
    }
    edge.add(row);
  }
  edge.follows({"6e-21 m / height", [](double height) { return 6e-21 / height; }, 2e-17, 3e-13, 4});
  edge.expect();
  EXPECT_NE(model->trouble().find("all rays meet in one point"), std::string::npos) << model->trouble();
}

}  // namespace
}  // namespace aberfit::test
