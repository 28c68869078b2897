#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <regex>
#include <sstream>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/report/exports.h"
#include "aberfit/scene/zernike.h"
#include "listing_reader.h"

namespace aberfit {
namespace {

constexpr double kWavelength = 632.8e-9, kRadius = 0.15;

struct Surface {
  TermSet terms;
  Eigen::VectorXd coefficients;
  Aperture aperture = CircleAperture{2 * kRadius, 0};

  explicit Surface(int n_max, std::vector<int> spherical = {}) {
    terms.radius = kRadius;
    terms.zernike = zernike_modes(0, n_max);
    terms.spherical = std::move(spherical);
    coefficients.resize(terms.size());
    const RandomStream random(3, "zernike-listing-surface");
    for (Eigen::Index i = 0; i < coefficients.size(); ++i)
      coefficients[i] = 50e-9 * random.normal(std::uint64_t(i));
  }
  ExportInput input() const {
    return {terms, coefficients, aperture, kWavelength, 257, "A mirror: its surface"};
  }
  std::string text(ExportFormat format) const { return export_file(format, input()).second; }

  // Height written anew: one mode at a time, powers for the spherical terms.
  double height(double x, double y) const {
    double h = 0;
    for (std::size_t i = 0; i < terms.zernike.size(); ++i)
      h += coefficients[Eigen::Index(i)] * zernike(terms.zernike[i], x / kRadius, y / kRadius).value;
    for (std::size_t i = 0; i < terms.spherical.size(); ++i)
      h += coefficients[terms.spherical_begin() + Eigen::Index(i)] *
           std::pow(std::hypot(x, y) / kRadius, terms.spherical[i]);
    return h;
  }
};

// Points of the disc, including the rim.
std::vector<std::array<double, 2>> points() {
  std::vector<std::array<double, 2>> result;
  const RandomStream random(5, "zernike-listing-points");
  for (std::uint64_t i = 0; i < 200; ++i) {
    const auto [u, v] = random.uniform_pair(i);
    const double rho = i % 10 == 0 ? kRadius : kRadius * std::sqrt(u), angle = 2 * std::numbers::pi * v;
    result.push_back({rho * std::cos(angle), rho * std::sin(angle)});
  }
  return result;
}

// Value of "8^(1/2) (3p^3 - 2p) * SIN (3A)" as it is printed.
double printed_polynomial(const std::string& text, double p, double angle) {
  static const std::regex whole(R"(\s*(\d+)\^\(1/2\) \(([^)]*)\)(?: \* (SIN|COS) \((\d*)A\))?\s*)");
  static const std::regex term(R"(([+-]?)\s*(\d*)(p?)(?:\^(\d+))?)");
  std::smatch parts;
  if (!std::regex_match(text, parts, whole)) return text.find('1') != std::string::npos ? 1.0 : NAN;
  double sum = 0;
  const std::string radial = parts[2];
  for (std::sregex_iterator it(radial.begin(), radial.end(), term), end; it != end; ++it) {
    const std::smatch& m = *it;
    if (m[2].length() == 0 && m[3].length() == 0) continue;
    const double factor = m[2].length() > 0 ? std::stod(m[2]) : 1.0;
    const int power = m[3].length() == 0 ? 0 : m[4].length() == 0 ? 1 : std::stoi(m[4]);
    sum += (m[1] == "-" ? -1 : 1) * factor * std::pow(p, power);
  }
  double harmonic = 1;
  if (parts[3].matched) {
    const int m = parts[4].length() == 0 ? 1 : std::stoi(parts[4]);
    harmonic = parts[3] == "SIN" ? std::sin(m * angle) : std::cos(m * angle);
  }
  return std::sqrt(std::stod(parts[1])) * sum * harmonic;
}

class Listings : public ::testing::Test {
 protected:
  Listings()
      : path_((std::filesystem::path(::testing::TempDir()) /
               (std::string("listing-") + ::testing::UnitTest::GetInstance()->current_test_info()->name() +
                std::to_string(::getpid())))
                  .string()) {}
  ~Listings() override { std::filesystem::remove(path_); }
  void put(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }

  template <class Reader>
  std::string refusal(Reader reader, const std::string& text) const {
    put(text);
    try {
      reader(path_);
    } catch (const InputError& e) {
      EXPECT_EQ(e.file(), path_);
      EXPECT_FALSE(e.found().empty());
      EXPECT_FALSE(e.allowed().empty());
      return e.what();
    }
    ADD_FAILURE() << "was read:\n" << text;
    return "";
  }

  std::string path_;
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// A damaged copy: bytes changed, dropped or doubled, lines swapped, or the end cut off.
std::string mutated(const std::string& text, std::uint64_t seed) {
  const RandomStream random(seed, "mutated-listing");
  std::string result = text;
  const std::uint64_t edits = 1 + random.bits(0) % 4;
  for (std::uint64_t k = 1; k <= edits && !result.empty(); ++k) {
    const std::size_t at = std::size_t(random.bits(10 * k) % result.size());
    const char byte = char(random.bits(10 * k + 1) % 256);
    const std::size_t length = std::size_t(random.bits(10 * k + 2) % 40);
    switch (random.bits(10 * k + 3) % 6) {
      case 0:
        result[at] = byte;
        break;
      case 1:
        result.erase(at, length);
        break;
      case 2:
        result.insert(at, 1, byte);
        break;
      case 3:
        result.insert(at, result.substr(at, length));
        break;
      case 4:
        result.resize(at);
        break;
      default: {  // a digit, a sign or an exponent where some number stands
        constexpr std::string_view kSpice = "0123456789-+eE.: \nZ!";
        result[at] = kSpice[std::size_t(random.bits(10 * k + 4) % kSpice.size())];
      }
    }
  }
  return result;
}

}  // namespace

TEST_F(Listings, PrintThePolynomialsAsOpticStudioDoes) {
  // The polynomials of OpticStudio's own listing, by index (HSC_Zernike.txt of batoid's tests).
  const std::map<int, std::string> known = {{1, "  1"},
                                            {2, "   4^(1/2) (p) * COS (A)"},
                                            {3, "   4^(1/2) (p) * SIN (A)"},
                                            {4, "   3^(1/2) (2p^2 - 1)"},
                                            {5, "   6^(1/2) (p^2) * SIN (2A)"},
                                            {6, "   6^(1/2) (p^2) * COS (2A)"},
                                            {7, "   8^(1/2) (3p^3 - 2p) * SIN (A)"},
                                            {8, "   8^(1/2) (3p^3 - 2p) * COS (A)"},
                                            {9, "   8^(1/2) (p^3) * SIN (3A)"},
                                            {12, "  10^(1/2) (4p^4 - 3p^2) * COS (2A)"},
                                            {17, "  12^(1/2) (10p^5 - 12p^3 + 3p) * SIN (A)"},
                                            {22, "   7^(1/2) (20p^6 - 30p^4 + 12p^2 - 1)"},
                                            {26, "  14^(1/2) (6p^6 - 5p^4) * COS (4A)"},
                                            {30, "  16^(1/2) (35p^7 - 60p^5 + 30p^3 - 4p) * COS (A)"},
                                            {37, "   9^(1/2) (70p^8 - 140p^6 + 90p^4 - 20p^2 + 1)"}};
  const auto listing = test::read_zernike_listing(Surface(20).text(ExportFormat::kZernikeNoll));
  ASSERT_EQ(listing.polynomials.size(), 231u);
  for (const auto& [j, polynomial] : known) {
    const std::string& printed = listing.polynomials[std::size_t(j - 1)];
    if (j == 1)
      EXPECT_EQ(printed.find_first_not_of(' '), printed.find('1'));
    else
      EXPECT_EQ(printed, polynomial) << j;
  }
}

TEST_F(Listings, HoldTheSurfaceByTheirPrintedPolynomials) {
  // The power sums of n = 12 lose 5 digits of 16 at the rim; rounding of 91 rows to 5e-13 waves is
  // negligible.
  constexpr double kTolerance = 1e-10;  // of the 0.5 um surface; largest seen 1e-12
  const Surface surface(12, {4, 6, 8, 10, 12});
  const auto listing = test::read_zernike_listing(surface.text(ExportFormat::kZernikeNoll));
  ASSERT_EQ(listing.waves.size(), 91u);
  double worst = 0, largest = 0;
  for (const auto& [x, y] : points()) {
    double waves = 0;
    for (std::size_t i = 0; i < listing.waves.size(); ++i)
      waves += listing.waves[i] *
               printed_polynomial(listing.polynomials[i], std::hypot(x, y) / kRadius, std::atan2(y, x));
    worst = std::max(worst, std::abs(waves * kWavelength - surface.height(x, y)));
    largest = std::max(largest, std::abs(surface.height(x, y)));
  }
  EXPECT_GT(largest, 100e-9);
  EXPECT_LT(worst / largest, kTolerance);
}

TEST_F(Listings, TellSineFromCosine) {
  // Term 8 is coma along x, 9 is trefoil with the sine; a swapped or mirrored order changes both.
  Surface surface(3);
  surface.coefficients.setZero();
  for (std::size_t i = 0; i < surface.terms.zernike.size(); ++i) {
    if (surface.terms.zernike[i] == ZernikeMode{3, 1})
      surface.coefficients[Eigen::Index(i)] = 2 * kWavelength;
    if (surface.terms.zernike[i] == ZernikeMode{3, -3}) surface.coefficients[Eigen::Index(i)] = -kWavelength;
  }
  const std::vector<double> waves =
      test::read_zernike_listing(surface.text(ExportFormat::kZernikeNoll)).waves;
  ASSERT_EQ(waves.size(), 10u);
  for (int j = 1; j <= 10; ++j) EXPECT_EQ(waves[std::size_t(j - 1)], j == 8 ? 2 : j == 9 ? -1 : 0) << j;

  // In Fringe order (3,1) is the 7th, (3,-3) the 11th (Wyant's table); peak-normalised by sqrt(8).
  put(surface.text(ExportFormat::kCodeVZfr));
  const std::vector<double> fringe = read_codev_zfr(path_);
  ASSERT_GE(fringe.size(), 11u);
  for (std::size_t j = 1; j <= fringe.size(); ++j)
    EXPECT_NEAR(fringe[j - 1],
                j == 7    ? 2 * std::sqrt(8.0) * kWavelength
                : j == 11 ? -std::sqrt(8.0) * kWavelength
                          : 0.0,
                1e-14 * kWavelength)
        << j;
}

TEST_F(Listings, ReadBackTheCoefficientsWithWavelengthAndRadius) {
  const Surface surface(20);
  const auto listing = test::read_zernike_listing(surface.text(ExportFormat::kZernikeNoll));
  EXPECT_NEAR(listing.wavelength, kWavelength, 1e-15 * kWavelength);
  EXPECT_NEAR(listing.radius, kRadius, 1e-15);
  ASSERT_EQ(listing.waves.size(), 231u);
  for (std::size_t i = 0; i < surface.terms.zernike.size(); ++i)  // 12 decimals of a wave
    EXPECT_NEAR(listing.waves[std::size_t(noll_index(surface.terms.zernike[i]) - 1)],
                surface.coefficients[Eigen::Index(i)] / kWavelength, 5.1e-13);
}

TEST_F(Listings, FringeFileHoldsTheSurface) {
  // Fringe order and polynomials are written out from the table of Wyant & Creath 1992, with R = 1 at the
  // rim.
  const auto polynomial = [](int j, double r, double a) {
    const double r2 = r * r;
    switch (j) {
      case 1:
        return 1.0;
      case 2:
        return r * std::cos(a);
      case 3:
        return r * std::sin(a);
      case 4:
        return 2 * r2 - 1;
      case 5:
        return r2 * std::cos(2 * a);
      case 6:
        return r2 * std::sin(2 * a);
      case 7:
        return (3 * r2 - 2) * r * std::cos(a);
      case 8:
        return (3 * r2 - 2) * r * std::sin(a);
      case 9:
        return 6 * r2 * r2 - 6 * r2 + 1;
      case 10:
        return r2 * r * std::cos(3 * a);
      case 11:
        return r2 * r * std::sin(3 * a);
      case 12:
        return (4 * r2 - 3) * r2 * std::cos(2 * a);
      case 13:
        return (4 * r2 - 3) * r2 * std::sin(2 * a);
      case 17:
        return r2 * r2 * std::cos(4 * a);
      case 18:
        return r2 * r2 * std::sin(4 * a);
      default:
        return 0.0;
    }
  };
  const Surface surface(4, {4});
  const std::string text = surface.text(ExportFormat::kCodeVZfr);
  std::istringstream lines(text);
  std::string line, word, kind;
  while (std::getline(lines, line) && line[0] == '!') EXPECT_LE(line.size(), 80u);
  EXPECT_EQ(line, "A mirror: its surface");
  std::getline(lines, line);
  std::istringstream header(line);
  int count = 0;
  double wvl = 0, ssz = 0;
  header >> word >> count >> kind;
  EXPECT_EQ(word, "ZFR");
  EXPECT_EQ(kind, "SUR");
  header >> word >> wvl;
  EXPECT_EQ(word, "WVL");
  EXPECT_NEAR(wvl, 0.6328, 1e-12);
  header >> word >> ssz;
  EXPECT_EQ(word, "SSZ");
  EXPECT_EQ(ssz, 1);
  std::vector<double> coefficients;
  for (double c; lines >> c;) coefficients.push_back(c);
  ASSERT_EQ(int(coefficients.size()), count);
  ASSERT_EQ(count, 18);
  for (const auto& [x, y] : points()) {
    double um = 0;
    for (int j = 1; j <= count; ++j)
      um += coefficients[std::size_t(j - 1)] * wvl / ssz *
            polynomial(j, std::hypot(x, y) / kRadius, std::atan2(y, x));
    EXPECT_NEAR(um * 1e-6, surface.height(x, y), 1e-20);  // 16 digits of 0.5 um over 18 terms
  }
}

TEST_F(Listings, FringeFileReadsBackToSixteenDigits) {
  const Surface surface(20);
  put(surface.text(ExportFormat::kCodeVZfr));
  const std::vector<double> fringe = read_codev_zfr(path_);
  ASSERT_EQ(fringe.size(), 402u);  // to (20,-20): 21^2 - 40 + 1
  std::vector<double> expected(fringe.size(), 0.0);
  for (std::size_t i = 0; i < surface.terms.zernike.size(); ++i) {
    const ZernikeMode mode = surface.terms.zernike[i];
    expected[std::size_t(fringe_index(mode) - 1)] =
        surface.coefficients[Eigen::Index(i)] * zernike_norm(mode);
  }
  for (std::size_t j = 0; j < fringe.size(); ++j) EXPECT_NEAR(fringe[j], expected[j], 1e-20) << j + 1;
}

TEST_F(Listings, RefuseWhatTheyCannotHold) {
  Surface waves(4);
  waves.terms.fourier = {{10, 3}};
  waves.coefficients.conservativeResize(waves.terms.size());
  waves.coefficients.tail(2).setConstant(1e-9);
  for (const ExportFormat format : {ExportFormat::kZernikeNoll, ExportFormat::kCodeVZfr}) {
    try {
      waves.text(format);
      ADD_FAILURE();
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find("zemax-grid-sag"), std::string::npos) << e.what();
    }
  }
  try {
    Surface(21).text(ExportFormat::kZernikeNoll);
    ADD_FAILURE();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("231"), std::string::npos) << e.what();
  }
  EXPECT_NO_THROW(Surface(21).text(ExportFormat::kCodeVZfr));
}

