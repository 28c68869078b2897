#include "aberfit/theory/ray_perturbation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "golden_csv.h"

using namespace aberfit;

namespace {

const Mirror kParabola{2.8, -1, {}};

PupilSample random_pupil(std::int64_t rays, std::uint64_t seed) {
  return make_pupil(CircleAperture{0.4}, {PupilLayout::kRandom, rays, seed});
}

Eigen::Array2Xd random_slopes(Eigen::Index n) {
  const RandomStream stream(1, "TracePerturbed slopes");
  Eigen::Array2Xd slopes(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto u = stream.uniform_pair(std::uint64_t(i));
    slopes(0, i) = 0.1 * u[0] - 0.05;
    slopes(1, i) = 0.1 * u[1] - 0.05;
  }
  return slopes;
}

using Vector = std::array<double, 3>;
Vector normalised(Vector v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

constexpr double kRounding = 1e-14;  // for lengths of metres; largest seen 2e-15

}  // namespace

// The slope error is added to the slopes of the whole nominal mirror.
TEST(TracePerturbed, FollowsKnownZernikesOfAnySymmetry) {
  Mirror mirror = kParabola;
  mirror.zernike = {{{2, -2}, 2e-4}, {{3, 1}, 1e-4}, {{4, 0}, -1e-4}};
  mirror.zernike_radius = 0.2;
  const PupilSample pupil = random_pupil(1000, 3);
  const Eigen::Array2Xd slopes = random_slopes(pupil.size());
  SurfaceField tilted;
  tilted.resize(pupil.size());
  tilted.height.setZero();
  tilted.slope_x = slopes.row(0).transpose();
  tilted.slope_y = slopes.row(1).transpose();
  const RayBundle found = trace_perturbed(mirror, pupil, slopes, Convention::kPhysical),
                  expected = trace(mirror, pupil, tilted);
  EXPECT_LT((found.x - expected.x).abs().maxCoeff(), kRounding);
  EXPECT_LT((found.y - expected.y).abs().maxCoeff(), kRounding);
  EXPECT_GT((found.x - trace_perturbed(kParabola, pupil, slopes, Convention::kPhysical).x).abs().maxCoeff(),
            1e-3);
}

TEST(TracePerturbed, RandomRaysMeetEveryFirstOrderGoldenStatistic) {
  const double n = 1e6, looks = 4.5;  // allowed standard errors; 12 comparisons
  const PupilSample pupil = random_pupil(std::int64_t(n), 11);
  const RayBundle nominal = trace_nominal(kParabola, pupil);
  const Eigen::ArrayXd no_height;
  int rows = 0;
  for (const GoldenRow& row : read_golden("geometry.csv")) {
    if (row.at("s") != "1e-05") continue;
    ++rows;
    const bool physical = row.at("branch") == "AT";
    const RayBundle rays =
        trace_perturbed(kParabola, pupil, 1e-5, physical ? Convention::kPhysical : Convention::kPaper, 5);
    EXPECT_EQ(rays.lost, 0);
    const Eigen::VectorXd found = evaluate_exact(
        {rays, nominal, no_height},
        {EncircledEnergyRadius{0.5, 0}, EncircledEnergyRadius{0.8, 0}, EncircledEnergyRadius{0.9, 0},
         RmsRadius{0}, ScatterRms{}, RingFwhm{0.9, std::stod(row.at("ee90_exact"))}},
        1);
    // An order statistic has the standard error sqrt(p (1-p)/n) / density. The density of a Rayleigh radius
    // at its quantile is (1-p) r/sigma^2 = (1-p) (-2 ln(1-p))/r. A mean of squares of Rayleigh lengths has
    // the relative standard error 1/sqrt(n), its root half of that.
    const auto quantile = [&](double p) {
      return std::sqrt(p * (1 - p) / n) / ((1 - p) * -2 * std::log1p(-p));
    };
    const std::array<double, 6> relative{
        quantile(0.5),      quantile(0.8),      quantile(0.9),
        0.5 / std::sqrt(n), 0.5 / std::sqrt(n), 0.007 * std::sqrt(15000 / n)};  // last one: PHYSICS 2
    const std::array<const char*, 6> column{"ee50_lin",       "ee80_lin",        "ee90_lin",
                                            "rms_radius_lin", "rms_scatter_lin", "ring_fwhm_lin"};
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(found[k] / std::stod(row.at(column[k])), 1.0, looks * relative[k])
          << row.at("branch") << " " << column[k];
  }
  EXPECT_EQ(rows, 2);
}

TEST(TracePerturbed, PhysicalRaysObeyTheLawOfReflection) {
  // Vector form d - 2 (d.n) n for the surface whose gradient includes the slope error.
  const PupilSample pupil = random_pupil(200, 2);
  const Eigen::Array2Xd error = random_slopes(pupil.size());
  const RayBundle rays = trace_perturbed(kParabola, pupil, error, Convention::kPhysical);
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const double x = pupil.x[i], y = pupil.y[i];
    const Vector normal = normalised({-x / 5.6 - error(0, i), -y / 5.6 - error(1, i), 1});
    const Vector d{2 * normal[2] * normal[0], 2 * normal[2] * normal[1], -1 + 2 * normal[2] * normal[2]};
    const double path = 2.8 - (x * x + y * y) / 11.2;
    EXPECT_NEAR(rays.tx[i], d[0] / d[2], kRounding);
    EXPECT_NEAR(rays.ty[i], d[1] / d[2], kRounding);
    EXPECT_NEAR(rays.x[i], x + path * d[0] / d[2], kRounding);
    EXPECT_NEAR(rays.y[i], y + path * d[1] / d[2], kRounding);
  }
}

