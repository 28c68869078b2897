#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "aberfit/waves/diffraction_psf.h"

// Tests roughness that is not part of the heights, as a factor on the transfer function.

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal = 2.8, kDiameter = 0.4, kWave = 632.8e-9;

// A Gaussian correlation of RMS phase `g`; its mean spot is only some smooth curve.
class Gaussian : public MeanScatter {
 public:
  Gaussian(double g, double length) : g2_(g * g), length_(length) {}
  Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const override {
    return (-g2_ * (1 - (-(shear / length_).square()).exp())).exp();
  }
  Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const override {
    return transfer(shear) * (-(shear / kDiameter).square()).exp();
  }
  double encircled_energy(double radius) const override { return 1 - std::exp(-radius / kScale); }
  double encircled_energy_slope(double radius) const override { return std::exp(-radius / kScale) / kScale; }
  double irradiance() const override { return 3e8; }
  double image_transfer(double frequency) const override { return std::exp(-frequency / kFrequency); }
  double rms_height() const override { return std::sqrt(g2_) * kWave / (4 * kPi); }
  double rms_slope_per_axis() const override { return 0; }
  double scatter_rms() const override { return 1e-6; }

 private:
  static constexpr double kScale = 8e-6, kFrequency = 4e4;
  double g2_, length_;
};

struct Bench {
  DiffractionPupil pupil = diffraction_pupil(CircleAperture{kDiameter}, kFocal, kDiameter / 40);
  std::shared_ptr<const MeanScatter> scatter = std::make_shared<const Gaussian>(0.9, 0.03);
  Eigen::ArrayXd height = Eigen::ArrayXd(pupil.sample.size());
  Bench() {
    const Eigen::ArrayXd x = pupil.sample.x / (0.5 * kDiameter), y = pupil.sample.y / (0.5 * kDiameter);
    height = 60e-9 * (x * x - y * y) + 40e-9 * (3 * x * y * y - x * x * x) + 30e-9 * (5 * x).sin();
  }
  DiffractionProblem problem() const {
    DiffractionProblem result{pupil, kFocal, kWave};
    result.scatter = scatter;
    return result;
  }
  Eigen::VectorXd values(const Eigen::ArrayXd& at, const std::vector<Statistic>& statistics,
                         std::vector<Eigen::ArrayXd>* gradients = nullptr, int threads = 1) const {
    Eigen::VectorXd result;
    EXPECT_TRUE(evaluate_diffraction(problem(), at, statistics, threads, nullptr, &result, gradients));
    return result;
  }
};

}  // namespace

TEST(MeanScatter, GradientsAreThoseOfTheValues) {
  const Bench bench;
  const double field = 0.5 * kWave * kFocal / bench.pupil.pitch_x;
  const std::vector<Statistic> statistics{RingThrough{9e-6, 0},
                                          RingThrough{15e-6, 4e-4},
                                          RingThrough{1.5 * field, 0},
                                          EncircledEnergyRadius{0.5, 0},
                                          EncircledEnergyRadius{0.8, -3e-4},
                                          SpotFwhm{1e-6},
                                          RingFwhm{0.7, {}},
                                          StrehlRatio{},
                                          ModulationTransfer{3e4},
                                          ModulationTransfer{1.2e5},
                                          EnsquaredThrough{12e-6, 2e-4},
                                          EnsquaredThrough{2.2 * field, 0}};
  std::vector<Eigen::ArrayXd> gradients;
  bench.values(bench.height, statistics, &gradients);
  const Eigen::ArrayXd x = bench.pupil.sample.x / (0.5 * kDiameter),
                       y = bench.pupil.sample.y / (0.5 * kDiameter);
  for (const Eigen::ArrayXd& direction : {Eigen::ArrayXd(x * x * x - x * y),
                                          Eigen::ArrayXd((4 * y).cos() * x), Eigen::ArrayXd(x * x + y * y)}) {
    // Central differences of two steps, extrapolated.
    const auto difference = [&](double step) -> Eigen::VectorXd {
      return (bench.values(bench.height + step * direction, statistics) -
              bench.values(bench.height - step * direction, statistics)) /
             (2 * step);
    };
    const Eigen::VectorXd truth = (4 * difference(1e-10) - difference(2e-10)) / 3;
    for (std::size_t k = 0; k < statistics.size(); ++k) {
      const double found = (gradients[k] * direction).sum();
      const double scale = std::abs(truth[Eigen::Index(k)]) + 1e-3 * gradients[k].matrix().norm();
      EXPECT_NEAR(found, truth[Eigen::Index(k)], 2e-6 * scale) << statistic_name(statistics[k]);
    }
  }
}

TEST(MeanScatter, ThreadsAndWorkspacesChangeNothing) {
  const Bench bench;
  const std::vector<Statistic> statistics{RingThrough{9e-6, 0}, EncircledEnergyRadius{0.8, -3e-4},
                                          RingFwhm{0.7, {}},    SpotFwhm{0},
                                          StrehlRatio{},        ModulationTransfer{5e4}};
  std::vector<Eigen::ArrayXd> one, two;
  const Eigen::VectorXd alone = bench.values(bench.height, statistics, &one, 1);
  EXPECT_EQ(alone, bench.values(bench.height, statistics, &two, 3));
  for (std::size_t k = 0; k < one.size(); ++k) EXPECT_TRUE((one[k] == two[k]).all());
  // The workspace was used for the same grid without scatter, and with other scatter.
  DiffractionWorkspace workspace;
  Eigen::VectorXd result;
  DiffractionProblem problem = bench.problem();
  for (const auto& scatter :
       {std::shared_ptr<const MeanScatter>(),
        std::shared_ptr<const MeanScatter>(std::make_shared<const Gaussian>(0.4, 0.1))}) {
    problem.scatter = scatter;
    evaluate_diffraction(problem, bench.height, statistics, 1, &workspace, &result, nullptr);
    EXPECT_NE(result[0], alone[0]);
  }
  problem.scatter = bench.scatter;
  evaluate_diffraction(problem, bench.height, statistics, 1, &workspace, &result, nullptr);
  EXPECT_EQ(result, alone);
}

