#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include "aberfit/scene/zernike.h"
#include "coefficient_listing.h"

// The layout is that of OpticStudio's analysis "Zernike Standard Coefficients" (an example is HSC_Zernike.txt
// in the tests of batoid): header, then "Z   j <tab> value <tab> : <tab> polynomial". That analysis lists the
// wavefront; this listing has the surface, as its line "Quantity" says.
namespace aberfit {
using namespace internal;

namespace {

constexpr int kZernikeStandardTerms = 231;  // limit of OpticStudio: all modes of n <= 20

// Coefficients of R_n^m for the powers n, n - 2, ..., m: (-1)^k C(n-k, k) C(n-2k, (n-m)/2 - k). They are
// integers below 1e9 for n <= 20. They are only printed, never used to evaluate.
std::vector<std::int64_t> radial_integers(int n, int m) {
  std::vector<std::int64_t> result;
  const auto choose = [](int from, int count) {
    std::int64_t value = 1;
    for (int i = 1; i <= count; ++i) value = value * (from - count + i) / i;
    return value;
  };
  for (int k = 0; 2 * k <= n - m; ++k)
    result.push_back((k % 2 == 0 ? 1 : -1) * choose(n - k, k) * choose(n - 2 * k, (n - m) / 2 - k));
  return result;
}

std::string radial_text(int n, int m) {
  std::string text;
  int power = n;
  for (const std::int64_t factor : radial_integers(n, m)) {
    const std::int64_t size = std::abs(factor);
    text += text.empty() ? "" : factor < 0 ? " - " : " + ";
    if (size != 1 || power == 0) text += std::to_string(size);
    if (power == 1) text += "p";
    if (power > 1) text += fmt::format("p^{}", power);
    power -= 2;
  }
  return text;
}

// The mode of Noll index j as OpticStudio prints it: "8^(1/2) (3p^3 - 2p) * SIN (A)".
std::string zernike_polynomial_text(int j) {
  const ZernikeMode mode = zernike_from_noll(j);
  if (mode.n == 0) return "1";
  const int m = std::abs(mode.m);
  std::string text = fmt::format("{}^(1/2) ({})", (m == 0 ? 1 : 2) * (mode.n + 1), radial_text(mode.n, m));
  if (m == 0) return text;
  return text + fmt::format(" * {} ({}A)", mode.m > 0 ? "COS" : "SIN", m == 1 ? "" : std::to_string(m));
}

}  // namespace

namespace internal {

std::string zernike_listing_text(const ExportInput& input) {
  std::vector<double> waves;
  for (const ZernikeCoefficient& term : as_zernikes(input, "zernike-noll")) {
    const int j = noll_index(term.mode);
    if (j > kZernikeStandardTerms)
      throw std::invalid_argument(
          fmt::format("zernike-noll: Zernike n = {} is beyond the {} terms (n <= 20) of Zernike Standard; "
                      "export zemax-grid-sag instead",
                      term.mode.n, kZernikeStandardTerms));
    if (waves.size() < std::size_t(j)) waves.resize(std::size_t(j), 0.0);
    waves[std::size_t(j - 1)] += term.value / input.wavelength;
  }
  if (waves.empty()) waves.push_back(0.0);

  std::string text = fmt::format(
      "Listing of Zernike Standard Coefficient Data\n\nTitle: {}\n\n"
      "The coefficients are those of the SURFACE, not of the wavefront: sag in waves of the wavelength "
      "below.\n"
      "On reflection at normal incidence the wavefront error is twice the sag.\n"
      "Sag is positive along +z, towards the incoming light, which travels along -z. In a lens whose light\n"
      "reaches the mirror along +z, turn the surface by 180 degrees about y (x and z change sign) first.\n"
      "For a Zernike Standard Sag surface with lens units of mm multiply by {:.15g} (1 wave in mm).\n"
      "p is the distance from the axis over the normalization radius, A the angle from +x towards +y.\n"
      "Polynomials have unit RMS over the disc (Noll 1976).\n\n"
      "Using Zernike Standard polynomials.\n\n"
      "Quantity                     :\tsurface sag in waves\n"
      "Wavelength                   :\t{:.15g} um\n"
      "Normalization radius         :\t{:.15g} mm\n"
      "Number of terms              :\t{}\n\n",
      one_line(input.title, 200), input.wavelength * 1e3, input.wavelength * 1e6, input.terms.radius * 1e3,
      waves.size());
  for (std::size_t i = 0; i < waves.size(); ++i) {
    // OpticStudio right-aligns the number under the root. We write 12 decimals instead of 8, which resolves
    // 1e-18 m.
    const std::string polynomial = zernike_polynomial_text(int(i) + 1);
    const int pad = int(std::min(polynomial.find('^'), polynomial.size()));
    text +=
        fmt::format("Z {:3}\t{:18.12f}\t:\t{:{}}{}\n", i + 1, waves[i], "", 4 - std::min(pad, 4), polynomial);
  }
  return text;
}

}  // namespace internal

}  // namespace aberfit
