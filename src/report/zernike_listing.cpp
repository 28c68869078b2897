#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <stdexcept>

#include "aberfit/scene/zernike.h"
#include "coefficient_listing.h"
#include "listing_lines.h"

// The layout is that of OpticStudio's analysis "Zernike Standard Coefficients" (an example is HSC_Zernike.txt
// in the tests of batoid): header, then "Z   j <tab> value <tab> : <tab> polynomial". That analysis lists the
// wavefront; this listing is of the surface, and its line "Quantity" says so. The reader insists on that
// line, since a wavefront taken for a surface is wrong by a factor of 2.
namespace aberfit {
using namespace internal;

namespace {

constexpr std::string_view kFirstLine = "Listing of Zernike Standard Coefficient Data";
constexpr std::string_view kQuantity = "surface sag in waves";
constexpr const char* kListingFile = "a listing of Zernike Standard coefficients of a surface";

// Coefficients of R_n^m by falling power, n, n - 2, ..., m: (-1)^k C(n-k, k) C(n-2k, (n-m)/2 - k), integers
// below 1e9 for n <= 20. For printing only; nothing is evaluated with them.
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

std::string squeezed(std::string_view text) {
  std::string result;
  for (const std::string_view word : aberfit::words(text)) {
    if (!result.empty()) result += ' ';
    result += word;
  }
  return result;
}

struct ListingHeader {
  std::optional<double> wavelength, radius;
  std::optional<int> terms;
  bool quantity = false;
};

double positive_length(const ListingLines& file, std::string_view value, const std::string& key,
                       const std::vector<std::string_view>& units, double factor) {
  const std::vector<std::string_view> words = aberfit::words(value);
  if (words.size() != 2 || std::find(units.begin(), units.end(), words[1]) == units.end())
    file.fail(value, key + ": a number and its unit, " + std::string(units[0]));
  const double length = file.number(words[0], key) * factor;
  if (!(length > 0) || !std::isfinite(length)) file.fail(value, key + ": a length above 0");
  return length;
}

void header_line(const ListingLines& file, ListingHeader* header) {
  const std::size_t colon = file.text().find(':');
  if (colon == std::string_view::npos) return;
  const std::string_view key = trimmed(file.text().substr(0, colon));
  const std::string_view value = trimmed(file.text().substr(colon + 1));
  const auto once = [&](bool there) {
    if (there) file.fail(file.text(), "each line of the header once");
  };
  if (key == "Wavelength") {
    once(header->wavelength.has_value());
    // OpticStudio writes the micro sign, in UTF-8 or in Latin-1.
    header->wavelength = positive_length(file, value, "wavelength", {"um", "\xC2\xB5m", "\xB5m"}, 1e-6);
  } else if (key == "Normalization radius") {
    once(header->radius.has_value());
    header->radius = positive_length(file, value, "normalization radius", {"mm"}, 1e-3);
  } else if (key == "Number of terms") {
    once(header->terms.has_value());
    header->terms = file.integer(value, "number of terms");
    if (*header->terms < 1 || *header->terms > kZernikeStandardTerms)
      file.fail(value, fmt::format("number of terms: 1 .. {}", kZernikeStandardTerms));
  } else if (key == "Quantity") {
    once(header->quantity);
    if (value != kQuantity) file.fail(value, std::string(kQuantity) + " (a wavefront is twice the surface)");
    header->quantity = true;
  }
}

bool is_coefficient(std::string_view text) {
  return text.size() > 1 && text[0] == 'Z' && (text[1] == ' ' || text[1] == '\t');
}

double coefficient(const ListingLines& file, int j) {
  const std::string_view text = file.text();
  const std::size_t colon = text.find(':');
  const std::string form = fmt::format("\"Z {} value : {}\"", j, zernike_polynomial_text(j));
  const std::vector<std::string_view> words = aberfit::words(text.substr(0, colon));
  if (colon == std::string_view::npos || words.size() != 3 || words[0] != "Z") file.fail(text, form);
  if (file.integer(words[1], "index") != j) file.fail(text, form);
  // Fringe or OSA order under the same numbers shows here.
  if (squeezed(text.substr(colon + 1)) != zernike_polynomial_text(j)) file.fail(text, form);
  return file.number(words[2], "coefficient [waves]");
}

}  // namespace

namespace internal {

std::string zernike_polynomial_text(int j) {
  const ZernikeMode mode = zernike_from_noll(j);
  if (mode.n == 0) return "1";
  const int m = std::abs(mode.m);
  std::string text = fmt::format("{}^(1/2) ({})", (m == 0 ? 1 : 2) * (mode.n + 1), radial_text(mode.n, m));
  if (m == 0) return text;
  return text + fmt::format(" * {} ({}A)", mode.m > 0 ? "COS" : "SIN", m == 1 ? "" : std::to_string(m));
}

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