TEST(TracePerturbed, PaperRaysAreTheNominalUnitVectorLessTheSlopeError) {
  const PupilSample pupil = random_pupil(200, 3);
  const Eigen::Array2Xd error = random_slopes(pupil.size());
  const RayBundle rays = trace_perturbed(kParabola, pupil, error, Convention::kPaper);
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const double x = pupil.x[i], y = pupil.y[i], z = (x * x + y * y) / 11.2;
    Vector u = normalised({-x, -y, 2.8 - z});  // a parabola sends the ray to its focus
    u = normalised({u[0] - error(0, i), u[1] - error(1, i), u[2]});
    EXPECT_NEAR(rays.tx[i], u[0] / u[2], kRounding);
    EXPECT_NEAR(rays.ty[i], u[1] / u[2], kRounding);
    EXPECT_NEAR(rays.x[i], x + (2.8 - z) * u[0] / u[2], kRounding);
    EXPECT_NEAR(rays.y[i], y + (2.8 - z) * u[1] / u[2], kRounding);
  }
}

TEST(TracePerturbed, WithoutErrorGivesTheNominalRays) {
  const PupilSample pupil = random_pupil(500, 4);
  const RayBundle nominal = trace_nominal(kParabola, pupil);
  for (const Convention convention : {Convention::kPhysical, Convention::kPaper}) {
    const RayBundle rays = trace_perturbed(kParabola, pupil, 0.0, convention, 1);
    EXPECT_LT((rays.x - nominal.x).abs().maxCoeff(), kRounding);
    EXPECT_LT((rays.ty - nominal.ty).abs().maxCoeff(), kRounding);
    EXPECT_TRUE((rays.weight == nominal.weight).all());
  }
}

TEST(TracePerturbed, ConventionsDifferByAFactorOfTwoOnAxis) {
  PupilSample vertex{Eigen::ArrayXd::Zero(1), Eigen::ArrayXd::Zero(1), Eigen::ArrayXd::Ones(1),
                     PupilLayout::kRandom};
  const double s = 1e-6;
  const RayBundle physical = trace_perturbed(kParabola, vertex, s, Convention::kPhysical, 9);
  const RayBundle paper = trace_perturbed(kParabola, vertex, s, Convention::kPaper, 9);
  EXPECT_NEAR(physical.x[0] / paper.x[0], 2.0, 1e-10);  // second order in s
  EXPECT_NEAR(physical.y[0] / paper.y[0], 2.0, 1e-10);
}

TEST(TracePerturbed, LostRaysAreCountedAndWeightless) {
  const PupilSample pupil = random_pupil(4, 6);
  Eigen::Array2Xd error = Eigen::Array2Xd::Zero(2, 4);
  error(0, 1) = 1.5;
  error(1, 2) = std::numeric_limits<double>::quiet_NaN();
  const RayBundle physical = trace_perturbed(kParabola, pupil, error, Convention::kPhysical);
  EXPECT_EQ(physical.lost, 2);
  EXPECT_EQ(physical.weight[1], 0.0);
  EXPECT_EQ(physical.weight[2], 0.0);
  EXPECT_DOUBLE_EQ(physical.weight.sum(), 0.5);
  EXPECT_TRUE(physical.x.isFinite().all());
  EXPECT_EQ(trace_perturbed(kParabola, pupil, error, Convention::kPaper).lost, 1);
}

TEST(TracePerturbed, SameSeedSameRaysOtherSeedOtherRays) {
  const PupilSample pupil = random_pupil(50, 7);
  const RayBundle a = trace_perturbed(kParabola, pupil, 1e-5, Convention::kPhysical, 1);
  const RayBundle b = trace_perturbed(kParabola, pupil, 1e-5, Convention::kPhysical, 1);
  const RayBundle c = trace_perturbed(kParabola, pupil, 1e-5, Convention::kPhysical, 2);
  EXPECT_TRUE((a.x == b.x).all());
  EXPECT_TRUE((a.x != c.x).all());
}