TEST_F(Listings, HeaderSaysWhatTheNumbersAre) {
  const std::string text = Surface(2).text(ExportFormat::kZernikeNoll);
  const std::string header = text.substr(0, text.find("\nZ   1"));
  for (const char* word :
       {"SURFACE", "not of the wavefront", "towards the incoming light", "twice", "0.6328 um", "150 mm",
        "unit RMS", "from +x towards +y", "\nQuantity                     :\tsurface sag in waves\n",
        "Listing of Zernike Standard Coefficient Data\n"})
    EXPECT_NE(header.find(word), std::string::npos) << word;
}

TEST_F(Listings, DamagedFringeFileIsAnInputError) {
  const std::string good = "! note\nTitle\nZFR 4 SUR WVL 0.5 SSZ 1\n0 0 0\n2\n";
  const auto says = [&](const std::string& text, const std::string& fragment) {
    EXPECT_NE(refusal(read_codev_zfr, text).find(fragment), std::string::npos)
        << refusal(read_codev_zfr, text);
  };
  put(good);
  EXPECT_DOUBLE_EQ(read_codev_zfr(path_)[3], 1e-6);
  put(replaced(good, "SUR", "wfr"));
  EXPECT_DOUBLE_EQ(read_codev_zfr(path_)[3], 0.5e-6);  // of the surface
  put(replaced(good, "SSZ 1", "SSZ 4"));
  EXPECT_DOUBLE_EQ(read_codev_zfr(path_)[3], 0.25e-6);
  put(replaced(replaced(good, "Title\n", "Title\r\n"), "SSZ 1\n", "SSZ 1\r\n"));
  EXPECT_DOUBLE_EQ(read_codev_zfr(path_)[3], 1e-6);
  says("", "title");
  says("! only\nTitle\n", "no header");
  says(replaced(good, "ZFR", "GRD"), "line 3");
  says(replaced(good, "ZFR 4", "ZFR 5"), "4 coefficients");
  says(replaced(good, "ZFR 4", "ZFR 3"), "line 5");
  says(replaced(good, "ZFR 4", "ZFR 0"), "1 ..");
  says(replaced(good, "ZFR 4", "ZFR 999999999"), "90601");
  says(replaced(good, "ZFR 4", "ZFR 99999999999"), "integer");
  says(replaced(good, "SUR", "FIL"), "SUR (surface) or WFR");
  says(replaced(good, "WVL 0.5", "WVL 0"), "WVL above 0");
  says(replaced(good, "WVL 0.5 ", ""), "WVL");
  says(replaced(good, "SSZ 1", "SSZ"), "SSZ");
  says(replaced(good, "SSZ 1", "SSZ -1"), "SSZ above 0");
  says(replaced(good, "SSZ 1", "WVL 1"), "WVL");
  says(replaced(good, "0 0 0", "0 x 0"), "\"x\"");
  says(replaced(good, "0 0 0", "0 nan 0"), "nan");
  says(replaced(good, "\n2\n", "\n1e308\n").replace(good.find("0.5"), 3, "1e30"), "in range");
  EXPECT_THROW(read_codev_zfr(path_ + "-missing"), InputError);
}

// A damaged file gives a valid answer or an InputError, and the same one twice.
TEST_F(Listings, FiveHundredMutatedFringeFilesAreReadOrRefused) {
  const Surface surface(6, {4});
  const std::string zfr = surface.text(ExportFormat::kCodeVZfr);
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    put(mutated(zfr, 1000 + seed));
    try {
      for (const double value : read_codev_zfr(path_)) EXPECT_TRUE(std::isfinite(value)) << seed;
    } catch (const InputError& e) {
      EXPECT_EQ(e.file(), path_);
      ++refused;
    }
  }
  // Most edits hit a number or the structure; one in a remark or a digit leaves a readable file.
  EXPECT_GT(refused, 150);
  EXPECT_LT(refused, 500);
}

}  // namespace aberfit
