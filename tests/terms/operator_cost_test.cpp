#include "aberfit/terms/operator_cost.h"

#include <gtest/gtest.h>

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

}  // namespace

TEST(OperatorCost, ChoosesByStructure) {
  // 432 terms at 65536 points on rings: one transform replaces tens of recurrence steps per point.
  EXPECT_EQ(choose_operator(zernikes(2, 28), polar(124, 528)).zernike, ZernikeMethod::kPolar);
  EXPECT_EQ(choose_operator(zernikes(2, 28), scattered(15000)).zernike, ZernikeMethod::kFused);
  EXPECT_EQ(choose_operator(zernikes(2, 28), grid(138, 138)).zernike, ZernikeMethod::kFused);
  EXPECT_EQ(choose_operator(waves(400), grid(138, 138)).fourier, FourierMethod::kPhaseSums);
  EXPECT_EQ(choose_operator(waves(400), scattered(15000)).fourier, FourierMethod::kPhaseSums);
  TermSet lattice = waves(0);
  lattice.fourier = {{2.5, 0}, {0, 2.5}};
  lattice.fourier_pitch = 2.5;
  for (const PointLayout& layout : {grid(138, 138), scattered(15000), polar(124, 528)})
    EXPECT_EQ(choose_operator(lattice, layout).fourier, FourierMethod::kLattice);
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

TEST(OperatorCost, NamedMethodsAreKeptAndRefusedWhereTheyCannotBe) {
  OperatorOptions options;
  options.zernike = ZernikeMethod::kFused;
  EXPECT_EQ(choose_operator(zernikes(2, 28), polar(124, 528), options).zernike, ZernikeMethod::kFused);
  options.zernike = ZernikeMethod::kPolar;
  EXPECT_THROW(choose_operator(zernikes(2, 28), scattered(100), options), std::invalid_argument);
  options.fourier = FourierMethod::kLattice;
  EXPECT_THROW(choose_operator(waves(3), scattered(100), options), std::invalid_argument);
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
