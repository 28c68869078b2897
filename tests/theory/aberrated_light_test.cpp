// Strehl ratio, encircled energy and centroid of known aberrations against an independent transform of the
// pupil; the highest irradiance of the mean spot against rings and differences.
#include "aberfit/theory/aberrated_light.h"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "aberfit/scene/zernike.h"
#include "aberfit/theory/light_property.h"
#include "aberfit/theory/psd_jacobian.h"

namespace aberfit {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

// f/20: the exact form equals the textbook's to 1/(32 N^2) = 8e-5.
constexpr double kFocal = 4, kDiameter = 0.2, kWave = 632.8e-9;
constexpr double kAiry = kWave * kFocal / kDiameter;

const PsdModel kNearlyNothing = GaussianPsd{1e-16, 0.02};

Mirror aberrated(int noll, double waves) {
  Mirror mirror{kFocal};
  mirror.zernike_radius = kDiameter / 2;
  mirror.zernike = {{zernike_from_noll(noll), 0.5 * waves * kWave}};  // a wavefront is twice the surface
  return mirror;
}

// Noll 1976, orthonormal on the disc.
double noll(int index, double x, double y) {
  const double r2 = x * x + y * y;
  switch (index) {
    case 2:
      return 2 * x;
    case 3:
      return 2 * y;
    case 5:
      return std::sqrt(6) * 2 * x * y;
    case 6:
      return std::sqrt(6) * (x * x - y * y);
    case 7:
      return std::sqrt(8) * (3 * r2 - 2) * y;
    case 8:
      return std::sqrt(8) * (3 * r2 - 2) * x;
    case 9:
      return std::sqrt(8) * (3 * x * x * y - y * y * y);
    default:
      return std::sqrt(8) * (x * x * x - 3 * x * y * y);
  }
}

// In place; the length is a power of two (Cooley and Tukey 1965).
void fft(Complex* data, int n, int stride) {
  for (int i = 1, j = 0; i < n; ++i) {
    int bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(data[i * stride], data[j * stride]);
  }
  for (int length = 2; length <= n; length *= 2)
    for (int k = 0; k < length / 2; ++k) {
      const Complex turn = std::polar(1.0, -2 * pi * k / length);
      for (int first = k; first < n; first += length) {
        Complex &low = data[first * stride], &high = data[(first + length / 2) * stride];
        const Complex turned = turn * high;
        high = low - turned;
        low += turned;
      }
    }
}

// The pattern of a circular pupil with an aberration, sampled four times per lambda N.
class TransformedPupil {
 public:
  static constexpr int kCells = 128, kSize = 512;

  TransformedPupil(int index, double waves) : pattern_(std::size_t(kSize) * kSize) {
    constexpr int kParts = 8;  // along each side of a grid cell at the edge
    for (int row = 0; row < kCells; ++row)
      for (int column = 0; column < kCells; ++column) {
        const auto place = [](double cell) { return (2 * cell + 1) / kCells - 1; };
        const double x = place(column), y = place(row), reach = std::sqrt(2) / kCells;
        double clear = std::hypot(x, y) < 1 ? 1 : 0;
        if (std::abs(std::hypot(x, y) - 1) < reach) {
          clear = 0;
          for (int i = 0; i < kParts * kParts; ++i) {
            const double px = place(column + (i % kParts + 0.5) / kParts - 0.5),
                         py = place(row + (i / kParts + 0.5) / kParts - 0.5);
            if (std::hypot(px, py) < 1) add(px, py, 1.0 / (kParts * kParts), index, waves), clear += 1;
          }
          clear /= kParts * kParts;
        } else if (clear > 0) {
          add(x, y, 1, index, waves);
        }
        pattern_[std::size_t(row) * kSize + column] = std::polar(clear, -2 * pi * waves * noll(index, x, y));
        all_ += clear * clear;
        flat_ += clear;
      }
    transform();
    for (Complex& one : pattern_) one = std::norm(one);
  }

