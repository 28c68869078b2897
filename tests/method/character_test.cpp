// The character test finds surfaces with a known fault and accepts random surfaces. All surfaces are sums of
// plane waves written here, independent of the random surfaces of the method.
#include "aberfit/method/character.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "aberfit/core/random.h"
#include "aberfit/study/read_study.h"

namespace aberfit {
namespace {

constexpr double kDiameter = 0.4, kLow = 2.5, kHigh = 20;  // [m], [cycles/m]

Study study_of(const char* wavelength = "2 um", double high = kHigh) {
  return parse_study(
      std::string(
          R"({"aberfit": 1, "mirror": {"focal_length": "4 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
          "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": ")" +
          std::to_string(high) + R"( /m"}},
          "terms": {"fourier": {"count": 400}, "band": "all"}, "light": {"wavelength": ")") +
          wavelength + "\"}}",
      "study.json");
}

struct Surface {
  TermSet terms;
  Eigen::VectorXd coefficients;
};

// Independent normal amplitudes on a grid of frequencies half a cycle across apart, each with the variance of
// its grid cell times `times`(f).
Surface waves(std::uint64_t seed, const std::function<double(double)>& times, double stretch_x = 1,
              double high = kHigh) {
  const double step = 0.5 / kDiameter;
  const double psd = 1e-14 / (M_PI * (high * high - kLow * kLow));
  Surface surface;
  surface.terms.radius = 0.5 * kDiameter;
  std::vector<double> sigma;
  for (int j = 0; j * step < high; ++j)
    for (int k = -int(high / step); k * step <= high; ++k) {
      const double f = step * std::hypot(j, k);
      if ((j == 0 && k <= 0) || f < kLow || f > high) continue;
      surface.terms.fourier.push_back({stretch_x * k * step, j * step});
      sigma.push_back(std::sqrt(2 * psd * step * step * times(f)));  // a grid cell and its mirror image
    }
  surface.coefficients.resize(surface.terms.size());
  const RandomStream stream(seed, "character-test");
  for (std::size_t i = 0; i < sigma.size(); ++i) {
    const auto [a, b] = stream.normal_pair(i);
    surface.coefficients[Eigen::Index(2 * i)] = sigma[i] * a;
    surface.coefficients[Eigen::Index(2 * i) + 1] = sigma[i] * b;
  }
  return surface;
}

Surface draw(std::uint64_t seed) {
  return waves(seed, [](double) { return 1.0; });
}

class CharacterOf {
 public:
  explicit CharacterOf(const char* wavelength = "2 um", double high = kHigh)
      : study_(study_of(wavelength, high)), ground_(lay_groundwork(study_)) {}
  Character operator()(const Surface& surface, std::uint64_t seed = 1) {
    study_.fit.seed = seed;
    return character_of(study_, ground_, surface.terms, surface.coefficients, {2});
  }

