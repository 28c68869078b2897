// Compares L^T of heights alone for many weights with single calls of L^T.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "../../src/terms/fourier_kernel.h"
#include "../../src/terms/height_kernel.h"
#include "../../src/terms/zernike_kernel.h"
#include "aberfit/waves/diffraction_psf.h"
#include "operator_cases.h"

using namespace aberfit;
using namespace aberfit::internal;
using namespace operator_cases;

namespace {

constexpr double kRounding = 1e-12;  // relative to the norm; largest error 3e-14

TermSet all_kinds() {
  TermSet terms;
  terms.radius = kRadius;
  terms.zernike = zernike_modes(0, 17);
  terms.zernike.erase(terms.zernike.begin() + 20);  // a gap
  for (int k = 0; k < 31; ++k) terms.fourier.push_back({3.0 + 1.7 * k, 20.0 * std::sin(2.0 * k)});
  terms.spherical = {4, 6};
  return terms;
}

std::vector<Eigen::ArrayXd> weights_of(Eigen::Index points, int count) {
  std::vector<Eigen::ArrayXd> weights;
  for (int k = 0; k < count; ++k)
    weights.push_back(normals(points, ("weights " + std::to_string(k)).c_str()));
  return weights;
}

void expect_one_by_one(const PupilSample& pupil, const OperatorOptions& options, int count) {
  const SurfaceOperator surface(all_kinds(), pupil, options);
  const std::vector<Eigen::ArrayXd> weights = weights_of(pupil.size(), count);
  const Eigen::MatrixXd together = surface.apply_transpose_heights(weights);
  ASSERT_EQ(together.rows(), surface.terms().size());
  ASSERT_EQ(together.cols(), count);
  for (int k = 0; k < count; ++k) {
    const Eigen::ArrayXd none = Eigen::ArrayXd::Zero(pupil.size());
    const Eigen::VectorXd alone = surface.apply_transpose(SurfaceField{weights[std::size_t(k)], none, none});
    EXPECT_LE((together.col(k) - alone).norm(), kRounding * alone.norm()) << k;
  }
}

}  // namespace

TEST(HeightProducts, AreThoseOfOneWeightAfterTheOtherOnAnyPoints) {
  expect_one_by_one(rings(19, 40), {}, 3);
  expect_one_by_one(scrambled_grid(31, 24), {}, 70);
  PupilSample scattered = scrambled_grid(20, 20);
  scattered.structure = std::monostate{};
  expect_one_by_one(scattered, {}, 8);
}

TEST(HeightProducts, TakeWhatIsThereOfMirroredPoints) {
  // Odd and even grids; a triangle that lacks many mirror images of its points; cells beyond the rim.
  const Aperture circle = CircleAperture{2 * kRadius},
                 triangle = PolygonAperture{{{-0.1, -0.15}, {0.18, 0}, {0, 0.1}}};
  for (const Aperture& aperture : {circle, triangle})
    for (const double cells : {40.0, 41.0})
      for (const double focal_length : {0.5, kParaxial})
        expect_one_by_one(diffraction_pupil(aperture, focal_length, 2 * kRadius / cells).sample,
                          {2, {}, {}, true}, 33);
  expect_one_by_one(diffraction_pupil(circle, 0.5, 0.01, {0.3, -0.5}).sample, {2, {}, {}, true}, 5);
}

TEST(HeightProducts, ThreadCountChangesNoBit) {
  const PupilSample pupil = diffraction_pupil(CircleAperture{2 * kRadius}, 0.5, 2 * kRadius / 170).sample;
  const std::vector<Eigen::ArrayXd> weights = weights_of(pupil.size(), 11);
  const SurfaceOperator one(all_kinds(), pupil, {1, {}, {}}), three(all_kinds(), pupil, {3, {}, {}});
  EXPECT_EQ(one.apply_transpose_heights(weights), three.apply_transpose_heights(weights));
}

TEST(HeightProducts, EveryInstructionSetGivesTheSame) {
  const ZernikeRows rows = zernike_rows(zernike_modes(0, 15));
  const FourierRows fourier = fourier_rows({{3, 4}, {-5, 1}, {0.5, 8}});
  const int columns = 48;
  const Eigen::ArrayXd weights = normals(4 * kBlockOrbits * columns, "weights"),
                       x = 0.1 * normals(kBlockOrbits, "x"), y = 0.1 * normals(kBlockOrbits, "y");
  for (const bool folded : {false, true}) {
    const auto run = [&](InstructionSet set) {
      OrbitBlock block{kBlockOrbits, columns, x.data(), y.data(), {}};
      for (int c = 0; c < 4; ++c) block.weights[c] = weights.data() + c * kBlockOrbits * columns;
      std::vector<double> basis(kFourierBasis);
      const Eigen::Index size = Eigen::Index(2 * rows.rows() + 6) * columns;
      Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(size);
      zernike_heights(set, rows.m_max(), rows.first.data(), rows.recurrence.data(), folded, block,
                      basis.data(), sums.data());
      fourier_heights(set, 3, fourier.frequency.data(), folded, block, basis.data(),
                      sums.data() + 2 * Eigen::Index(rows.rows()) * columns);
      return sums;
    };
    const Eigen::ArrayXd expected = run(InstructionSet::kBaseline);
    for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512})
      if (is_supported(set)) {
        EXPECT_LE((run(set) - expected).matrix().norm(), 1e-13 * expected.matrix().norm()) << int(set);
      }
  }
}