  // Irradiance over that of the pupil without aberration.
  double at(double x, double y) const {  // [lambda N]
    Complex sum = 0;
    for (const Cell& cell : cells_) sum += cell.field * std::polar(1.0, -pi * (cell.x * x + cell.y * y));
    return std::norm(sum) / (flat_ * flat_);
  }
  // The highest sample, refined on the sum over grid cells.
  double strehl() const {
    std::size_t best = 0;
    for (std::size_t k = 0; k < pattern_.size(); ++k)
      if (pattern_[k].real() > pattern_[best].real()) best = k;
    double step = double(kCells) / kSize, x = place(int(best % kSize)), y = place(int(best / kSize));
    double top = at(x, y);
    for (; step > 1e-4; step *= 0.5)
      for (bool moved = true; moved;) {
        moved = false;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
          if (const double there = at(x + dx * step, y + dy * step); there > top)
            top = there, x += dx * step, y += dy * step, moved = true;
      }
    return top;
  }
  // From the transfer function: energy in circles [lambda N], centroid from the lowest frequency's phase.
  struct Measured {
    std::vector<double> energy;
    double x, y;
  };
  Measured measured(const std::vector<double>& radii) const {
    TransformedPupil copy = *this;
    copy.transform();  // a lag of k grid points has the frequency k/kCells [1/(lambda N)]
    Measured result{std::vector<double>(radii.size(), 0.0), 0, 0};
    const double all = copy.pattern_[0].real();
    for (int row = 0; row < kSize; ++row)
      for (int column = 0; column < kSize; ++column) {
        if (std::hypot(signed_place(column), signed_place(row)) > kCells) continue;  // beyond cutoff
        const double a = signed_place(column), b = signed_place(row), nu = std::hypot(a, b) / kCells;
        const double value = copy.pattern_[std::size_t(row) * kSize + column].real() / all;
        for (std::size_t k = 0; k < radii.size(); ++k)
          result.energy[k] +=
              value *
              (nu == 0 ? pi * radii[k] * radii[k]
                       : radii[k] * boost::math::cyl_bessel_j(1, 2 * pi * nu * radii[k]) / nu) /
              (double(kCells) * kCells);
      }
    // Partly clear grid cells at the edge contribute less energy than their area.
    for (double& one : result.energy) one *= all_ / flat_;
    // An overlap lacks a rim as wide as its shear. The phase slope is therefore extrapolated to shear 0.
    const auto shift = [&](std::size_t stride) {
      const auto at = [&](int k) {
        return -kCells * std::arg(copy.pattern_[stride * std::size_t(k)]) / (2 * pi * k);
      };
      return 3 * at(1) - 3 * at(2) + at(3);
    };
    result.x = shift(1);
    result.y = shift(kSize);
    return result;
  }

 private:
  struct Cell {
    double x, y;
    Complex field;
  };
  // A surface that is higher on the illuminated side shortens the path.
  void add(double x, double y, double area, int index, double waves) {
    cells_.push_back({x, y, std::polar(area, -2 * pi * waves * noll(index, x, y))});
  }
  static double signed_place(int k) { return k <= kSize / 2 ? k : k - kSize; }
  static double place(int k) { return signed_place(k) * kCells / kSize; }
  void transform() {
    for (int k = 0; k < kSize; ++k) fft(pattern_.data() + std::size_t(k) * kSize, kSize, 1);
    for (int k = 0; k < kSize; ++k) fft(pattern_.data() + k, kSize, kSize);
  }

