// Compares the kernels of all instruction sets, because a whole operator uses only the best one.
#include <gtest/gtest.h>

#include <vector>

#include "../../src/terms/lattice_kernel.h"
#include "../../src/terms/polar_kernel.h"
#include "operator_cases.h"

using namespace aberfit;
using namespace aberfit::internal;
using namespace operator_cases;

namespace {

constexpr double kRounding = 1e-13;  // relative to the norm; fused multiply-adds and the order of sums differ

std::vector<InstructionSet> vector_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512})
    if (is_supported(set)) sets.push_back(set);
  return sets;
}

/// Compares the result of run(set) with that of the baseline.
template <typename Run>
void expect_same(const Run& run) {
  const Eigen::ArrayXd expected = run(InstructionSet::kBaseline);
  EXPECT_GT(expected.matrix().norm(), 0);
  for (const InstructionSet set : vector_sets())
    EXPECT_LE((run(set) - expected).matrix().norm(), kRounding * expected.matrix().norm()) << int(set);
}

}  // namespace

TEST(OperatorKernels, PolarGivesTheSameOnEveryInstructionSet) {
  const ZernikeRows rows = zernike_rows(zernike_modes(0, 20));
  const Eigen::ArrayXd packed = normals(Eigen::Index(2 * rows.rows()), "packed");
  RingBlock rings;
  for (int i = 0; i < kBlockRings; ++i) rings.x[i] = 0.05 * i, rings.y[i] = 0.6 - 0.04 * i;
  const Eigen::Index values = 21 * Eigen::Index(sizeof(RingOrder) / sizeof(double));
  expect_same([&](InstructionSet set) {
    std::vector<RingOrder> orders(21);
    polar_forward(set, rows, packed.data(), 3.0, rings, orders.data());
    return Eigen::ArrayXd(Eigen::Map<const Eigen::ArrayXd>(orders.front().height_re, values));
  });
  expect_same([&](InstructionSet set) {
    std::vector<RingOrder> orders(21);
    Eigen::Map<Eigen::ArrayXd>(orders.front().height_re, values) = normals(values, "orders");
    std::vector<CacheLine> lanes;
    Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(packed.size());
    polar_adjoint(set, rows, 3.0, rings, orders.data(), &lanes, sums.data());
    return sums;
  });
}

TEST(OperatorKernels, LatticeGivesTheSameOnEveryInstructionSet) {
  constexpr int kSide = 40, kPoints = 30;
  LatticeTable table{};
  Eigen::Map<Eigen::ArrayXd>(table.x[0], sizeof table.x / 8) = normals(sizeof table.x / 8, "along x");
  Eigen::Map<Eigen::ArrayXd>(table.y[0], sizeof table.y / 8) = normals(sizeof table.y / 8, "along y");
  std::vector<LatticePlace> place;
  for (int p = 0; p < kPoints; ++p) place.push_back({0.06 * p - 0.9, 0.8 - 0.05 * p, 41 * (p % 28) + p % 3});
  const Eigen::ArrayXd values = normals(4 * kPoints, "values");
  constexpr Eigen::Index kCells = 2 * kSide * kSide;
  expect_same([&](InstructionSet set) {
    Eigen::ArrayXd grids = Eigen::ArrayXd::Zero(2 * kCells);
    double* const grid[2] = {grids.data(), grids.data() + kCells};
    lattice_spread(set, table, kPoints, place.data(), 2, values.data(), kSide, grid);
    return grids;
  });
  expect_same([&](InstructionSet set) {
    const Eigen::ArrayXd grids = normals(2 * kCells, "cells");
    const double* const grid[2] = {grids.data(), grids.data() + kCells};
    Eigen::ArrayXd sums(4 * kPoints);
    lattice_gather(set, table, kPoints, place.data(), 2, grid, kSide, sums.data());
    return sums;
  });
}
