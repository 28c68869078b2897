#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_map.h"
#include "map_mutation.h"
#include "map_samples.h"

namespace aberfit {
namespace {

using test::contains;
using test::refusal;
using test::ScratchFolder;
using Options = std::function<void(MeasuredSource*)>;

void surface(MeasuredSource* source) { source->wavefront = false; }

HeightMap read_bytes(const std::string& bytes, const Options& options = surface) {
  const ScratchFolder folder;
  MeasuredSource source;
  source.path = folder.write("a.fits", bytes);
  options(&source);
  return read_fits(source);
}

// A header of fixed-format cards, by the standard's own words: key, "= ", value right-aligned in column 30.
std::string header(const std::vector<std::pair<std::string, std::string>>& cards) {
  std::string text;
  for (const auto& [key, value] : cards) {
    std::string card = key + std::string(8 - key.size(), ' ') + "= ";
    card += value[0] == '\'' ? value : std::string(20 - std::min<std::size_t>(20, value.size()), ' ') + value;
    text += card + std::string(80 - card.size(), ' ');
  }
  text += "END" + std::string(77, ' ');
  return text + std::string((2880 - text.size() % 2880) % 2880, ' ');
}

using Cards = std::vector<std::pair<std::string, std::string>>;
Cards image_cards(int bits, int nx, int ny, const Cards& more = {{"BUNIT", "'nm      '"}}) {
  Cards cards = {{"SIMPLE", "T"},
                 {"BITPIX", std::to_string(bits)},
                 {"NAXIS", "2"},
                 {"NAXIS1", std::to_string(nx)},
                 {"NAXIS2", std::to_string(ny)}};
  cards.insert(cards.end(), more.begin(), more.end());
  return cards;
}

std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += char(value >> (8 * i));
  return text;
}
std::string value_bytes(double value, int bits) {
  if (bits == -32) return big_endian(std::bit_cast<std::uint32_t>(float(value)), 4);
  if (bits == -64) return big_endian(std::bit_cast<std::uint64_t>(value), 8);
  return big_endian(std::uint64_t(std::int64_t(value)), bits / 8);
}
std::string filled(std::string bytes) {
  return bytes + std::string((2880 - bytes.size() % 2880) % 2880, '\0');
}

// 3 columns, 2 rows: 1 2 3 below, 4 5 6 above.
std::string six(int bits, const Cards& more = {{"BUNIT", "'nm      '"}}) {
  std::string bytes = header(image_cards(bits, 3, 2, more));
  for (int i = 1; i <= 6; ++i) bytes += value_bytes(i, bits);
  return filled(bytes);
}

// What POPPY sees: the first image, its BUNIT and PIXELSCL; read card by card, not through CFITSIO.
struct Independent {
  std::map<std::string, std::string> keys;
  int columns = 0, rows = 0;
  std::vector<double> values;
  std::size_t end = 0;
  double at(int row, int column) const { return values[std::size_t(row * columns + column)]; }
};
Independent independent(const std::string& bytes) {
  Independent image;
  std::size_t at = 0;
  for (; bytes.compare(at, 80, "END" + std::string(77, ' ')) != 0; at += 80) {
    std::string key = bytes.substr(at, 8), value = bytes.substr(at + 10, 20);
    key.erase(key.find_last_not_of(' ') + 1);
    std::erase_if(value, [](char c) { return c == ' ' || c == '\''; });
    image.keys[key] = value;
  }
  at = (at + 80 + 2879) / 2880 * 2880;
  image.columns = std::stoi(image.keys["NAXIS1"]);
  image.rows = std::stoi(image.keys["NAXIS2"]);
  EXPECT_EQ(image.keys["BITPIX"], "-64");
  for (int i = 0; i < image.columns * image.rows; ++i, at += 8) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < 8; ++k) bits = bits << 8 | static_cast<unsigned char>(bytes[at + k]);
    image.values.push_back(std::bit_cast<double>(bits));
  }
  image.end = (at + 2879) / 2880 * 2880;
  return image;
}

