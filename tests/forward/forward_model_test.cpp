// Statistics from coefficients and back, for a mirror with known Zernikes.
#include "aberfit/forward/forward_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "aberfit/terms/modal_covariance.h"

namespace aberfit {
namespace {

constexpr double kFocal = 2.8, kDiameter = 0.4, kWavelength = 632.8e-9;
const Aperture kCircle = CircleAperture{kDiameter};

TermSet zernikes(int n_max) {
  TermSet terms;
  terms.radius = kDiameter / 2;
  terms.zernike = zernike_modes(2, n_max);
  return terms;
}

Eigen::VectorXd draw(const TermSet& terms, double rms, std::uint64_t seed) {
  const CoefficientPrior prior =
      make_prior(terms, RadialPsd(UniformPsd{rms, 2.5, 13}), CovarianceKind::kFull);
  return prior.colour(draw_white(prior.size(), seed));
}

PupilSample pupil_of(FocusModel model) {
  if (model == FocusModel::kWaves) return diffraction_pupil(kCircle, kFocal, kDiameter / 128).sample;
  return make_pupil(kCircle, {PupilLayout::kPolar, 8192, 1});
}

const std::vector<Statistic> kLight{EncircledEnergyRadius{0.3, 0}, EncircledEnergyRadius{0.8, 0},
                                    EncircledEnergyRadius{0.5, 3e-4}, RingThrough{6e-5, -4e-4}};

// The focus depends only on the whole surface, not on which part of it is declared as known.
TEST(ForwardModel, LightSeesKnownZernikesAsItSeesTheSameTerms) {
  const TermSet terms = zernikes(10);
  const Eigen::VectorXd rough = draw(terms, 60e-9, 3), shape = draw(terms, 90e-9, 4);
  Mirror plain{2.8, -1, {}}, known = plain;
  known.zernike_radius = terms.radius;
  for (std::size_t j = 0; j < terms.zernike.size(); ++j)
    known.zernike.push_back({terms.zernike[j], shape[Eigen::Index(j)]});
  for (const FocusModel model : {FocusModel::kRays, FocusModel::kWaves}) {
    const PupilSample pupil = pupil_of(model);
    const SurfaceOperator surface(terms, pupil, focus_operator(model, 1));
    const auto seen = [&](const Mirror& mirror, const Eigen::VectorXd& coefficients,
                          const std::vector<Statistic>& statistics) {
      return focus_statistics({mirror, pupil, surface, model, kWavelength, &kCircle, Centre::kNominal},
                              coefficients, statistics, 1, nullptr);
    };
    const Eigen::VectorXd found = seen(known, rough, kLight), expected = seen(plain, rough + shape, kLight);
    EXPECT_LT((found.array() / expected.array() - 1).abs().maxCoeff(), 1e-9) << to_string(model);
    EXPECT_GT((found.array() / seen(plain, rough, kLight).array() - 1).abs().maxCoeff(), 0.05);
    // Height and scatter are those of the roughness, because the nominal ray is that of the mirror without
    // it.
    const std::vector<Statistic> of_roughness{RmsHeight{}, ScatterRms{}, ScatterMean{}};
    const Eigen::VectorXd with = seen(known, rough, of_roughness), without = seen(plain, rough, of_roughness);
    EXPECT_LT((with.array() / without.array() - 1).abs().maxCoeff(), 1e-5) << to_string(model);
  }
}

// A known defocus of 1.3 waves has its best image in the focus of another parabola, 1/(4f') = 1/(4f) + 2
// sqrt(3) a/R^2, moved by -sqrt(3) a. The spot is that of the perfect mirror only there.
TEST(ForwardModel, WavesFocusAMirrorWithKnownDefocusWhereTheOtherParabolaDoes) {
  constexpr double kHeight = 120e-9, kRadius = kDiameter / 2;
  const Mirror plain{2.8, -1, {}};
  Mirror defocused = plain;
  defocused.zernike = {{{2, 0}, kHeight}};
  defocused.zernike_radius = kRadius;
  const double focal = 1 / (4 * (1 / (4 * 2.8) + 2 * std::sqrt(3.0) * kHeight / (kRadius * kRadius)));
  const double shift = focal - std::sqrt(3.0) * kHeight - 2.8;
  const TermSet terms = zernikes(2);
  const PupilSample pupil = pupil_of(FocusModel::kWaves);
  const SurfaceOperator surface(terms, pupil, focus_operator(FocusModel::kWaves, 1));
  const auto radii = [&](const Mirror& mirror, double dz) {
    return focus_statistics(
        {mirror, pupil, surface, FocusModel::kWaves, kWavelength, &kCircle, Centre::kNominal},
        Eigen::VectorXd::Zero(terms.size()), {EncircledEnergyRadius{0.5, dz}, EncircledEnergyRadius{0.8, dz}},
        1, nullptr);
  };
  const Eigen::VectorXd perfect = radii(plain, 0), found = radii(defocused, shift);
  // The scale of the image changes by f' - f, 1e-4; the rest is the paraxial defocus of f/7, t^2/2 of 1e-4.
  EXPECT_LT((found.array() / perfect.array() - 1).abs().maxCoeff(), 5e-4);
  EXPECT_GT(radii(defocused, 0)[0] / perfect[0], 1.5);
  EXPECT_GT(radii(defocused, -shift)[0] / perfect[0], 2);
}

TEST(ForwardModel, GradientsAreThoseOfTheValuesWithKnownZernikesToo) {
  const TermSet terms = zernikes(6);
  const Eigen::VectorXd at = draw(terms, 60e-9, 5);
  Mirror mirror{2.8, -0.999, {}};
  mirror.zernike_radius = 0.22;
  mirror.zernike = {{{2, 2}, 80e-9}, {{3, -1}, -50e-9}, {{2, 0}, 60e-9}};
  std::vector<Statistic> statistics = kLight;
  for (const Statistic& moment : {Statistic(RmsHeight{}), Statistic(ScatterRms{}), Statistic(ScatterMean{})})
    statistics.push_back(moment);
  for (const FocusModel model : {FocusModel::kRays, FocusModel::kWaves}) {
    const PupilSample pupil = pupil_of(model);
    const SurfaceOperator surface(terms, pupil, focus_operator(model, 1));
    const LightPath path{mirror, pupil, surface, model, kWavelength, &kCircle, Centre::kNominal};
    const auto forward = make_forward_model(path, statistics, 2);
    constexpr double kWidth = 2e-5;
    Eigen::VectorXd values, above, below;
    forward->move_to(at);
    ASSERT_TRUE(forward->evaluate(kWidth, &values));
    Eigen::MatrixXd found(at.size(), Eigen::Index(statistics.size()));
    ASSERT_TRUE(forward->gradients(
        [&](std::size_t k, const Eigen::VectorXd& gradient) { found.col(Eigen::Index(k)) = gradient; }));
    const double step = 1e-4 * at.cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < at.size(); j += 3) {
      Eigen::VectorXd moved = at;
      moved[j] += step;
      forward->move_to(moved);
      ASSERT_TRUE(forward->evaluate(kWidth, &above));
      moved[j] -= 2 * step;
      forward->move_to(moved);
      ASSERT_TRUE(forward->evaluate(kWidth, &below));
      const Eigen::VectorXd difference = (above - below) / (2 * step);
      for (Eigen::Index k = 0; k < difference.size(); ++k)
        EXPECT_NEAR(found(j, k), difference[k], 2e-5 * found.col(k).cwiseAbs().maxCoeff())
            << to_string(model) << ' ' << statistic_name(statistics[std::size_t(k)]) << ' ' << j;
    }
  }
}

}  // namespace
}  // namespace aberfit
