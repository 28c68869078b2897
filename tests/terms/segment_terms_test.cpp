// Compares heights, slopes and adjoints of pistons and tilts, mixed with other terms, with their definition.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <vector>

#include "aberfit/scene/segments.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

SegmentedAperture erring(double piston, double tip_tilt) {
  SegmentedAperture result = hexagonal_segments(1, 0.2, 0.01, false, 0);
  result.piston = piston;
  result.tip_tilt = tip_tilt;
  return result;
}

TermSet terms_of(const SegmentedAperture& aperture) {
  TermSet terms;
  terms.radius = aperture_radius(aperture);
  terms.zernike = zernike_modes(2, 4);
  terms.fourier = {{3, 1}};
  terms.spherical = {4};
  terms.segments = std::make_shared<const Segments>(aperture);
  return terms;
}

// Height and slopes of the segment terms alone, by definition.
std::array<double, 3> by_definition(const TermSet& terms, const Eigen::VectorXd& c, std::size_t number,
                                    double x, double y) {
  const Segments::Segment& segment = terms.segments->all()[number];
  const double* own = c.data() + terms.segments_begin() + Eigen::Index(number) * terms.of_a_segment();
  const double piston = terms.segments->piston() > 0 ? *own++ : 0;
  if (!(terms.segments->tip_tilt() > 0)) return {piston, 0, 0};
  const double p = own[0] / segment.radius, q = own[1] / segment.radius;
  return {piston + p * (x - segment.centre[0]) + q * (y - segment.centre[1]), p, q};
}

TEST(SegmentTerms, AreTheirDefinitionOnCellsAndAnywhere) {
  for (const auto& [piston, tip_tilt] : {std::pair{1e-8, 0.0}, {0.0, 1e-8}, {1e-8, 1e-8}}) {
    const SegmentedAperture aperture = erring(piston, tip_tilt);
    const TermSet terms = terms_of(aperture), others = terms.without_segments();
    const Eigen::VectorXd c = Eigen::VectorXd::Random(terms.size());
    const PupilSample cells = diffraction_pupil(aperture, 3, 0.02).sample;
    ASSERT_EQ(cells.segment.size(), std::size_t(cells.size()));
    SurfaceField all, smooth;
    SurfaceOperator(terms, cells, {}).apply(c, &all);
    SurfaceOperator(others, cells, {}).apply(c.head(others.size()), &smooth);
    for (Eigen::Index k = 0; k < cells.size(); ++k) {
      const auto [h, p, q] = by_definition(terms, c, cells.segment[std::size_t(k)], cells.x[k], cells.y[k]);
      EXPECT_NEAR(all.height[k] - smooth.height[k], h, 1e-12);
      EXPECT_NEAR(all.slope_x[k] - smooth.slope_x[k], p, 1e-11);
      EXPECT_NEAR(all.slope_y[k] - smooth.slope_y[k], q, 1e-11);
    }
    const double x = 0.21, y = 0.05;  // in the first segment to the right
    SurfaceOperator(terms, Eigen::ArrayXd::Constant(1, x), Eigen::ArrayXd::Constant(1, y)).apply(c, &all);
    SurfaceOperator(others, Eigen::ArrayXd::Constant(1, x), Eigen::ArrayXd::Constant(1, y))
        .apply(c.head(others.size()), &smooth);
    EXPECT_NEAR(all.height[0] - smooth.height[0], by_definition(terms, c, terms.segments->at(x, y), x, y)[0],
                1e-12);
  }
}

TEST(SegmentTerms, HaveTheirAdjoints) {
  const SegmentedAperture aperture = erring(1e-8, 1e-8);
  const TermSet terms = terms_of(aperture);
  const PupilSample cells = diffraction_pupil(aperture, 3, 0.02).sample;
  const SurfaceOperator surface(terms, cells, {});
  const Eigen::VectorXd c = Eigen::VectorXd::Random(terms.size());
  SurfaceField field, weights;
  surface.apply(c, &field);
  weights.height = Eigen::ArrayXd::Random(cells.size());
  weights.slope_x = Eigen::ArrayXd::Random(cells.size());
  weights.slope_y = Eigen::ArrayXd::Random(cells.size());
  const double sum =
      (weights.height * field.height + weights.slope_x * field.slope_x + weights.slope_y * field.slope_y)
          .sum();
  EXPECT_NEAR(surface.apply_transpose(weights).dot(c), sum, 1e-9 * std::abs(sum) + 1e-10);

  const std::vector<Eigen::ArrayXd> of_heights{weights.height, Eigen::ArrayXd::Random(cells.size())};
  const Eigen::MatrixXd products = surface.apply_transpose_heights(of_heights);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(products.col(Eigen::Index(k)).dot(c), (of_heights[k] * field.height).sum(), 1e-9);

  const std::vector<std::uint32_t> rays{1, 5, 17};
  SurfaceField few;
  few.height = few.slope_x = few.slope_y = Eigen::ArrayXd::Ones(3);
  double of_rays = 0;
  for (const std::uint32_t k : rays) of_rays += field.height[k] + field.slope_x[k] + field.slope_y[k];
  EXPECT_NEAR(surface.apply_transpose(rays, few).dot(c), of_rays, 1e-9);
}

// Many realisations have the requested standard deviations; slopes are multiplied by the radius.
TEST(SegmentTerms, AreDrawnWithTheirDeviations) {
  TermSet terms;
  terms.segments = std::make_shared<const Segments>(erring(3e-8, 2e-7));
  const CoefficientPrior prior(terms.size(), segment_prior_blocks(terms));
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  constexpr int kDraws = 2000;
  for (int d = 0; d < kDraws; ++d) {
    const Eigen::VectorXd c = prior.colour(draw_white(terms.size(), std::uint64_t(d)));
    for (Eigen::Index k = 0; k < c.size(); ++k) squares[k % 3] += c[k] * c[k];
  }
  const Eigen::Array3d rms = (squares / (kDraws * 6.0)).sqrt();
  const double radius = terms.segments->all()[0].radius;
  EXPECT_NEAR(rms[0], 3e-8, 0.03 * 3e-8);
  EXPECT_NEAR(rms[1], 2e-7 * radius, 0.03 * 2e-7 * radius);
  EXPECT_NEAR(rms[2], 2e-7 * radius, 0.03 * 2e-7 * radius);
}

}  // namespace
}  // namespace aberfit
