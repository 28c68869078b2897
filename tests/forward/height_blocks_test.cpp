// Derivatives over terms by sums over blocks of grid cells, against cell by cell.
#include "../../src/forward/height_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "aberfit/forward/forward_model.h"
#include "aberfit/forward/height_block_side.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {
namespace {

constexpr double kFocal = 1.2, kDiameter = 0.4;
const OperatorOptions kHow = focus_operator(FocusModel::kWaves, 2);

TermSet zernikes(int n_max) {
  TermSet terms;
  terms.radius = kDiameter / 2;
  terms.zernike = zernike_modes(2, n_max);
  return terms;
}

TEST(HeightBlocks, AreAsManyACycleAsPromised) {
  const TermSet terms = zernikes(19);  // 20 rad of 2 pi rho/R: 6.4 cycles across
  const double cycle = kDiameter * 3.14159265358979 / 20;
  EXPECT_EQ(height_block_side(terms, cycle / (3.01 * kBlocksACycle), kFewestBlockedCells), 3);
  EXPECT_EQ(height_block_side(terms, cycle / (2.99 * kBlocksACycle), kFewestBlockedCells), 2);
  EXPECT_EQ(height_block_side(terms, cycle / (1.5 * kBlocksACycle), kFewestBlockedCells), 1);
  EXPECT_EQ(height_block_side(terms, cycle / (3.01 * kBlocksACycle), kFewestBlockedCells - 1), 1);
}

// The weights vary over the pupil faster than the terms, as in a fit by waves. The error is pi^2/(6 b^2) of
// the largest derivative for b blocks per cycle. Zernikes, which are no plane waves, have up to 1.18 times
// that (seen); with blocks up to the rim, nine times.
TEST(HeightBlocks, ComeNearTheProductsOfCells) {
  constexpr double kZernikes = 1.3;
  const TermSet terms = zernikes(16);
  const Aperture apertures[] = {CircleAperture{kDiameter}, AnnulusAperture{kDiameter, 0.15},
                                RectangleAperture{0.3, 0.2},
                                PolygonAperture{{{0.05, -0.1}, {0.15, 0.02}, {0.02, 0.12}, {-0.1, 0}}}};
  for (const Aperture& aperture : apertures)
    for (const int cells : {300, 301}) {
      const PupilSample pupil = diffraction_pupil(aperture, kFocal, kDiameter / cells).sample;
      const double blocks = cells / (5 * kDiameter * zernike_cutoff(16, terms.radius));
      std::vector<Eigen::ArrayXd> weights;
      for (const double wave : {20.0, 90.0})
        weights.push_back(pupil.weight * (1 + (wave * pupil.x + 1).sin() * (0.6 * wave * pupil.y).cos()));
      const Eigen::MatrixXd exact = SurfaceOperator(terms, pupil, kHow).apply_transpose_heights(weights);
      const HeightBlocks in_blocks(terms, pupil, 5, kHow);
      const std::vector<Eigen::ArrayXd> sums = {in_blocks.sums(weights[0]), in_blocks.sums(weights[1])};
      EXPECT_LT(sums[0].size(), pupil.size() / 3);  // most of them at the rim
      EXPECT_NEAR(sums[0].sum(), weights[0].sum(), 1e-12);
      const Eigen::MatrixXd got = in_blocks.products(sums);
      EXPECT_LT((got - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff(),
                kZernikes * 3.1416 * 3.1416 / (6 * blocks * blocks))
          << aperture.index() << ' ' << cells;
    }
}

// Every cell is in a block, and a block of one cell is the cell.
TEST(HeightBlocks, OfOneCellAreExact) {
  const TermSet terms = zernikes(9);
  const PupilSample pupil = diffraction_pupil(CircleAperture{kDiameter}, kFocal, kDiameter / 41).sample;
  const std::vector<Eigen::ArrayXd> weights = {pupil.weight * (30 * pupil.x + 20 * pupil.y).sin()};
  const HeightBlocks cells(terms, pupil, 1, kHow);
  const std::vector<Eigen::ArrayXd> sums = {cells.sums(weights[0])};
  const Eigen::MatrixXd exact = SurfaceOperator(terms, pupil, kHow).apply_transpose_heights(weights);
  EXPECT_LT((cells.products(sums) - exact).cwiseAbs().maxCoeff(), 1e-13 * exact.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace aberfit::internal