TEST(Fits, ReadsEveryTypeOfPixelWithRowZeroBelow) {
  for (const int bits : {8, 16, 32, 64, -32, -64}) {
    const HeightMap map = read_bytes(six(bits));
    ASSERT_EQ(map.columns(), 3);
    ASSERT_EQ(map.rows(), 2);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(map.height(i / 3, i % 3), (i + 1) * 1e-9, 1e-22) << bits;
    EXPECT_EQ(map.pitch_x, 0);
  }
}

TEST(Fits, AppliesScaleZeroAndBlank) {
  const HeightMap map = read_bytes(
      six(16, {{"BSCALE", "0.5"}, {"BZERO", "10.0"}, {"BLANK", "4"}, {"BUNIT", "'um'"}, {"OBJECT", "'M3'"}}));
  EXPECT_NEAR(map.height(0, 2), 11.5e-6, 1e-18);
  EXPECT_TRUE(std::isnan(map.height(1, 0)));
  EXPECT_EQ(valid_count(map), 5);
  EXPECT_EQ(map.label, "M3");
  std::string bytes = header(image_cards(-64, 2, 1)) + value_bytes(std::nan(""), -64) + value_bytes(2, -64);
  EXPECT_TRUE(std::isnan(read_bytes(filled(bytes)).height(0, 0)));
}

TEST(Fits, OfAMaskIsReadWhateverItsHeaderSaysOfHeights) {
  const ScratchFolder folder;
  for (const Cards& cards :
       {Cards{}, Cards{{"BUNIT", "'furlong'"}}, Cards{{"BUNIT", "'waves'"}, {"MAPTYPE", "'amplitude'"}},
        Cards{{"MAPTYPE", "'wavefront'"}, {"PIXELSCL", "-1"}}}) {
    const Grid mask = read_mask(folder.write("mask.fits", six(16, cards)));
    ASSERT_EQ(mask.rows(), 2);
    ASSERT_EQ(mask.cols(), 3);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(mask(i / 3, i % 3), i + 1);
  }
}

TEST(Fits, KnowsTheUnitsOfBunit) {
  const std::map<std::string, double> units = {{"m", 1},
                                               {"meter", 1},
                                               {"Meters", 1},
                                               {"mm", 1e-3},
                                               {"um", 1e-6},
                                               {"micron", 1e-6},
                                               {"MICRONS", 1e-6},
                                               {"micrometers", 1e-6},
                                               {"nm", 1e-9},
                                               {"nanometer", 1e-9},
                                               {"nanometers", 1e-9},
                                               {"MM", 1e-3},
                                               {"Angstrom", 1e-10},
                                               {"angstroms", 1e-10}};
  for (const auto& [name, metres] : units)
    EXPECT_NEAR(read_bytes(six(16, {{"BUNIT", "'" + name + "'"}})).height(0, 1), 2 * metres, 1e-13 * metres)
        << name;
  EXPECT_NEAR(read_bytes(six(16, {{"Z_UNIT", "'meters'"}})).height(0, 1), 2, 1e-13);
  const InputError error = refusal([] { read_bytes(six(16, {{"BUNIT", "'furlong'"}})); });
  EXPECT_EQ(error.pointer(), "BUNIT");
  EXPECT_EQ(error.found(), "'furlong'");
}

TEST(Fits, RadiansNeedAWavelength) {
  const std::string bytes = six(16, {{"BUNIT", "'radians'"}});
  EXPECT_TRUE(contains(refusal([&] { read_bytes(bytes); }).allowed(), "option 'wavelength'"));
  const HeightMap map = read_bytes(bytes, [](MeasuredSource* s) {
    s->wavefront = true;
    s->wavelength = 500e-9;
  });
  // phase = 2 pi OPD / lambda, OPD = 2 h
  EXPECT_NEAR(4 * std::numbers::pi * map.height(1, 1) / 500e-9, 5, 1e-14);
}