  const double wave_mm = input.wavelength * 1e3;
  std::string text(kFirstLine);
  text += fmt::format("\n\nTitle: {}\n\n", one_line(input.title, 200));
  text +=
      "The coefficients are those of the SURFACE, not of the wavefront: sag in waves of the wavelength "
      "below.\n"
      "On reflection at normal incidence the wavefront error is twice the sag.\n"
      "Sag is positive along +z, towards the incoming light, which travels along -z. In a lens whose light\n"
      "reaches the mirror along +z, turn the surface by 180 degrees about y (x and z change sign) first.\n";
  text += fmt::format(
      "For a Zernike Standard Sag surface with lens units of mm multiply by {:.15g} (1 wave in mm).\n",
      wave_mm);
  text +=
      "p is the distance from the axis over the normalization radius, A the angle from +x towards +y.\n"
      "Polynomials have unit RMS over the disc (Noll 1976).\n\n"
      "Using Zernike Standard polynomials.\n\n";
  text += fmt::format("Quantity                     :\t{}\n", kQuantity);
  text += fmt::format("Wavelength                   :\t{:.15g} um\n", input.wavelength * 1e6);
  text += fmt::format("Normalization radius         :\t{:.15g} mm\n", input.terms.radius * 1e3);
  text += fmt::format("Number of terms              :\t{}\n\n", waves.size());
  for (std::size_t i = 0; i < waves.size(); ++i) {
    // OpticStudio right-aligns the number under the root; 12 decimals instead of its 8 make 1e-18 m.
    const std::string polynomial = zernike_polynomial_text(int(i) + 1);
    const int pad = int(std::min(polynomial.find('^'), polynomial.size()));
    text +=
        fmt::format("Z {:3}\t{:18.12f}\t:\t{:{}}{}\n", i + 1, waves[i], "", 4 - std::min(pad, 4), polynomial);
  }
  return text;
}

}  // namespace internal

ZernikeListing read_zernike_listing(const std::string& path) {
  ListingLines file(path);
  if (!file.next()) file.fail_whole("an empty file", kListingFile);
  if (file.text() != kFirstLine) file.fail(file.text(), "\"" + std::string(kFirstLine) + "\"");
  ZernikeListing listing;
  ListingHeader header;
  while (file.next()) {
    if (is_coefficient(file.text()))
      listing.waves.push_back(coefficient(file, int(listing.waves.size()) + 1));
    else if (listing.waves.empty())
      header_line(file, &header);
    else
      file.fail(file.text(), "nothing but coefficients after the first one");
    if (listing.waves.size() > std::size_t(kZernikeStandardTerms))
      file.fail(file.text(), fmt::format("at most {} terms", kZernikeStandardTerms));
  }
  if (!header.quantity)
    file.fail_whole("no line \"Quantity\" (a listing of a wavefront?)",
                    "\"Quantity : " + std::string(kQuantity) + "\"");
  if (!header.wavelength) file.fail_whole("no wavelength", "a line \"Wavelength : 0.6328 um\"");
  if (!header.radius) file.fail_whole("no normalization radius", "a line \"Normalization radius : 200 mm\"");
  if (!header.terms) file.fail_whole("no number of terms", "a line \"Number of terms : 231\"");
  if (listing.waves.size() != std::size_t(*header.terms))
    file.fail_whole(fmt::format("{} coefficients", listing.waves.size()),
                    fmt::format("the {} the header states", *header.terms));
  listing.wavelength = *header.wavelength;
  listing.radius = *header.radius;
  return listing;
}

}  // namespace aberfit
