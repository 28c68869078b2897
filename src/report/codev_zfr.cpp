#include <fmt/format.h>

#include <optional>

#include "aberfit/scene/zernike.h"
#include "coefficient_listing.h"
#include "listing_lines.h"

// A CODE V interferogram file in Zernike form (as in prysm/io.py) has "!" comments, one title line, "ZFR n
// SUR|WFR WVL lambda_um SSZ s", then n Fringe coefficients. Height [um] = coefficient WVL / SSZ, for surface
// and wavefront alike. Fringe polynomials are peak-normalised: R_n^m(1) = 1. Their numbering has no end. We
// do not know the limit of CODE V (other programs' Fringe sets end at 37), so we write all coefficients.
namespace aberfit {
using namespace internal;

namespace {

constexpr const char* kZfrFile = "a CODE V interferogram file of Fringe Zernike coefficients";
constexpr const char* kZfrHeader = "a header \"ZFR n SUR|WFR WVL micrometres SSZ scale\"";
// All modes of n <= 300 are (1 + 300)^2. A damaged count above that must not cause a huge allocation.
constexpr int kMostTerms = 90601;

struct ZfrHeader {
  int terms = 0;
  double metres = 0;  // height of the surface [m] for a coefficient of 1
};

ZfrHeader header_of(const ListingLines& file) {
  const std::vector<std::string_view> words = aberfit::words(file.text());
  if (words.size() < 3 || upper_case(words[0]) != "ZFR") file.fail(file.text(), kZfrHeader);
  ZfrHeader header;
  header.terms = file.integer(words[1], "number of coefficients");
  if (header.terms < 1 || header.terms > kMostTerms)
    file.fail(words[1], fmt::format("number of coefficients: 1 .. {}", kMostTerms));
  const std::string kind = upper_case(words[2]);
  if (kind != "SUR" && kind != "WFR") file.fail(words[2], "SUR (surface) or WFR (wavefront)");
  std::optional<double> wavelength, scale;
  for (std::size_t i = 3; i < words.size(); i += 2) {
    const std::string key = upper_case(words[i]);
    std::optional<double>* value = key == "WVL" ? &wavelength : key == "SSZ" ? &scale : nullptr;
    if (value == nullptr || value->has_value() || i + 1 == words.size()) file.fail(words[i], kZfrHeader);
    *value = file.number(words[i + 1], key);
    if (!(**value > 0)) file.fail(words[i + 1], key + " above 0");
  }
  if (!wavelength || !scale) file.fail(file.text(), kZfrHeader);
  // We store the surface; the wavefront of a mirror is twice that.
  header.metres = *wavelength * 1e-6 / *scale * (kind == "WFR" ? 0.5 : 1.0);
  if (!(header.metres > 0) || !std::isfinite(header.metres)) file.fail(file.text(), "a scale in range");
  return header;
}

}  // namespace

namespace internal {

std::string codev_zfr_text(const ExportInput& input) {
  std::vector<double> fringe;  // [m]
  for (const ZernikeCoefficient& term : as_zernikes(input, "codev-zfr")) {
    const int j = fringe_index(term.mode);
    if (fringe.size() < std::size_t(j)) fringe.resize(std::size_t(j), 0.0);
    fringe[std::size_t(j - 1)] += term.value * zernike_norm(term.mode);
  }
  if (fringe.empty()) fringe.push_back(0.0);
  // The format has no field for the radius, so it is in a comment.
  std::string text = fmt::format(
      "! Fringe Zernike coefficients of the surface (not the wavefront) in waves\n"
      "! sag positive towards the incoming light; normalization radius {:.15g} mm\n"
      "! R = 1 at the rim; angle from +x towards +y, cosine before sine\n"
      "{}\nZFR {} SUR WVL {:.15g} SSZ 1\n",
      input.terms.radius * 1e3, one_line(input.title, 80), fringe.size(), input.wavelength * 1e6);
  for (const double value : fringe) text += fmt::format("{:.15E}\n", value / input.wavelength);
  return text;
}

}  // namespace internal

std::vector<double> read_codev_zfr(const std::string& path) {
  ListingLines file(path);
  const auto next = [&] {
    bool there = file.next();
    while (there && file.text().front() == '!') there = file.next();
    return there;
  };
  if (!next()) file.fail_whole("no title line", kZfrFile);
  if (!next()) file.fail_whole("no header", kZfrHeader);
  const ZfrHeader header = header_of(file);
  std::vector<double> coefficients;
  while (next()) {
    for (const std::string_view word : aberfit::words(file.text())) {
      if (int(coefficients.size()) == header.terms)
        file.fail(word, fmt::format("the end of the file after {} coefficients", header.terms));
      const double value = file.number(word, "coefficient") * header.metres;
      if (!std::isfinite(value)) file.fail(word, "a coefficient in range");
      coefficients.push_back(value);
    }
  }
  if (int(coefficients.size()) != header.terms)
    file.fail_whole(fmt::format("{} coefficients", coefficients.size()),
                    fmt::format("the {} the header states", header.terms));
  return coefficients;
}

}  // namespace aberfit
