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
#include "packed_files.h"

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

// A header of fixed-format cards as in the standard: key, "= ", value right-aligned in column 30.
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

// A second reader, without CFITSIO, of what POPPY uses: the first image, its BUNIT and PIXELSCL.
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

// PROPER's prop_writemap writes these words.
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

// Other words describe the origin of the map rather than its values.
TEST(Fits, AMaptypeOfOtherWordsLeavesItToTheOption) {
  for (const char* type : {"measured", "synthetic", "Mirror map", "WFE", ""}) {
    const std::string bytes = six(16, {{"BUNIT", "'nm'"}, {"MAPTYPE", "'" + std::string(type) + "'"}});
    EXPECT_NEAR(read_bytes(bytes).height(1, 2), 6e-9, 1e-22) << type;
    EXPECT_NEAR(read_bytes(bytes, [](MeasuredSource* s) { s->wavefront = true; }).height(1, 2), 3e-9, 1e-22);
    const InputError error = refusal([&] { read_bytes(bytes, [](MeasuredSource*) {}); });
    EXPECT_EQ(error.pointer(), "option 'of'") << type;
    EXPECT_TRUE(contains(error.found(), type)) << error.found();
  }
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

// The standard's axes; their steps have their own unit.
TEST(Fits, TakesThePitchFromTheAxesWhereTheyAreLengths) {
  const auto with = [](Cards cards) {
    cards.insert(cards.begin(), {"BUNIT", "'nm'"});
    return read_bytes(six(16, cards));
  };
  const Cards millimetres = {{"CDELT1", "1.5"}, {"CUNIT1", "'mm'"}, {"CDELT2", "2.5"}, {"CUNIT2", "'mm'"}};
  EXPECT_DOUBLE_EQ(with(millimetres).pitch_x, 1.5e-3);
  EXPECT_DOUBLE_EQ(with(millimetres).pitch_y, 2.5e-3);
  EXPECT_DOUBLE_EQ(with(millimetres).x(0), -1.5e-3);
  const HeightMap matrix =
      with({{"CD1_1", "20.0"}, {"CD2_2", "30.0"}, {"CUNIT1", "'um'"}, {"CUNIT2", "'micron'"}});
  EXPECT_DOUBLE_EQ(matrix.pitch_x, 20e-6);
  EXPECT_DOUBLE_EQ(matrix.pitch_y, 30e-6);
  // The axes run to the left and downwards.
  const HeightMap left = with({{"CDELT1", "-1.0"}, {"CUNIT1", "'m'"}, {"CDELT2", "-1.0"}, {"CUNIT2", "'m'"}});
  EXPECT_EQ(left.pitch_x, 1);
  EXPECT_NEAR(left.height(0, 0), 6e-9, 1e-22);
  EXPECT_NEAR(left.height(1, 2), 1e-9, 1e-22);
  // Axes on the sky, without a unit, or rotated give no pitch.
  EXPECT_EQ(with({{"CDELT1", "-1.0"}, {"CUNIT1", "'deg'"}, {"CDELT2", "1.0"}, {"CUNIT2", "'deg'"}}).pitch_x,
            0);
  EXPECT_EQ(with({{"CDELT1", "1.0"}, {"CDELT2", "1.0"}}).pitch_x, 0);
  EXPECT_EQ(with({{"CD1_1", "1.0"}, {"CD1_2", "0.5"}, {"CUNIT1", "'mm'"}}).pitch_x, 0);
  // Keys of POPPY and PROPER have precedence.
  Cards both = millimetres;
  both.push_back({"PIXSIZE", "0.004"});
  EXPECT_EQ(with(both).pitch_y, 0.004);
}

TEST(Fits, AsksForThePlaneOfACube) {
  Cards cards = image_cards(8, 3, 2);
  cards[2].second = "4";
  cards.insert(cards.begin() + 5, {{"NAXIS3", "2"}, {"NAXIS4", "2"}});
  std::string cube = header(cards);
  for (char i = 0; i < 24; ++i) cube += char(i + 1);
  const auto plane = [&](int k) {
    return read_bytes(filled(cube), [k](MeasuredSource* s) { s->wavefront = false, s->plane = k; });
  };
  for (int k = 1; k <= 4; ++k) EXPECT_NEAR(plane(k).height(1, 2), 6 * k * 1e-9, 1e-22) << k;
  const InputError error = refusal([&] { read_bytes(filled(cube)); });
  EXPECT_TRUE(contains(error.found(), "4 planes")) << error.what();
  EXPECT_TRUE(contains(error.allowed(), "option 'plane'")) << error.what();
  for (const int k : {0, -1, 5}) EXPECT_EQ(refusal([&] { plane(k); }).pointer(), "option 'plane'");
  // With a single plane the option is not needed.
  cards[5].second = "1", cards[6].second = "1";
  EXPECT_NEAR(read_bytes(filled(header(cards) + "\1\2\3\4\5\6")).height(1, 2), 6e-9, 1e-22);
}

// An extension of bytes: `first` and the numbers that follow it.
std::string image_extension(const std::string& name, char first, const Cards& more = {}) {
  Cards cards = image_cards(8, 3, 2, more);
  cards[0] = {"XTENSION", "'IMAGE   '"};
  cards.insert(cards.begin() + 5, {{"PCOUNT", "0"}, {"GCOUNT", "1"}});
  if (!name.empty()) cards.push_back({"EXTNAME", "'" + name + "'"});
  std::string bytes = header(cards);
  for (char i = 0; i < 6; ++i) bytes += char(first + i);
  return filled(bytes);
}
const Cards kNanometres = {{"BUNIT", "'nm'"}};

TEST(Fits, TakesTheOnlyImageWhateverElseIsInTheFile) {
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
  const HeightMap map = read_bytes(empty + table + image_extension("", 1, kNanometres));
  EXPECT_NEAR(map.height(1, 2), 6e-9, 1e-22);
  EXPECT_TRUE(map.warnings.empty());
  EXPECT_TRUE(contains(refusal([&] { read_bytes(empty + table); }).found(), "a table"));
  EXPECT_TRUE(contains(refusal([&] { read_bytes(empty); }).found(), "without image data"));
}

TEST(Fits, OfSeveralImagesTheOnlyOneWithAUnitOfHeightsIsReadAndSaysSo) {
  struct Case {
    std::string bytes;
    double first;  // [nm]
    const char* said;
  };
  const std::string none = six(8, {});
  for (const Case& c :
       {Case{none + image_extension("OPD", 11, kNanometres), 11, "hdu 1 is read"},
        {six(8) + image_extension("WEIGHT", 11), 1, "hdu 0 is read"},
        // Counts are not heights.
        {six(8, {{"BUNIT", "'adu'"}}) + image_extension("", 11) + image_extension("M1", 21, kNanometres), 21,
         "hdu 2 is read"}}) {
    const HeightMap map = read_bytes(c.bytes);
    EXPECT_NEAR(map.height(0, 0), c.first * 1e-9, 1e-21) << c.said;
    ASSERT_EQ(map.warnings.size(), 1u);
    EXPECT_EQ(map.warnings[0].code, "image-chosen");
    EXPECT_TRUE(contains(map.warnings[0].message, c.said)) << map.warnings[0].message;
  }
  // A mask is not a candidate for the image of heights.
  EXPECT_TRUE(read_bytes(six(8) + image_extension("MASK", 1)).warnings.empty());
}

TEST(Fits, OtherwiseAsksWhichImageAndTakesTheOneThatIsNamed) {
  const std::string bytes = six(8) + image_extension("M1", 11, kNanometres) +
                            image_extension("2", 21, {{"BUNIT", "'um'"}}) + image_extension("MASK", 0);
  const auto named = [&](const std::string& hdu) {
    return read_bytes(bytes, [&](MeasuredSource* s) { s->wavefront = false, s->hdu = hdu; });
  };
  EXPECT_NEAR(named("0").height(1, 2), 6e-9, 1e-21);
  EXPECT_NEAR(named("1").height(1, 2), 16e-9, 1e-21);
  EXPECT_NEAR(named("m1").height(1, 2), 16e-9, 1e-21);
  EXPECT_NEAR(named("2").height(1, 2), 26e-6, 1e-18);
  EXPECT_TRUE(std::isnan(named("M1").height(0, 0)));  // the mask applies to all images of its size
  const InputError error = refusal([&] { read_bytes(bytes); });
  EXPECT_EQ(error.found(), "images 0 (3 x 2, nm), 1 'M1' (3 x 2, nm), 2 '2' (3 x 2, um)");
  EXPECT_TRUE(contains(error.allowed(), "option 'hdu'"));
  for (const char* wrong : {"7", "-1", "M2", "1.0"})
    EXPECT_TRUE(contains(refusal([&] { named(wrong); }).allowed(), "1 'M1' (3 x 2, nm)")) << wrong;
  const std::string twice = six(8, {}) + image_extension("A", 1) + image_extension("A", 1);
  EXPECT_TRUE(contains(refusal([&] {
                         read_bytes(twice, [](MeasuredSource* s) { s->wavefront = false, s->hdu = "A"; });
                       }).found(),
                       "2 images named 'A'"));
  // All missing options are listed together.
  const ScratchFolder folder;
  MeasuredSource source;
  source.path = folder.write("a.fits", twice);
  EXPECT_EQ(missing_facts(source), (std::vector<std::string>{"hdu", "of", "value_unit", "pitch"}));
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
  EXPECT_TRUE(contains(refusal([&] { read_bytes(bytes); }).pointer(), "hdu 0"));
}

TEST(Fits, RefusesWhatItCannotReadAndSaysWhere) {
  const auto refused = [](const std::string& bytes) { return refusal([&] { read_bytes(bytes); }); };
  EXPECT_EQ(refused("\x1f\x8b and so on").pointer(), "byte 2");
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
  // The product of the axes overflows 64 bits.
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

// The standard requires END and keys at the beginning of their cards. A reader that accepts an indented END
// finds the data one block earlier than CFITSIO, which would then read beyond its buffer.
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
  // An indented key does not count either, before or after the real one.
  std::string other = six(16, {{"BUNIT", "'nm'"}, {"WHATEVER", "1"}});
  other.replace(other.find("WHATEVER"), 8, " NAXIS2 ");
  EXPECT_EQ(read_bytes(other).rows(), 2);
}

TEST(Fits, FileNamesAreOnlyNames) {
  // For CFITSIO these would be an extension, a filter, a compressed copy and a second file.
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
      ASSERT_EQ(image.columns, side);  // POPPY requires a square
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

// The file states that it is a wavefront, and its unit and pitch.
TEST(Fits, WhatIsWrittenIsReadBackWithoutOptions) {
  const ScratchFolder folder;
  for (const auto& [rows, columns] : {std::pair{5, 9}, std::pair{12, 7}, std::pair{8, 8}}) {
    const HeightMap map = test::marker_map(rows, columns, 1.25e-3);
    MeasuredSource source;
    source.path = folder.write("opd.fits", fits_opd_bytes(map));
    EXPECT_TRUE(missing_facts(source).empty());
    const HeightMap read = std::get<HeightMap>(read_measurement(source));
    EXPECT_EQ(read.pitch_x, map.pitch_x);
    EXPECT_EQ(read.label, map.label);
    EXPECT_TRUE(read.warnings.empty());
    const int side = std::max(rows, columns), row0 = (side - rows) / 2, column0 = (side - columns) / 2;
    HeightMap inner = map;
    inner.height = read.height.block(row0, column0, rows, columns);
    test::expect_same_map(inner, map, 0);
    EXPECT_EQ(valid_count(read), valid_count(map));
    // A contradicting option is refused.
    source.wavefront = false;
    EXPECT_EQ(refusal([&] { read_measurement(source); }).pointer(), "option 'of'");
  }
}

TEST(Fits, ReadsWhatGzipPacked) {
  const ScratchFolder folder;
  // Written by astropy, packed by Python's gzip with a name in the header: 3 x 2 integers of 16 bits, 1 to 6.
  const std::string packed =
      "1f8b08080000000002ff6d61702e6669747300edd1bd6e8330188561f727bd8e6f634b482a65cb00ad23592208"
      "095722a3534062b01d193ae4ee4ba93205a7a251b6f38c1e5e1ddbb9d8650927dad008490bfab4a6b64eb7d459"
      "da0a9953db29532a57d2a858c84c14e3bde5baef29e7d4894ad529ea4ec78afe904685c8c9b36fd5f7cc973e54"
      "8e6c7d2e37ba326d634debef2d3dbd579a6ce8adbcfb26e385e4e9bbf73f268b3f522187f70b8cfe3d0ae806fd"
      "e7f2247f4b2ef685f330fcc77d775126f719ffd9a71be7acbb71dff0780000000077c41ed8237b62cf6cc65e18"
      "00000000005cf50d5abfd5f180160000";
  std::string bytes;
  for (std::size_t i = 0; i < packed.size(); i += 2)
    bytes += char(std::stoi(packed.substr(i, 2), nullptr, 16));
  for (const std::string& content :
       {bytes, test::gzip_of(six(16, {{"BUNIT", "'nm'"}, {"PIXELSCL", "0.002"}})),
        test::gzip_of(six(-64, {{"BUNIT", "'nm'"}, {"PIXSIZE", "0.002"}}), "a")}) {
    MeasuredSource source;
    source.path = folder.write("map.fits.gz", content);
    EXPECT_EQ(detect_format(source.path), MeasuredFormat::kFits);
    source.wavefront = false;
    const HeightMap map = std::get<HeightMap>(read_measurement(source));
    EXPECT_EQ(map.pitch_x, 0.002);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(map.height(i / 3, i % 3), (i + 1) * 1e-9, 1e-22);
    EXPECT_EQ(read_mask(source.path)(1, 2), 6);
  }
  const auto refused = [](const std::string& content) { return refusal([&] { read_bytes(content); }); };
  EXPECT_TRUE(contains(refused(test::gzip_of("x,y\n1,2\n")).found(), "content is not a FITS file"));
  std::string spoilt = test::gzip_of(six(16));
  spoilt[spoilt.size() - 20] ^= 1;
  EXPECT_TRUE(contains(refused(spoilt).found(), "CRC"));
  refused(bytes.substr(0, bytes.size() / 2));
  // A few bytes claim to be four gigabytes.
  EXPECT_TRUE(
      contains(refused(bytes.substr(0, bytes.size() - 4) + "\xff\xff\xff\xf0").found(), "4043309055"));
  const auto read = [](const std::string& path) {
    MeasuredSource source;
    source.path = path;
    return read_fits(source);
  };
  EXPECT_GT(test::read_damaged(bytes, 40, "fits gzip", 300,
                               [&](const std::string& path) {
                                 HeightMap map = read(path);
                                 map.height.resize(1, 1);  // an unpacked map may be larger than its file
                                 return map;
                               })
                .refused,
            100);
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
  // The image follows an empty primary header and has scaled integers.
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
