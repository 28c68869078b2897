#include "aberfit/scene/pupil.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/core/errors.h"

using namespace aberfit;

namespace {

double mean(const PupilSample& pupil, const Eigen::ArrayXd& values) { return (pupil.weight * values).sum(); }

}  // namespace

TEST(Pupil, PolarQuadratureIsExactForPolynomialsOverDiscAndRing) {
  for (const double inner : {0.0, 0.08}) {
    const Aperture aperture =
        inner > 0 ? Aperture(AnnulusAperture{0.4, 2 * inner, 0}) : Aperture(CircleAperture{0.4, 0});
    const PupilSample pupil = make_pupil(aperture, {PupilLayout::kPolar, 4096, 1});
    const double a2 = inner * inner, b2 = 0.04;
    EXPECT_NEAR(pupil.weight.sum(), 1.0, 1e-14);
    for (int k = 1; k <= 20; ++k) {  // <rho^2k> = (b^(2k+2) - a^(2k+2)) / ((k+1) (b^2 - a^2))
      const double exact = (std::pow(b2, k + 1) - std::pow(a2, k + 1)) / ((k + 1) * (b2 - a2));
      EXPECT_NEAR(mean(pupil, (pupil.x.square() + pupil.y.square()).pow(k)) / exact, 1.0, 1e-12) << k;
      EXPECT_NEAR(mean(pupil, pupil.x.pow(k)) / std::pow(0.2, k),
                  k % 2 ? 0.0 : mean(pupil, pupil.y.pow(k)) / std::pow(0.2, k), 1e-14)
          << k;
    }
  }
}

TEST(Pupil, TheStructureSaysWhereThePointsAre) {
  const PupilSample polar = make_pupil(AnnulusAperture{0.4, 0.1, 0}, {PupilLayout::kPolar, 5000, 1});
  const auto& rings = std::get<PolarRings>(polar.structure);
  ASSERT_EQ(rings.rho.size() * rings.spokes, polar.size());
  for (Eigen::Index k = 0; k < polar.size(); ++k) {
    const Eigen::Index ring = k / rings.spokes;
    const double angle = 2 * M_PI * double(k % rings.spokes) / double(rings.spokes) + rings.turn[ring];
    EXPECT_NEAR(polar.x[k], rings.rho[ring] * std::cos(angle), 1e-15);
    EXPECT_NEAR(polar.y[k], rings.rho[ring] * std::sin(angle), 1e-15);
  }
  const PupilSample square = make_pupil(CircleAperture{0.4, 0.02}, {PupilLayout::kGrid, 3000, 1});
  const auto& grid = std::get<CartesianGrid>(square.structure);
  ASSERT_EQ(Eigen::Index(grid.column.size()), square.size());
  ASSERT_EQ(Eigen::Index(grid.row.size()), square.size());
  for (Eigen::Index k = 0; k < square.size(); ++k) {
    EXPECT_EQ(square.x[k], grid.x[grid.column[std::size_t(k)]]);
    EXPECT_EQ(square.y[k], grid.y[grid.row[std::size_t(k)]]);
  }
}

TEST(Pupil, PolarRingsHaveNoLargePrimeAndNearlyTheRaysAskedFor) {
  for (std::int64_t wanted = 200; wanted < 2000000; wanted = wanted * 5 / 3) {
    const PupilSample pupil = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kPolar, wanted, 1});
    Eigen::Index rest = std::get<PolarRings>(pupil.structure).spokes;
    for (const int prime : {2, 3, 5})
      while (rest % prime == 0) rest /= prime;
    EXPECT_EQ(rest, 1) << wanted;
    // The number of rings is an integer, so up to half the spokes are missing or extra: 1/(2 rings).
    const double spokes = std::sqrt(double(wanted) * 4 * M_PI / 3);
    EXPECT_NEAR(double(pupil.size()), double(wanted), 0.65 * spokes) << wanted;
  }
}

TEST(Pupil, EveryLayoutHasTheMomentsOfTheAperture) {
  // <x^2> is 0.4^2/12 for a 0.4 x 0.2 rectangle and R^2/4 for a disc. Points with equal weights have the
  // standard error sqrt(var(x^2)/N); grid and Sobol points do better.
  for (const PupilLayout layout : {PupilLayout::kRandom, PupilLayout::kSobol, PupilLayout::kGrid}) {
    const PupilSample rectangle = make_pupil(RectangleAperture{0.4, 0.2, 0}, {layout, 40000, 7});
    const double exact = 0.16 / 12, standard_error = exact * std::sqrt(0.8 / 40000);
    EXPECT_NEAR(mean(rectangle, rectangle.x.square()), exact, 4.5 * standard_error);
    const PupilSample disc = make_pupil(CircleAperture{0.4, 0}, {layout, 40000, 7});
    EXPECT_NEAR(mean(disc, disc.x.square()), 0.01, 4.5 * 0.01 * std::sqrt(1.0 / 40000));
    EXPECT_NEAR(mean(disc, disc.x * disc.y), 0.0, 4.5 * 0.0082 / 200);
    const PupilSample triangle =
        make_pupil(PolygonAperture{{{0.0, 0.0}, {0.3, 0.0}, {0.0, 0.3}}, 0}, {layout, 40000, 7});
    EXPECT_NEAR(mean(triangle, triangle.x), 0.1, 4.5 * 0.0708 / 200);
  }
}

TEST(Pupil, SobolPointsFillDyadicCellsEquallyAfterScrambling) {
  // In a (0, m, 2)-net every dyadic rectangle of area 2^-10 holds exactly one of the first 2^10 points.
  const Eigen::Array2Xd points = scrambled_sobol(1024, 99);
  for (int split = 0; split <= 10; ++split) {
    std::vector<int> hits(1024, 0);
    for (Eigen::Index i = 0; i < 1024; ++i) {
      const int x = int(points(0, i) * (1 << split)), y = int(points(1, i) * (1 << (10 - split)));
      ++hits[std::size_t(x * (1 << (10 - split)) + y)];
    }
    EXPECT_TRUE(std::all_of(hits.begin(), hits.end(), [](int h) { return h == 1; })) << split;
  }
  EXPECT_FALSE((points == scrambled_sobol(1024, 100)).all());
}

TEST(Pupil, MarginKeepsPointsFromTheEdge) {
  for (const PupilLayout layout :
       {PupilLayout::kPolar, PupilLayout::kRandom, PupilLayout::kSobol, PupilLayout::kGrid}) {
    const PupilSample pupil = make_pupil(CircleAperture{0.4, 0.01}, {layout, 5000, 3});
    EXPECT_LE((pupil.x.square() + pupil.y.square()).sqrt().maxCoeff(), 0.19 + 1e-15);
    EXPECT_NEAR(double(pupil.size()), 5000, 200);
  }
  EXPECT_THROW(make_pupil(CircleAperture{0.4, 0.3}, {PupilLayout::kSobol, 100, 1}), ComputationError);
  EXPECT_THROW(make_pupil(RectangleAperture{0.4, 0.4, 0}, {PupilLayout::kPolar, 100, 1}), ComputationError);
}

TEST(Pupil, SameSeedGivesTheSamePoints) {
  const PupilSample a = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 1000, 5});
  const PupilSample b = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 1000, 5});
  const PupilSample c = make_pupil(CircleAperture{0.4, 0}, {PupilLayout::kRandom, 1000, 6});
  EXPECT_TRUE((a.x == b.x).all());
  EXPECT_FALSE((a.x == c.x).all());
}