TEST(Fits, WithoutBunitTheFactorIsAskedForAndUsed) {
  const InputError error = refusal([] { read_bytes(six(16, {})); });
  EXPECT_EQ(error.pointer(), "BUNIT");
  EXPECT_TRUE(contains(error.allowed(), "option 'value_unit'"));
  const auto factor = [](MeasuredSource* s) {
    s->wavefront = false;
    s->value_factor = 3e-9;
  };
  EXPECT_NEAR(read_bytes(six(16, {}), factor).height(0, 1), 6e-9, 1e-22);
  EXPECT_NEAR(read_bytes(six(16, {{"BUNIT", "'furlong'"}}), factor).height(0, 1), 6e-9, 1e-22);
}

TEST(Fits, AValueUnitThatContradictsBunitIsRefused) {
  const auto factor = [](MeasuredSource* s) { s->wavefront = false, s->value_factor = 1e-6; };
  EXPECT_EQ(refusal([&] { read_bytes(six(16), factor); }).pointer(), "option 'value_unit'");
  EXPECT_NEAR(read_bytes(six(16, {{"BUNIT", "'um'"}}), factor).height(0, 1), 2e-6, 1e-19);
}

TEST(Fits, AsksWhetherItIsAWavefrontAndHalvesIt) {
  const InputError error = refusal([] { read_bytes(six(16), [](MeasuredSource*) {}); });
  EXPECT_EQ(error.pointer(), "option 'of'");
  EXPECT_NEAR(read_bytes(six(16), [](MeasuredSource* s) { s->wavefront = true; }).height(1, 2), 3e-9, 1e-22);
}

// The words of PROPER's prop_writemap.
TEST(Fits, MaptypeSaysWhetherItIsAWavefront) {
  const auto typed = [](const std::string& type) {
    return six(16, {{"BUNIT", "'nm'"}, {"MAPTYPE", "'" + type + "'"}});
  };
  const auto open = [](MeasuredSource*) {};
  EXPECT_NEAR(read_bytes(typed("wavefront"), open).height(1, 2), 3e-9, 1e-22);
  EXPECT_NEAR(read_bytes(typed("mirror"), open).height(1, 2), 6e-9, 1e-22);
  EXPECT_NEAR(read_bytes(typed("SURFACE "), open).height(1, 2), 6e-9, 1e-22);
  EXPECT_EQ(refusal([&] { read_bytes(typed("amplitude"), open); }).pointer(), "MAPTYPE");
  EXPECT_EQ(refusal([&] { read_bytes(typed("amplitude"), surface); }).pointer(), "MAPTYPE");
  EXPECT_EQ(refusal([&] { read_bytes(typed("wavefront"), surface); }).pointer(), "option 'of'");
}

TEST(Fits, HeightsInWavesByTheOption) {
  const auto waves = [](MeasuredSource* s) {
    s->wavefront = false, s->value_in_waves = true, s->wavelength = 500e-9;
  };
  EXPECT_NEAR(read_bytes(six(16, {}), waves).height(1, 2), 6 * 500e-9, 1e-20);
  EXPECT_NEAR(read_bytes(six(16, {{"BUNIT", "'waves'"}}), waves).height(1, 2), 6 * 500e-9, 1e-20);
  EXPECT_EQ(refusal([&] { read_bytes(six(16), waves); }).pointer(), "option 'value_unit'");
}

TEST(Fits, FindsThePixelScale) {
  for (const char* key : {"PIXELSCL", "PUPLSCAL", "PIXSIZE"}) {
    const std::string bytes = six(16, {{"BUNIT", "'m'"}, {key, "0.00125"}});
    const HeightMap map = read_bytes(bytes);
    EXPECT_EQ(map.pitch_x, 0.00125) << key;
    EXPECT_EQ(map.x(0), -0.00125) << key;
    const auto with = [&](double p) {
      return read_bytes(bytes, [p](MeasuredSource* s) { s->wavefront = false, s->pitch = p; });
    };
    EXPECT_EQ(with(0.00125 * (1 + 5e-7)).pitch_y, 0.00125);
    EXPECT_EQ(refusal([&] { with(2); }).pointer(), "option 'pitch'");
  }
  EXPECT_EQ(refusal([] {
              read_bytes(six(16, {{"BUNIT", "'m'"}, {"PIXELSCL", "-1.0"}}));
            }).pointer(),
            "PIXELSCL");
  EXPECT_EQ(refusal([] {
              read_bytes(six(16, {{"BUNIT", "'m'"}, {"PIXELSCL", "'wide'"}}));
            }).pointer(),
            "PIXELSCL");
}

