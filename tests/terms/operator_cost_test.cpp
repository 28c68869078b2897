#include "aberfit/terms/operator_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "operator_cases.h"

using namespace aberfit;
using namespace operator_cases;

namespace {

TermSet zernikes(int n_min, int n_max) { return {kRadius, zernike_modes(n_min, n_max), {}, {}}; }
TermSet waves(int count) { return {0, {}, plane_waves(count), {}}; }

PointLayout scattered(Eigen::Index points) { return {points, 0, 0, 0, 0}; }
PointLayout polar(Eigen::Index rings, Eigen::Index spokes) { return {rings * spokes, rings, spokes, 0, 0}; }
PointLayout grid(Eigen::Index rows, Eigen::Index columns) {
  return {rows * columns * 11 / 14, 0, 0, rows, columns};
}

double both(const OperatorSeconds& seconds) { return seconds.forward + seconds.adjoint; }

}  // namespace

TEST(OperatorCost, ChoosesByStructureAndSize) {
  // 432 terms (n = 2 to 28) at 65536 points on rings: tens of recurrence steps a point against one transform.
  EXPECT_EQ(choose_operator(zernikes(2, 28), polar(124, 528)).zernike, ZernikeMethod::kPolar);
  EXPECT_EQ(choose_operator(zernikes(2, 28), scattered(15000)).zernike, ZernikeMethod::kFused);
  EXPECT_EQ(choose_operator(zernikes(2, 28), grid(138, 138)).zernike, ZernikeMethod::kFused);
  // One ring of eight points: the sixteen rings taken at a time would be fifteen too many.
  EXPECT_EQ(choose_operator(zernikes(2, 28), polar(1, 8)).zernike, ZernikeMethod::kFused);
  EXPECT_EQ(choose_operator(waves(400), grid(138, 138)).fourier, FourierMethod::kGrid);
  EXPECT_EQ(choose_operator(waves(400), scattered(15000)).fourier, FourierMethod::kPhaseSums);
  EXPECT_EQ(choose_operator(waves(400), polar(124, 528)).fourier, FourierMethod::kPhaseSums);
}

TEST(OperatorCost, ChoosesPerFamilyAndOnlyForFamiliesThatAreThere) {
  TermSet terms = zernikes(2, 28);
  terms.fourier = plane_waves(40);
  const OperatorChoice mixed = choose_operator(terms, polar(124, 528));
  EXPECT_EQ(mixed.zernike, ZernikeMethod::kPolar);
  EXPECT_EQ(mixed.fourier, FourierMethod::kPhaseSums);
  EXPECT_NE(mixed.reason.find("polar"), std::string::npos);
  EXPECT_NE(mixed.reason.find("phase-sums"), std::string::npos);
  EXPECT_FALSE(choose_operator(zernikes(2, 4), scattered(100)).fourier.has_value());
  EXPECT_FALSE(choose_operator(waves(4), scattered(100)).zernike.has_value());
}

TEST(OperatorCost, TheChoiceCostsNoMoreThanAnyOther) {
  for (const int n : {2, 8, 20, 60})
    for (const PointLayout& layout :
         {polar(1, 8), polar(4, 24), polar(48, 208), polar(500, 2000), polar(20, 536)}) {
      const TermSet terms = zernikes(0, n);
      const OperatorChoice choice = choose_operator(terms, layout);
      const double chosen = choice.forward_seconds + choice.adjoint_seconds;
      for (const ZernikeMethod method : {ZernikeMethod::kFused, ZernikeMethod::kPolar})
        EXPECT_LE(chosen, both(predicted_seconds(method, terms, layout)) * (1 + 1e-12));
    }
}

TEST(OperatorCost, NamedMethodsAreKeptAndRefusedWhereTheyCannotBe) {
  OperatorOptions options;
  options.zernike = ZernikeMethod::kFused;
  EXPECT_EQ(choose_operator(zernikes(2, 28), polar(124, 528), options).zernike, ZernikeMethod::kFused);
  options.zernike = ZernikeMethod::kPolar;
  EXPECT_THROW(choose_operator(zernikes(2, 28), scattered(100), options), std::invalid_argument);
  options.zernike = ZernikeMethod::kDense;
  EXPECT_THROW(choose_operator(zernikes(2, 28), scattered(10000000), options), std::invalid_argument);
  options.fourier = FourierMethod::kGrid;
  EXPECT_THROW(choose_operator(waves(3), scattered(100), options), std::invalid_argument);
}

TEST(OperatorCost, GrowsWithTermsAndPointsAndIsInfiniteWhereImpossible) {
  for (const ZernikeMethod method : {ZernikeMethod::kFused, ZernikeMethod::kPolar, ZernikeMethod::kDense}) {
    const double small = both(predicted_seconds(method, zernikes(0, 10), polar(32, 128)));
    EXPECT_GT(small, 0);
    EXPECT_GT(both(predicted_seconds(method, zernikes(0, 20), polar(32, 128))), small);
    EXPECT_GT(both(predicted_seconds(method, zernikes(0, 10), polar(64, 128))), small);
  }
  EXPECT_TRUE(std::isinf(predicted_seconds(ZernikeMethod::kPolar, zernikes(0, 10), scattered(100)).forward));
  EXPECT_TRUE(std::isinf(predicted_seconds(FourierMethod::kGrid, waves(10), scattered(100)).adjoint));
  EXPECT_TRUE(
      std::isinf(predicted_seconds(ZernikeMethod::kDense, zernikes(0, 100), scattered(9000)).forward));
  EXPECT_EQ(both(predicted_seconds(ZernikeMethod::kPolar, waves(3), scattered(100))), 0);
}

TEST(OperatorCost, ListedRaysGoPointByPointWhileTheyAreFew) {
  const TermSet terms = zernikes(2, 40);
  const PointLayout layout = polar(124, 528);
  const Eigen::Index enough = enough_rays(ZernikeMethod::kPolar, terms, layout);
  EXPECT_GT(enough, layout.points / 200);
  EXPECT_LT(enough, layout.points / 5);
  // Where the method does not pay even for all points, no list is long enough.
  EXPECT_GT(enough_rays(ZernikeMethod::kPolar, zernikes(0, 1), polar(1, 8)), 8);
}

TEST(OperatorCost, LayoutIsReadFromThePupil) {
  const PointLayout on_rings = point_layout(rings(5, 12));
  EXPECT_EQ(on_rings.points, 60);
  EXPECT_EQ(on_rings.rings, 5);
  EXPECT_EQ(on_rings.spokes, 12);
  EXPECT_EQ(on_rings.rows, 0);
  const PupilSample some = scrambled_grid(9, 7);
  const PointLayout on_grid = point_layout(some);
  EXPECT_EQ(on_grid.points, some.size());
  EXPECT_EQ(on_grid.columns, 9);
  EXPECT_EQ(on_grid.rows, 7);
  EXPECT_EQ(on_grid.rings, 0);
}