 private:
  Study study_;
  Groundwork ground_;
};

TEST(Character, ADrawIsInsideAsOftenAsStated) {
  CharacterOf character;
  constexpr int kSurfaces = 24;
  int outside = 0, measures = 0;
  for (int s = 0; s < kSurfaces; ++s) {
    const Character found = character(draw(100 + std::uint64_t(s)), 1 + std::uint64_t(s));
    ASSERT_EQ(found.light_obstacle, "");
    bool psd = true, zones = true;
    for (const CharacterBin& bin : found.psd) psd = psd && bin.ratio.inside();
    for (const ZoneSlope& zone : found.zones) zones = zones && zone.ratio.inside();
    for (const bool inside : {psd, zones, found.slope_x_over_y.inside(), found.length_over_width->inside(),
                              found.bright_share->inside()}) {
      outside += !inside;
      ++measures;
    }
  }
  // 1.2 of 120 are expected outside; 6 or more occur once in 500.
  EXPECT_EQ(measures, 5 * kSurfaces);
  EXPECT_LE(outside, 5);
}

// A bin of a quarter octave at 13 cycles across has some forty independent amplitudes: known to 16 %.
TEST(Character, FindsTheBinWhosePsdIsThreeTimesTooHigh) {
  constexpr double kTop = 40, kFrom = 27, kTo = 33;
  const auto raised = [](double f) { return f > kFrom && f < kTo ? 3.0 : 1.0; };
  const Character found = CharacterOf("2 um", kTop)(waves(7, raised, 1, kTop));
  EXPECT_TRUE(found.fault().starts_with("its PSD ")) << found.fault();
  for (const CharacterBin& bin : found.psd) {
    const bool of_it = bin.middle() > kFrom && bin.middle() < kTo;
    if (of_it) {
      EXPECT_GT(bin.ratio.value, bin.ratio.high) << bin.low;
      EXPECT_NEAR(bin.ratio.value, 3, 1.2);
    } else if (bin.high < 0.8 * kFrom) {
      EXPECT_TRUE(bin.ratio.inside()) << bin.low;
    }
    EXPECT_NEAR(bin.specification * (M_PI * (kTop * kTop - kLow * kLow)) / 1e-14, 1, 1e-6);
  }
}

TEST(Character, FindsASurfaceThatIsStretchedAlongX) {
  const Character found = CharacterOf("632.8 nm")(waves(
      3, [](double) { return 1.0; }, 1 / 1.8));
  EXPECT_FALSE(found.slope_x_over_y.inside());
  EXPECT_NEAR(found.slope_x_over_y.value, 1 / 1.8, 0.12);
  ASSERT_TRUE(found.length_over_width);
  EXPECT_FALSE(found.length_over_width->inside()) << found.length_over_width->value;
  EXPECT_NE(found.fault(), "");
}

// Six waves at the corners of a hexagon have the height of the roughness but scatter into a few ghost images.
TEST(Character, FindsAFewPlaneWavesByTheContrastOfTheirImage) {
  Surface few;
  few.terms.radius = 0.5 * kDiameter;
  for (const double f : {9.0, 17.0})
    for (int k = 0; k < 3; ++k)
      few.terms.fourier.push_back({f * std::cos(k * M_PI / 3 + 0.2), f * std::sin(k * M_PI / 3 + 0.2)});
  few.coefficients = Eigen::VectorXd::Constant(few.terms.size(), 100e-9 / std::sqrt(6.0));
  const Character found = CharacterOf("632.8 nm")(few);
  ASSERT_TRUE(found.bright_share);
  EXPECT_GT(found.bright_share->value, found.bright_share->high);
  EXPECT_GT(found.bright_share->value, 1.5 * found.bright_share->mean);
}

// For a quatrefoil the squared ratio is the mean of rho^6 over the ring a..b against 1/4 over the disc.
TEST(Character, SlopesByZoneAreThoseOfTheClosedForm) {
  Surface quatrefoil;
  quatrefoil.terms.radius = 0.5 * kDiameter;
  quatrefoil.terms.zernike = {{4, 4}};
  quatrefoil.coefficients = Eigen::VectorXd::Constant(1, 1e-8);
  Study study = study_of();
  const Groundwork ground = lay_groundwork(study);
  quatrefoil.terms.fourier = {{kHigh, 0}};  // a zero term that extends the grid to the whole band
  quatrefoil.coefficients.conservativeResize(3);
  quatrefoil.coefficients.tail(2).setZero();
  const Character found = character_of(study, ground, quatrefoil.terms, quatrefoil.coefficients, {2});
  ASSERT_EQ(found.zones.size(), 4u);
  EXPECT_NEAR(found.zones[3].ratio.value, std::sqrt((1 - std::pow(0.75, 8)) / (1 - 0.75 * 0.75)), 3e-2);
  EXPECT_NE(found.fault(), "");
}

TEST(Character, InOtherLightADrawIsAsFarOffAsDraws) {
  const Character found = CharacterOf()(draw(5));
  ASSERT_EQ(found.others.size(), 4u);
  for (const OtherLight& other : found.others) {
    ASSERT_EQ(other.obstacle, "");
    EXPECT_GT(other.draws, 0);
    EXPECT_LT(other.worst, 4 * other.draws);
    EXPECT_GT(other.worst, other.draws / 10);
  }
  EXPECT_NEAR(found.others[1].wavelength, 3e-6, 1e-15);
}

}  // namespace
}  // namespace aberfit
