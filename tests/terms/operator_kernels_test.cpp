// The kernels behind the methods, one instruction set against another: whole operators use the best one only.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "../../src/terms/dense_kernel.h"
#include "../../src/terms/grid_kernel.h"
#include "../../src/terms/polar_kernel.h"
#include "operator_cases.h"

using namespace aberfit;
using namespace aberfit::internal;
using namespace operator_cases;

namespace {

constexpr double kRounding = 1e-13;  // of the norm; the sets differ in fused multiply-adds and order of sums

std::vector<InstructionSet> vector_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512})
    if (is_supported(set)) sets.push_back(set);
  return sets;
}

/// Compares what run(set) returns with what it returns for the baseline.
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

TEST(OperatorKernels, GridGivesTheSameOnEveryInstructionSet) {
  const FourierRows rows = fourier_rows(plane_waves(77));
  const Eigen::ArrayXd amplitudes = normals(154, "amplitudes");
  constexpr Eigen::Index kPlaces = kTileRows * kTileColumns;
  const auto tile_of = [](const Eigen::ArrayXd& values) {
    auto tile = std::make_unique<GridTile>();
    tile->rows = 37, tile->columns = 41;
    for (int i = 0; i < kTileColumns; ++i) tile->x[i] = i < 41 ? 0.01 * i - 0.2 : 0.0;
    for (int j = 0; j < kTileRows; ++j) tile->y[j] = j < 37 ? 0.17 - 0.01 * j : 0.0;
    for (int g = 0; g < kTileRows / kRowGroup; ++g)
      tile->from[g] = g % 2 ? 16 : 0, tile->to[g] = g < 9 ? 48 : 32;
    Eigen::Map<Eigen::ArrayXd>(tile->height[0], kPlaces) = values;
    Eigen::Map<Eigen::ArrayXd>(tile->slope_x[0], kPlaces) = 0.01 * values.reverse();
    Eigen::Map<Eigen::ArrayXd>(tile->slope_y[0], kPlaces) = -0.02 * values;
    return tile;
  };
  expect_same([&](InstructionSet set) {
    const auto tile = tile_of(Eigen::ArrayXd::Zero(kPlaces));
    grid_forward(set, rows, amplitudes.data(), tile.get());
    Eigen::ArrayXd wanted(3 * 37 * 16);  // columns 16 to 31, in every group of rows
    for (int j = 0, at = 0; j < 37; ++j)
      for (int i = 16; i < 32; ++i, at += 3)
        wanted.segment(at, 3) << 100 * tile->height[j][i], tile->slope_x[j][i], tile->slope_y[j][i];
    return wanted;
  });
  expect_same([&](InstructionSet set) {
    const auto tile = tile_of(normals(kPlaces, "weights"));
    Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(154);
    grid_adjoint(set, rows, tile.get(), sums.data());
    return sums;
  });
}

TEST(OperatorKernels, DenseGivesTheSameOnEveryInstructionSet) {
  constexpr int kTerms = 23;
  std::vector<CacheLine> memory(cache_lines(kTerms * kDenseValues));
  double* basis = memory.front().lane;
  Eigen::Map<Eigen::ArrayXd>(basis, kTerms * kDenseValues) = normals(kTerms * kDenseValues, "basis");
  const Eigen::ArrayXd coefficients = normals(kTerms, "coefficients"),
                       weights = normals(kDenseValues, "weights");
  expect_same([&](InstructionSet set) {
    Eigen::ArrayXd field(kDenseValues);
    dense_forward(set, kTerms, basis, coefficients.data(), field.data());
    return field;
  });
  expect_same([&](InstructionSet set) {
    Eigen::ArrayXXd lanes = Eigen::ArrayXXd::Zero(8, kTerms);
    dense_adjoint(set, kTerms, basis, weights.data(), lanes.data());
    return Eigen::ArrayXd(lanes.colwise().sum().transpose());
  });
}