TEST(Fits, TakesTheFirstSliceOfACubeAndTheFirstImageOfAFile) {
  Cards cards = image_cards(8, 3, 2);
  cards[2].second = "3";
  cards.insert(cards.begin() + 5, {"NAXIS3", "2"});
  EXPECT_NEAR(read_bytes(filled(header(cards) + "\1\2\3\4\5\6\7\7\7\7\7\7")).height(1, 2), 6e-9, 1e-22);
  const std::string empty = header({{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "0"}, {"EXTEND", "T"}});
  const std::string table = filled(header({{"XTENSION", "'BINTABLE'"},
                                           {"BITPIX", "8"},
                                           {"NAXIS", "2"},
                                           {"NAXIS1", "4"},
                                           {"NAXIS2", "3"},
                                           {"PCOUNT", "5"},
                                           {"GCOUNT", "1"},
                                           {"TFIELDS", "1"},
                                           {"TFORM1", "'1J'"}}) +
                                   std::string(17, 'x'));
  Cards extension = image_cards(8, 3, 2);
  extension[0] = {"XTENSION", "'IMAGE   '"};
  extension.insert(extension.begin() + 5, {{"PCOUNT", "0"}, {"GCOUNT", "1"}});
  const std::string image = filled(header(extension) + "\1\2\3\4\5\6");
  EXPECT_NEAR(read_bytes(empty + table + image).height(1, 2), 6e-9, 1e-22);
  EXPECT_TRUE(contains(refusal([&] { read_bytes(empty + table); }).found(), "a table"));
  EXPECT_TRUE(contains(refusal([&] { read_bytes(empty); }).found(), "without image data"));
}

TEST(Fits, OnlyAMaskOfTheSameSizeMakesPointsInvalid) {
  const auto extension = [](const char* name, int nx, const std::string& data) {
    Cards cards = image_cards(8, nx, 2, {{"EXTNAME", name}});
    cards[0] = {"XTENSION", "'IMAGE   '"};
    cards.insert(cards.begin() + 5, {{"PCOUNT", "0"}, {"GCOUNT", "1"}});
    return filled(header(cards) + data);
  };
  const std::string mask = {1, 0, 1, 0, 1, 1};
  const std::string other = extension("'WEIGHT  '", 3, mask),
                    small = extension("'MASK    '", 2, {0, 0, 0, 0});
  EXPECT_EQ(valid_count(read_bytes(six(16) + other + small)), 6);
  const HeightMap map = read_bytes(six(16) + other + small + extension("'MASK    '", 3, mask));
  EXPECT_EQ(valid_count(map), 4);
  EXPECT_TRUE(std::isnan(map.height(0, 1)) && std::isnan(map.height(1, 0)));
  EXPECT_NEAR(map.height(1, 2), 6e-9, 1e-22);
}

TEST(Fits, ReadsAFileWhoseLastBlockIsNotFilled) {
  std::string bytes = header(image_cards(8, 3, 2)) + "\1\2\3\4\5\6";
  EXPECT_NEAR(read_bytes(bytes).height(1, 2), 6e-9, 1e-22);
  bytes.pop_back();
  EXPECT_TRUE(contains(refusal([&] { read_bytes(bytes); }).pointer(), "header 1"));
}