  std::vector<Complex> pattern_;
  std::vector<Cell> cells_;
  double all_ = 0, flat_ = 0;
};

TEST(AberratedLight, OfEightPupilsIsThatOfATransformOfThePupil) {
  struct Pupil {
    int noll;
    double waves;
  };
  constexpr double kError = 1e-3;
  for (const auto& [index, waves] : std::vector<Pupil>{
           {2, 0.03}, {3, 0.5}, {8, 0.05}, {7, 0.5}, {6, 0.1}, {5, 0.35}, {9, 0.2}, {10, 0.5}}) {
    SCOPED_TRACE(testing::Message() << "Noll " << index << ", " << waves << " waves");
    const TransformedPupil truth(index, waves);
    const Mirror mirror = aberrated(index, waves);
    const GhsPupil pupil(mirror, CircleAperture{kDiameter}, kWave);
    const AberratedLight light(pupil);
    const RadialPsd smooth(kNearlyNothing);
    const double strehl = truth.strehl();
    const DiffractionPeak peak = light.peak(smooth);
    EXPECT_NEAR(peak.strehl / strehl, 1, kError);
    EXPECT_NEAR(peak.axis_ratio, truth.at(0, 0), kError);
    EXPECT_NEAR(truth.at(peak.x / kAiry, peak.y / kAiry) / strehl, 1, kError);
    const std::vector<double> radii{0.6, 1.1, 2.3, 4};
    const TransformedPupil::Measured measured = truth.measured(radii);
    // At the lowest frequencies the partly clear grid cells lie at the rim, where coma is steepest.
    constexpr double kErrorOfTransform = 0.02;
    EXPECT_NEAR(light.centroid()[0] / kAiry, measured.x, kErrorOfTransform);
    EXPECT_NEAR(light.centroid()[1] / kAiry, measured.y, kErrorOfTransform);
    // The mean wavefront slope over the disc: 2 for tilt, sqrt(8) for coma with its tilt, else 0.
    const double slope = index <= 3 ? 2 : index == 7 || index == 8 ? std::sqrt(8) : 0;
    const std::size_t axis = index == 3 || index == 7 ? 1 : 0;
    EXPECT_NEAR(light.centroid()[axis] / kAiry, -2 * waves * slope,
                kError * std::max(1.0, 2 * waves * slope));
    EXPECT_NEAR(light.centroid()[1 - axis] / kAiry, 0, kError);
    const DiffractionPupil cells = diffraction_pupil(CircleAperture{kDiameter}, kFocal, kDiameter / 256);
    Eigen::ArrayXd height(cells.sample.size());
    for (Eigen::Index k = 0; k < height.size(); ++k)
      height[k] = 0.5 * waves * kWave *
                  noll(index, cells.sample.x[k] / (kDiameter / 2), cells.sample.y[k] / (kDiameter / 2));
    std::vector<Statistic> wanted{StrehlRatio{}};
    for (const double radius : radii) wanted.push_back(RingThrough{radius * kAiry, 0});
    Eigen::VectorXd values;
    ASSERT_TRUE(evaluate_diffraction({cells, kFocal, kWave}, height, wanted, 1, nullptr, &values, nullptr));
    EXPECT_NEAR(values[0] / strehl, 1, kError);
    for (std::size_t k = 0; k < radii.size(); ++k)
      EXPECT_NEAR(values[Eigen::Index(k) + 1], measured.energy[k], kError) << radii[k];
    EXPECT_NEAR(LightProperties({StrehlRatio{}}, pupil)(GeneralisedHarveyShack(smooth, pupil))[0] / strehl, 1,
                kError);
  }
}

// Without aberrations or with a tilt the grid gives the closed form, with little or much scatter.
TEST(AberratedLight, OfATiltHasTheStrehlRatioOfTheParabola) {
  const PsdModel fine =
      KCorrelationPsd{.rms = 20e-9, .correlation = 0.01, .exponent = 3, .f_min = 5, .f_max = 500};
  const PsdModel coarse = GaussianPsd{90e-9, 0.05};
  for (const Aperture& aperture : std::vector<Aperture>{
           CircleAperture{kDiameter}, AnnulusAperture{kDiameter, 0.08}, RectangleAperture{0.2, 0.12}})
    for (const PsdModel& psd : {fine, coarse}) {
      const GhsPupil flat(Mirror{kFocal}, aperture, kWave), tilted(aberrated(2, 0.7), aperture, kWave);
      const double expected =
          LightProperties({StrehlRatio{}}, flat)(GeneralisedHarveyShack(RadialPsd(psd), flat))[0];
      // GeneralisedHarveyShack follows the outline of a rectangle to 2e-4 of its radius.
      const double error = std::holds_alternative<RectangleAperture>(aperture) ? 3e-4 : 1e-6;
      EXPECT_NEAR(AberratedLight(flat).peak(RadialPsd(psd)).strehl / expected, 1, error);
      EXPECT_NEAR(AberratedLight(tilted).peak(RadialPsd(psd)).strehl / expected, 1, error + 1e-4);
    }
}

// The mean irradiance of a round pupil can be highest on a ring. Reference: dense samples of the irradiance.
TEST(AberratedLight, OfRevolutionIsHighestOnTheAxisOrOnARing) {
  bool on_ring = false;
  for (const double waves : {0.2, 1.0, 1.5}) {
    Mirror mirror{kFocal};
    mirror.zernike_radius = kDiameter / 2;
    mirror.zernike = {
        {zernike_from_noll(4), 0.5 * waves * kWave / std::sqrt(12)}};  // defocus, peak to valley
    const GhsPupil pupil(mirror, CircleAperture{kDiameter}, kWave);
    const GeneralisedHarveyShack mean(RadialPsd(GaussianPsd{5e-9, 0.02}), pupil);
    const MeanSpot spot = mean.at_plane(0);
    double highest = 0, at = 0;
    for (double r = 0; r < 10 * kAiry; r += 0.02 * kAiry)
      if (const double here = spot.irradiance(r); here > highest) highest = here, at = r;
    EXPECT_NEAR(spot.irradiance(spot.highest_radius()) / highest, 1, 1e-3) << waves;
    EXPECT_NEAR(spot.highest_radius(), at, 0.02 * kAiry) << waves;
    on_ring = on_ring || at > 0;
    const AberratedLight light(pupil);
    EXPECT_NEAR(LightProperties({StrehlRatio{}}, pupil)(mean)[0] / light.peak(mean.psd()).strehl, 1, 1e-3);
  }
  EXPECT_TRUE(on_ring);
}

// d ln(Strehl)/d ln(p) of a pupil without symmetry, by differences.
TEST(AberratedLight, StrehlRatioFollowsTheNumbersOfItsPsd) {
  const PsdModel psd =
      KCorrelationPsd{.rms = 15e-9, .correlation = 0.03, .exponent = 3, .f_min = 5, .f_max = 200};
  for (const auto& [index, waves] : std::vector<std::pair<int, double>>{{8, 0.2}, {9, 0.1}, {6, 0.3}}) {
    const GhsPupil pupil(aberrated(index, waves), CircleAperture{kDiameter}, kWave);
    const LightProperties light({StrehlRatio{}}, pupil);
    std::vector<PsdVariable> numbers = psd_variables(psd);
    numbers.resize(2);
    const PsdJacobian jacobian = psd_jacobian(psd, numbers, {StrehlRatio{}}, pupil, 1, &light);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const double p = value_of(psd, numbers[k]), step = 1e-2;
      const auto at = [&](double factor) {
        return light(GeneralisedHarveyShack(RadialPsd(with_value(psd, numbers[k], p * factor)), pupil))[0];
      };
      const double expected = (at(1 + step) - at(1 - step)) / (2 * step * p);
      for (const Eigen::Index row : {Eigen::Index(0), Eigen::Index(1)})
        EXPECT_NEAR(jacobian.derivatives(row, Eigen::Index(k)), expected,
                    1e-3 * std::abs(expected) + 1e-9 / p)
            << index << " " << k << " " << row;
    }
  }
}

}  // namespace
}  // namespace aberfit
