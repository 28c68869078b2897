// A band of wavelengths: theory and surfaces against the weighted sums of the results of each wavelength.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "aberfit/scene/light.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

const Light kBand(std::vector<LightLine>{{500e-9, 1}, {560e-9, 3}, {630e-9, 2}});
const Mirror kMirror{2.0, -1, {}};
const Aperture kCircle = CircleAperture{0.4}, kSquare = RectangleAperture{0.3, 0.3};
const PsdModel kPsd = UniformPsd{25e-9, 3, 40};

TEST(Light, IsItsLinesByTheirShares) {
  EXPECT_NEAR(kBand, (500e-9 + 3 * 560e-9 + 2 * 630e-9) / 6, 1e-20);
  EXPECT_EQ(kBand.shortest(), 500e-9);
  EXPECT_EQ(kBand.longest(), 630e-9);
  const Light filter = band_of_light(500e-9, 600e-9, 5);
  EXPECT_NEAR(filter.lines()[0].wavelength, 510e-9, 1e-20);
  EXPECT_NEAR(filter, 550e-9, 1e-20);
  EXPECT_FALSE(Light(500e-9).is_band());
  EXPECT_THROW(Light(std::vector<LightLine>{}), std::invalid_argument);
  EXPECT_THROW(Light(std::vector<LightLine>{{500e-9, -1}}), std::invalid_argument);
}

// In every plane the mean spot of a band is the weighted sum of those of its wavelengths.
TEST(BandOfLight, MeanLightIsTheWeightedSumOfItsLines) {
  for (const Aperture& aperture : {kCircle, kSquare}) {
    const GeneralisedHarveyShack band(RadialPsd(kPsd), kMirror, aperture, kBand);
    std::vector<GeneralisedHarveyShack> lines;
    for (const LightLine& line : kBand.lines())
      lines.emplace_back(RadialPsd(kPsd), kMirror, aperture, line.wavelength);
    const auto sum = [&](const auto& of) {
      double all = 0;
      for (std::size_t k = 0; k < lines.size(); ++k) all += kBand.lines()[k].share * of(lines[k]);
      return all;
    };
    EXPECT_NEAR(band.core_share(), sum([](const auto& one) { return one.core_share(); }), 1e-14);
    for (const double dz : {0.0, 60e-6})
      for (const double radius : {1e-6, 4e-6, 20e-6, 60e-6}) {
        const double inside = sum([&](const auto& one) { return one.encircled_energy(radius, dz); });
        EXPECT_NEAR(band.encircled_energy(radius, dz), inside, 1e-9) << dz << ' ' << radius;
        EXPECT_NEAR(band.encircled_energy_radius(inside, dz) / radius, 1, 1e-7);
        EXPECT_NEAR(band.at_plane(dz).irradiance(radius) /
                        sum([&](const auto& one) { return one.at_plane(dz).irradiance(radius); }),
                    1, 1e-6);
      }
  }
}

// Derivatives over ln p of a band, by differences.
TEST(BandOfLight, DerivativesOverThePsdAreThoseOfTheSum) {
  const GhsPupil pupil(kMirror, kCircle, kBand);
  const std::vector<Statistic> statistics{EncircledEnergyRadius{0.8, 0}, EncircledEnergyRadius{0.9, 50e-6}};
  const auto values = [&](double rms) {
    return GeneralisedHarveyShack(RadialPsd(UniformPsd{rms, 3, 40}), pupil).predict(statistics);
  };
  const Eigen::MatrixXd jacobian =
      psd_jacobian(kPsd, {PsdVariable{"rms", {}, 0}}, statistics, pupil).logarithmic();
  constexpr double kStep = 3e-5;
  const Eigen::VectorXd change = (values(25e-9 * (1 + kStep)) - values(25e-9 * (1 - kStep))) / (2 * kStep),
                        now = values(25e-9);
  for (Eigen::Index k = 0; k < change.size(); ++k) EXPECT_NEAR(jacobian(k, 0) * now[k] / change[k], 1, 1e-6);
}

