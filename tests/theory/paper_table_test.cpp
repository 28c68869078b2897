// The paper's table of R, and the light beyond small angles.
#include "aberfit/theory/paper_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>

namespace aberfit {
namespace {

TEST(PaperTable, ItsCellsAreThePapersToTwoPerMille) {
  std::ifstream file(ABERFIT_TEST_DATA "/paper/numbers.csv");
  const PaperCells table = paper_cells({}, 2.8);
  ASSERT_EQ(table.cells.size(), 36u);
  EXPECT_EQ(table.wavelength, 500e-9);
  const std::regex cell("^R-(\\d+)nm-(\\d+)um-([0-9.]+)m,.*\"R at [^\"]*\",([0-9.e]+),none,.*");
  int found = 0;
  for (std::string line; std::getline(file, line);) {
    std::smatch part;
    if (!std::regex_match(line, part, cell)) continue;
    const auto is = [](double a, double b) { return std::abs(a / b - 1) < 1e-9; };
    const auto at = std::find_if(table.cells.begin(), table.cells.end(), [&](const PaperCell& c) {
      return is(c.rms_height, std::stod(part[1]) * 1e-9) &&
             is(c.correlation_length, std::stod(part[2]) * 1e-6) && is(c.diameter, std::stod(part[3]));
    });
    ASSERT_NE(at, table.cells.end()) << line;
    EXPECT_NEAR(at->ratio / std::stod(part[4]), 1, 0.002) << line;
    ++found;
  }
  EXPECT_EQ(found, 36);
}

// Scattered light beyond an angle by integrating the transfer function: the share within sin(angle) of a
// spot with OTF H is s int H(lambda nu) J1(2 pi s nu) 2 pi dnu, and its specular part is all inside.
double share_beyond_by_integral(double sigma, double length, double wavelength, double angle) {
  const double g2 = std::pow(4 * std::numbers::pi * sigma / wavelength, 2);
  const double k = 2 * std::numbers::pi * std::sin(angle) / wavelength;  // J1(k x), x the shear
  const int n = 100000;
  const double last = 12 * length, h = last / n;
  double sum = 0;
  for (int i = 1; i < n; ++i) {
    const double x = i * h;
    const double scattered = std::exp(-g2 * (1 - std::exp(-x * x / (length * length)))) - std::exp(-g2);
    sum += (i % 2 ? 4 : 2) * scattered * std::cyl_bessel_j(1.0, k * x);
  }
  const double inside = k * sum * h / 3;
  return -std::expm1(-g2) - inside;
}

TEST(GaussianShareBeyond, MatchesTheIntegralOfTheTransferFunction) {
  const double ten = 10 * std::numbers::pi / 180;
  for (const double sigma : {1e-9, 10e-9, 50e-9, 100e-9})
    for (const double length : {0.7e-6, 1.13e-6, 2e-6, 5e-6})
      EXPECT_NEAR(gaussian_share_beyond(sigma, length, 500e-9, ten),
                  share_beyond_by_integral(sigma, length, 500e-9, ten), 2e-7)
          << sigma << " " << length;
  // In the limit of rays: a Gaussian of slopes, per axis sqrt2 sigma/l, that turn light by twice as much.
  const double sigma = 1e-6, length = 20e-6, slope = std::sqrt(2.0) * sigma / length;
  EXPECT_NEAR(gaussian_share_beyond(sigma, length, 500e-9, ten) /
                  std::exp(-std::pow(std::sin(ten) / (2 * slope), 2) / 2),
              1, 0.02);
}

TEST(GaussianShareBeyond, ToldForTheCellsOfTheTableThatNeedIt) {
  for (const PaperCell& cell : paper_cells({}, 2.8).cells) {
    // First order in sigma the light is the PSD's beyond sin(angle)/lambda, which l_c = 10 um has nothing of.
    if (cell.correlation_length > 5e-6 && cell.rms_height < 2e-7) {
      EXPECT_LT(cell.wide_share, kWideShare);
    }
    if (cell.correlation_length < 2e-6 && cell.rms_height > 5e-8) {
      EXPECT_GT(cell.wide_share, 0.3);
    }
  }
}

}  // namespace
}  // namespace aberfit