TEST(Fits, RefusesWhatItCannotReadAndSaysWhere) {
  const auto refused = [](const std::string& bytes) { return refusal([&] { read_bytes(bytes); }); };
  EXPECT_TRUE(contains(refused("\x1f\x8b and so on").found(), "gzip"));
  EXPECT_EQ(refused("").pointer(), "byte 0");
  EXPECT_EQ(refused("BITMAP").pointer(), "byte 0");
  EXPECT_TRUE(contains(refused(six(16).substr(0, 300)).found(), "before END"));
  for (const auto& [key, value, at] : {std::tuple{"NAXIS1", "-3", 3},
                                       {"NAXIS2", "99999999999", 4},
                                       {"NAXIS1", "9223372036854775807", 3},
                                       {"NAXIS1", "9223372036854775808", 3},
                                       {"NAXIS", "1000", 2},
                                       {"NAXIS", "-1", 2},
                                       {"BITPIX", "12", 1},
                                       {"BITPIX", "'x'", 1},
                                       {"SIMPLE", "F", 0}}) {
    Cards cards = image_cards(16, 3, 2);
    cards[std::size_t(at)].second = value;
    EXPECT_TRUE(contains(refused(filled(header(cards) + std::string(12, '\1'))).pointer(), key))
        << key << value;
  }
  // A product of axes that overflows 64 bits.
  EXPECT_TRUE(contains(refused(header(image_cards(8, 2000000000, 2000000000))).pointer(), "NAXIS"));
  EXPECT_EQ(refused(six(16, {{"BUNIT", "'m'"}, {"BSCALE", "0.0"}})).pointer(), "BSCALE");
  EXPECT_EQ(refused(six(16, {{"BUNIT", "'m'"}, {"BZERO", "'none'"}})).pointer(), "BZERO");
  const std::string compressed =
      header({{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "0"}}) + filled(header({{"XTENSION", "'BINTABLE'"},
                                                                                  {"BITPIX", "8"},
                                                                                  {"NAXIS", "2"},
                                                                                  {"NAXIS1", "8"},
                                                                                  {"NAXIS2", "1"},
                                                                                  {"PCOUNT", "0"},
                                                                                  {"GCOUNT", "1"},
                                                                                  {"TFIELDS", "1"},
                                                                                  {"ZIMAGE", "T"}}) +
                                                                          std::string(8, 'x'));
  EXPECT_TRUE(contains(refused(compressed).found(), "tile-compressed"));
  EXPECT_TRUE(contains(refused(compressed).allowed(), "funpack"));
}

// The standard wants END and keys at the begin of their cards. Who takes an indented END for one sees the
// data a block earlier than CFITSIO, which then read behind the end of what it was given.
TEST(Fits, OnlyWordsAtTheBeginOfACardCount) {
  const std::string end = "END" + std::string(77, ' '), indented = "  END" + std::string(75, ' ');
  const auto longer = [&](std::string file) {
    file.replace(file.find(end), end.size(), indented);
    return file.insert(2880, end + std::string(2880 - end.size(), ' '));
  };
  EXPECT_TRUE(
      contains(refusal([&] { read_bytes(longer(header(image_cards(16, 3, 2)))); }).pointer(), "NAXIS"));
  const HeightMap map = read_bytes(longer(six(16)));
  for (Eigen::Index i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(map.height.data()[i], 1e-9 * double(i + 1));
  // An indented key is none either, before or behind the one that is.
  std::string other = six(16, {{"BUNIT", "'nm'"}, {"WHATEVER", "1"}});
  other.replace(other.find("WHATEVER"), 8, " NAXIS2 ");
  EXPECT_EQ(read_bytes(other).rows(), 2);
}

TEST(Fits, FileNamesAreOnlyNames) {
  // To CFITSIO these would be an extension, a filter, a compressed copy and a second file.
  const ScratchFolder folder;
  for (const char* name : {"a.fits[1]", "b.fits[0:1,0:1]", "c.fits(mem)", "!d.fits", "-", "e.fits+1"}) {
    MeasuredSource source;
    source.path = folder.write(name, six(16));
    source.wavefront = false;
    EXPECT_NEAR(read_fits(source).height(0, 0), 1e-9, 1e-22) << name;
  }
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(folder.file("x")).parent_path()))
    ++files;
  EXPECT_EQ(files, 6u);
}

