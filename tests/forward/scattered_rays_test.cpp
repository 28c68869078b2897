// Rays of a surface whose roughness is partly an independent slope of each ray.
#include "aberfit/theory/scattered_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/theory/geometric_harvey_shack.h"

namespace aberfit {
namespace {

constexpr double kDiameter = 0.4, kWavelength = 632.8e-9, kCut = 20;
const Mirror kParabola{2.8, -1, {}};
const Aperture kCircle = CircleAperture{kDiameter};
const RadialPsd kPsd(KCorrelationPsd{60e-9, 0.1, 2.5, 2.5, 300});

std::shared_ptr<const BandSplit> split_at(double cut) {
  const auto whole = std::make_shared<const GeneralisedHarveyShack>(kPsd, kParabola, kCircle, kWavelength);
  return std::make_shared<const BandSplit>(kPsd, cut, kParabola, kCircle, kWavelength, whole);
}

GeometricHarveyShack theory_of(const RadialPsd& psd) {
  const PsdMoments moments = psd_moments(psd);
  return {kParabola, kCircle, moments.rms_slope_per_axis(), Convention::kPhysical, moments.rms_height()};
}

TermSet low_terms() {
  TermSet terms;
  terms.radius = kDiameter / 2;
  terms.zernike = zernike_modes(1, 30);  // 20 cycles/m are 8 across, so these terms cover them
  return terms;
}

const std::vector<Statistic> kLight{EncircledEnergyRadius{0.2, 0},
                                    EncircledEnergyRadius{0.5, 0},
                                    EncircledEnergyRadius{0.9, 0},
                                    EncircledEnergyRadius{0.6, 1.5e-3},
                                    EncircledEnergyRadius{0.6, -1e-3},
                                    RingThrough{5e-5, 1e-3},
                                    RingFwhm{0.9, {}}};

TEST(ScatteredRays, SlopesAreGaussianAndKnowNothingOfThePupil) {
  const auto split = split_at(kCut);
  const double slope = psd_moments(split->rest()).rms_slope_per_axis();
  for (const PupilLayout layout : {PupilLayout::kPolar, PupilLayout::kSobol, PupilLayout::kRandom}) {
    const PupilSample pupil = make_pupil(kCircle, {layout, 32768, 5});
    SurfaceField field;
    add_scatter(*split, pupil, 9, &field);
    ASSERT_EQ(field.size(), pupil.size());
    EXPECT_EQ(field.height.abs().maxCoeff(), 0);
    const double n = double(pupil.size());
    for (const Eigen::ArrayXd* s : {&field.slope_x, &field.slope_y}) {
      const Eigen::ArrayXd u = *s / slope;
      EXPECT_NEAR(u.mean(), 0, 1e-3);
      EXPECT_NEAR(u.square().mean(), 1, 3e-3);
      EXPECT_NEAR(u.pow(4).mean(), 3, 0.03);
      // Standard error of n independent pairs: 1/sqrt(n).
      for (const Eigen::ArrayXd* of : {&pupil.x, &pupil.y}) {
        const Eigen::ArrayXd where = *of / (0.25 * kDiameter);
        EXPECT_LT(std::abs((u * where).mean()), 4 / std::sqrt(n));
        EXPECT_LT(std::abs(((u.square() - 1) * (where.square() - 1)).mean()), 4 * std::sqrt(2 / n));
      }
    }
    EXPECT_LT(std::abs((field.slope_x * field.slope_y).mean()) / (slope * slope), 4 / std::sqrt(n));
    if (layout == PupilLayout::kPolar) continue;
    // Another seed gives independent slopes, which add to the present ones.
    SurfaceField more = field;
    add_scatter(*split, pupil, 10, &more);
    EXPECT_NEAR((more.slope_x.square().mean()) / (2 * slope * slope), 1, 0.02);
  }
}

// A mirror with nothing but its scatter follows Harvey-Shack.
TEST(ScatteredRays, OfAPerfectMirrorAreTheTheory) {
  const auto split = split_at(kCut);
  const GeometricHarveyShack theory = theory_of(split->rest());
  const LitMirror lit{kParabola, kCircle, kWavelength, Centre::kNominal, split};
  const TermSet terms = low_terms();
  std::vector<Statistic> statistics = kLight;
  for (const Statistic& moment : {Statistic(RmsHeight{}), Statistic(ScatterRms{}), Statistic(ScatterMean{})})
    statistics.push_back(moment);
  const FreshStatistics fresh =
      statistics_with_error(lit, {FocusModel::kRays, 1 << 19, 3}, terms, Eigen::VectorXd::Zero(terms.size()),
                            statistics, 2, nullptr);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const double expected = theory(statistics[k]), error = fresh.standard_error[Eigen::Index(k)];
    // Student's t with 7 degrees of freedom exceeds 5.4 once in a thousand.
    EXPECT_NEAR(fresh.value[Eigen::Index(k)], expected, 5.4 * error + 1e-9 * expected)
        << statistic_name(statistics[k]);
    EXPECT_LT(error, 5e-3 * expected) << statistic_name(statistics[k]);
  }
}

// Terms of the low part and slopes of the rest, on average over mirrors, follow Harvey-Shack of the whole for
// any cut. Without the slopes they do not.
TEST(ScatteredRays, WithTermsBelowTheCutAreTheTheoryOfTheWhole) {
  const GeometricHarveyShack theory = theory_of(kPsd);
  const TermSet terms = low_terms();
  constexpr int kDraws = 150;
  std::vector<Statistic> shares;
  for (const double dz : {0.0, 1.5e-3, -1e-3})
    for (const double fraction : {0.2, 0.5, 0.8})
      shares.push_back(RingThrough{theory.encircled_energy_radius(fraction, dz), dz});
  for (const double cut : {12.0, 20.0}) {
    const auto split = split_at(cut);
    const LitMirror lit{kParabola, kCircle, kWavelength, Centre::kNominal, split};
    const CoefficientPrior prior = make_prior(terms, split->low(), CovarianceKind::kFull);
    Eigen::ArrayXXd seen(Eigen::Index(shares.size()), kDraws);
    for (int d = 0; d < kDraws; ++d)
      seen.col(d) = statistics_with_error(lit, {FocusModel::kRays, 4096, std::uint64_t(d)}, terms,
                                          prior.colour(draw_white(prior.size(), 100 + std::uint64_t(d))),
                                          shares, 2, nullptr)
                        .value.array();
    for (std::size_t k = 0; k < shares.size(); ++k) {
      const Eigen::ArrayXd of = seen.row(Eigen::Index(k));
      const double error = std::sqrt((of - of.mean()).square().sum() / (kDraws * (kDraws - 1.0)));
      EXPECT_NEAR(of.mean(), theory(shares[k]), 4 * error) << statistic_name(shares[k]) << ", cut " << cut;
      EXPECT_LT(error, 0.01);
    }
  }
}

TEST(ScatteredRays, GradientsAreThoseOfTheValues) {
  TermSet terms;
  terms.radius = kDiameter / 2;
  terms.zernike = zernike_modes(2, 6);
  const auto split = split_at(kCut);
  const CoefficientPrior prior = make_prior(terms, split->low(), CovarianceKind::kFull);
  const Eigen::VectorXd at = prior.colour(draw_white(prior.size(), 5));
  std::vector<Statistic> statistics = kLight;
  statistics.push_back(RmsHeight{});
  statistics.push_back(ScatterRms{});
  const PupilSample pupil = make_pupil(kCircle, {PupilLayout::kPolar, 8192, 1});
  const SurfaceOperator surface(terms, pupil, focus_operator(FocusModel::kRays, 1));
  LightPath path{kParabola, pupil, surface};
  path.scatter = split;
  const auto forward = make_forward_model(path, statistics, 2);
  constexpr double kWidth = 2e-5, kStep = 1e-11;
  Eigen::VectorXd values, above, below;
  forward->move_to(at);
  ASSERT_TRUE(forward->evaluate(kWidth, &values));
  EXPECT_NEAR(values[Eigen::Index(kLight.size())], std::hypot(at.norm(), split->rms_height()), 1e-3 * 60e-9);
  Eigen::MatrixXd found(at.size(), Eigen::Index(statistics.size()));
  ASSERT_TRUE(forward->gradients(
      [&](std::size_t k, const Eigen::VectorXd& gradient) { found.col(Eigen::Index(k)) = gradient; }));
  Eigen::MatrixXd expected = found;
  for (Eigen::Index j = 0; j < at.size(); ++j) {
    Eigen::VectorXd moved = at;
    moved[j] += kStep;
    forward->move_to(moved);
    ASSERT_TRUE(forward->evaluate(kWidth, &above));
    moved[j] -= 2 * kStep;
    forward->move_to(moved);
    ASSERT_TRUE(forward->evaluate(kWidth, &below));
    expected.row(j) = (above - below).transpose() / (2 * kStep);
  }
  for (Eigen::Index k = 0; k < found.cols(); ++k)
    EXPECT_LT((found.col(k) - expected.col(k)).norm(), 1e-4 * expected.col(k).norm())
        << statistic_name(statistics[std::size_t(k)]);
}

}  // namespace
}  // namespace aberfit