// A workspace must notice that the mean spot belongs to another mirror or another pupil on the same cells.
TEST(MeanScatter, AWorkspaceKnowsWhichMirrorItsMeanSpotsAreOf) {
  const Bench bench;
  const Eigen::ArrayXd nominal =
      2e-7 * (bench.pupil.sample.x.square() + bench.pupil.sample.y.square()) / (kDiameter * kDiameter);
  DiffractionPupil stopped = bench.pupil;
  stopped.amplitude.head(200) *= 0.5;
  DiffractionProblem flat = bench.problem(), curved = flat, dark{stopped, kFocal, kWave};
  curved.nominal = &nominal;
  dark.scatter = bench.scatter;
  const std::vector<Statistic> statistics{RingThrough{9e-6, 0}, EncircledEnergyRadius{0.8, -3e-4}};
  DiffractionWorkspace workspace;
  Eigen::VectorXd first;
  for (const DiffractionProblem* problem : {&flat, &curved, &dark, &flat}) {
    Eigen::VectorXd alone, after;
    evaluate_diffraction(*problem, bench.height, statistics, 1, nullptr, &alone, nullptr);
    evaluate_diffraction(*problem, bench.height, statistics, 1, &workspace, &after, nullptr);
    EXPECT_EQ(after, alone);
    if (problem == &flat)
      first = alone;
    else
      EXPECT_NE(alone[0], first[0]);
  }
  const Eigen::ArrayXd short_one = nominal.head(3);
  curved.nominal = &short_one;
  EXPECT_THROW(evaluate_diffraction(curved, bench.height, statistics, 1, &workspace, &first, nullptr),
               std::invalid_argument);
}

TEST(MeanScatter, BeyondTheFieldOfViewTheCurveIsTheMeanSpots) {
  const Bench bench;
  const double field = 0.5 * kWave * kFocal / bench.pupil.pitch_x;
  const Eigen::VectorXd value =
      bench.values(bench.height,
                   {RingThrough{field, 0}, RingThrough{field * (1 + 1e-12), 0}, RingThrough{1.7 * field, 0}});
  EXPECT_NEAR(value[1], value[0], 1e-10);
  EXPECT_NEAR(value[2] - value[0],
              bench.scatter->encircled_energy(1.7 * field) - bench.scatter->encircled_energy(field), 1e-10);
}

// A square far beyond the field of view costs no more; its energy lies between those of its circles.
TEST(MeanScatter, AHugeSquareHoldsWhatItsCirclesDo) {
  const Bench bench;
  for (const double side : {2e-3, 0.1, 2.0}) {
    const Eigen::VectorXd value =
        bench.values(bench.height, {RingThrough{0.5 * side, 0}, EnsquaredThrough{side, 0},
                                    RingThrough{std::numbers::sqrt2 * 0.5 * side, 0}});
    EXPECT_GE(value[1], value[0] - 1e-12) << side;
    EXPECT_LE(value[1], value[2] + 1e-12) << side;
  }
}

// Tests that the image's transfer function is multiplied by H. Scatter without roughness must change nothing.
TEST(MeanScatter, AnImageIsSpreadByTheScatterFunction) {
  const Bench bench;
  DiffractionProblem problem = bench.problem();
  const PsfWindow window{0, 0, 2e-4};
  const PsfImage spread = diffraction_psf(problem, bench.height, window);
  problem.scatter = nullptr;
  const PsfImage sharp = diffraction_psf(problem, bench.height, window);
  ASSERT_EQ(spread.intensity.rows(), sharp.intensity.rows());
  const double area = spread.pitch * spread.pitch;
  EXPECT_NEAR(spread.intensity.sum() * area, sharp.intensity.sum() * area, 1e-9);
  // The transfer function of both images along x, by direct sums over the field of view.
  for (const int lag : {1, 3, 7, 12}) {
    const double step = 2 * kPi * lag * bench.pupil.pitch_x / (kWave * (kFocal + window.dz)) * spread.pitch;
    double of_spread = 0, of_sharp = 0;
    for (Eigen::Index k = 0; k < spread.intensity.cols(); ++k) {
      of_spread +=
          spread.intensity.col(k).sum() * std::cos(step * double(k) + spread.first / spread.pitch * step);
      of_sharp +=
          sharp.intensity.col(k).sum() * std::cos(step * double(k) + sharp.first / sharp.pitch * step);
    }
    const double h = bench.scatter->transfer(Eigen::ArrayXd::Constant(1, lag * bench.pupil.pitch_x))[0];
    EXPECT_NEAR(of_spread * area, of_sharp * area * h, 1e-9) << lag;
  }
  problem.scatter = std::make_shared<const Gaussian>(0.0, 0.03);
  EXPECT_LT((diffraction_psf(problem, bench.height, window).intensity - sharp.intensity).abs().maxCoeff(),
            1e-10 * sharp.intensity.maxCoeff());
}

}  // namespace aberfit