TEST(Fits, WritesWhatPoppyLoadsAndReadsItBack) {
  for (const double offset : {0.0, 1e-6, -1e-6})
    for (const auto& [rows, columns] : {std::pair{5, 9}, std::pair{12, 7}, std::pair{8, 8}}) {
      const HeightMap map = test::marker_map(rows, columns, 1.25e-3, offset);
      const std::string bytes = fits_opd_bytes(map);
      EXPECT_EQ(bytes.size() % 2880, 0u);
      const Independent image = independent(bytes);
      const int side = std::max(rows, columns);
      ASSERT_EQ(image.columns, side);  // POPPY wants a square
      ASSERT_EQ(image.rows, side);
      EXPECT_EQ(image.keys.at("BUNIT"), "meter");
      EXPECT_EQ(std::stod(image.keys.at("PIXELSCL")), 1.25e-3);
      const int row0 = (side - rows) / 2, column0 = (side - columns) / 2;
      const HeightMap read = read_bytes(bytes, [](MeasuredSource* s) { s->wavefront = true; });
      EXPECT_EQ(read.pitch_x, 1.25e-3);
      for (int r = 0; r < side; ++r)
        for (int c = 0; c < side; ++c) {
          const int mr = r - row0, mc = c - column0;
          const bool inside =
              mr >= 0 && mr < rows && mc >= 0 && mc < columns && std::isfinite(map.height(mr, mc));
          const double h = inside ? map.height(mr, mc) : 0;
          ASSERT_EQ(image.at(r, c), 2 * h) << r << " " << c;  // optical path: twice the surface
          // The mask makes holes and padding invalid again.
          ASSERT_EQ(std::isfinite(read.height(r, c)), inside) << r << " " << c;
          ASSERT_EQ(inside ? read.height(r, c) : 0, h) << r << " " << c;
          // The mask follows as a second image of bytes: one header block, then its data.
          ASSERT_EQ(bytes[image.end + 2880 + std::size_t(r * side + c)], inside ? 1 : 0);
        }
    }
}

TEST(Fits, WriterRefusesAMapWithoutOnePitch) {
  HeightMap map = test::marker_map(5, 6, 1e-3);
  map.pitch_y = 2e-3;
  EXPECT_THROW(fits_opd_bytes(map), std::invalid_argument);
  map.pitch_x = 0;
  EXPECT_THROW(fits_opd_bytes(map), std::invalid_argument);
}

TEST(Fits, DamagedFilesAreRefusedOrReadNeverACrash) {
  const auto read = [](const std::string& path) {
    MeasuredSource source;
    source.path = path;
    source.wavefront = true;
    return read_fits(source);
  };
  const auto written =
      test::read_damaged(fits_opd_bytes(test::marker_map(6, 7, 1e-3)), 800, "fits written", 1400, read);
  EXPECT_GT(written.refused, 300);
  EXPECT_GT(written.read, 100);
  // Behind an empty primary header and with scaled integers.
  Cards extension = image_cards(16, 3, 2, {{"BSCALE", "0.5"}, {"BLANK", "4"}, {"BUNIT", "'nm'"}});
  extension[0] = {"XTENSION", "'IMAGE   '"};
  extension.insert(extension.begin() + 5, {{"PCOUNT", "0"}, {"GCOUNT", "1"}});
  const std::string second = header({{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "0"}, {"EXTEND", "T"}}) +
                             filled(header(extension) + std::string("\0\1\0\2\0\3\0\4\0\5\0\6", 12));
  const auto nested = test::read_damaged(second, 2880 + 800, "fits extension", 1400, read);
  EXPECT_GT(nested.refused, 300);
  EXPECT_GT(nested.read, 100);
}

}  // namespace
}  // namespace aberfit