struct Surface {
  DiffractionPupil pupil = diffraction_pupil(kCircle, kMirror.focal_length, 0.4 / 96);
  Eigen::ArrayXd height;
  std::shared_ptr<const BandSplit> split;
  Surface() {
    const Eigen::ArrayXd x = pupil.sample.x / 0.2, y = pupil.sample.y / 0.2;
    height = 20e-9 * (x * x - y * y) + 15e-9 * (3 * x * y * y - x * x * x) + 12e-9 * (9 * x + 2 * y).sin();
    const RadialPsd psd(kPsd);
    split = std::make_shared<const BandSplit>(
        psd, 8.0, kMirror, kCircle, kBand,
        std::make_shared<const GeneralisedHarveyShack>(psd, kMirror, kCircle, kBand));
  }
  DiffractionProblem problem(const Light& light, std::shared_ptr<const MeanScatter> scatter) const {
    DiffractionProblem problem{pupil, kMirror.focal_length, light};
    problem.scatter = std::move(scatter);
    return problem;
  }
};

// With and without scatter; radii by the sum, gradients by differences along a direction.
TEST(BandOfLight, OfASurfaceIsTheWeightedSumOfItsLines) {
  const Surface surface;
  const std::vector<Statistic> sums{RingThrough{3e-6, 0}, RingThrough{15e-6, 40e-6},
                                    EnsquaredThrough{8e-6, 0}};
  for (const bool scatters : {false, true}) {
    const auto scatter_of = [&](std::optional<std::size_t> line) -> std::shared_ptr<const MeanScatter> {
      if (!scatters) return nullptr;
      return line ? surface.split->of_line(*line) : surface.split;
    };
    Eigen::VectorXd expected = Eigen::VectorXd::Zero(3), one, band;
    for (std::size_t k = 0; k < kBand.lines().size(); ++k) {
      const LightLine& line = kBand.lines()[k];
      ASSERT_TRUE(evaluate_diffraction(surface.problem(line.wavelength, scatter_of(k)), surface.height, sums,
                                       1, nullptr, &one, nullptr));
      expected += line.share * one;
    }
    const DiffractionProblem problem = surface.problem(kBand, scatter_of(std::nullopt));
    ASSERT_TRUE(evaluate_diffraction(problem, surface.height, sums, 1, nullptr, &band, nullptr));
    EXPECT_LT((band - expected).cwiseAbs().maxCoeff(), 1e-9) << scatters;

    std::vector<Statistic> all = sums;
    all.insert(all.end(), {EncircledEnergyRadius{0.6, 0}, EncircledEnergyRadius{0.8, 40e-6}});
    Eigen::VectorXd values, up, down;
    std::vector<Eigen::ArrayXd> gradient;
    ASSERT_TRUE(evaluate_diffraction(problem, surface.height, all, 2, nullptr, &values, &gradient));
    for (const std::size_t k : {3u, 4u}) {
      Eigen::VectorXd inside;
      const auto& circle = std::get<EncircledEnergyRadius>(all[k]);
      evaluate_diffraction(problem, surface.height, {RingThrough{values[Eigen::Index(k)], circle.dz}}, 1,
                           nullptr, &inside, nullptr);
      EXPECT_NEAR(inside[0], circle.fraction, 1e-9);
    }
    const Eigen::ArrayXd direction = (surface.pupil.sample.x * 31 + surface.pupil.sample.y * 17).cos();
    constexpr double kStep = 2e-12;
    evaluate_diffraction(problem, surface.height + kStep * direction, all, 1, nullptr, &up, nullptr);
    evaluate_diffraction(problem, surface.height - kStep * direction, all, 1, nullptr, &down, nullptr);
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const double slope = (gradient[std::size_t(k)] * direction).sum(),
                   change = (up[k] - down[k]) / (2 * kStep);
      EXPECT_NEAR(slope / change, 1, 1e-6 * (1 + 1e-3 / kStep * 1e-12 / std::abs(change))) << k << scatters;
    }
  }
}

TEST(BandOfLight, HasNoRings) {
  const Surface surface;
  Eigen::VectorXd values;
  EXPECT_FALSE(evaluate_diffraction(surface.problem(kBand, nullptr), surface.height,
                                    {RingFwhm{}, RingThrough{3e-6, 0}}, 1, nullptr, &values, nullptr));
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_GT(values[1], 0);
}

}  // namespace
}  // namespace aberfit
