// Tests against files of an independent writer (write_instrument_files.py), and a measured one if available.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "map_mutation.h"
#include "shared_data.h"

namespace aberfit {
namespace {

using test::contains;
using test::instrument_file;
using test::InstrumentsOnRealData;
using test::map_source;
using test::refusal;
using test::replaced;
using test::ScratchFolder;
using test::with_number;

const std::string kFloats = instrument_file("marker-float.opd"),
                  kCounts = instrument_file("marker-counts.opd");

TEST(Opd, ReadsFloatsByColumnsFromTheLowestPointUpwards) {
  const HeightMap map = read_opd(map_source(kFloats));
  test::expect_marker(map, 1e-14);  // rounding to single precision, 6e-8 of 50 nm
  EXPECT_EQ(map.label, "marker");
}

TEST(Opd, ReadsCountsOfTheArrayThatTheFileNamesAsItsMainOne) {
  // The array OPD comes first but is not the primary one.
  const double half_a_count = 0.5 * 632.8e-9 / 20000;
  test::expect_marker(read_opd(map_source(kCounts)), 1.001 * half_a_count);
  const ScratchFolder folder;
  const std::string unnamed = replaced(test::read_file(kCounts), "PrimaryData2D", "PrimaryDataXX");
  EXPECT_NEAR(read_opd(map_source(folder.write("a.opd", unnamed))).height(0, 1), 7 * 2 * half_a_count, 1e-15);
}

TEST(Opd, TakesFromTheOptionsOnlyWhatTheFileDoesNotSay) {
  const ScratchFolder folder;
  const std::string bytes = test::read_file(kFloats);
  MeasuredSource source = map_source(folder.write("a.opd", replaced(bytes, "Pixel_size", "Pixel_sizX")));
  EXPECT_EQ(read_opd(source).pitch_x, 0);
  source.pitch = 2e-3;
  EXPECT_EQ(read_opd(source).pitch_x, 2e-3);
  EXPECT_NEAR(read_opd(source).pitch_y, 4e-3, 1e-9);  // the file contains the aspect of a pixel
  source = map_source(folder.write("a.opd", replaced(bytes, "Wavelength", "Wavelengtx")));
  InputError error = refusal([&] { read_opd(source); });
  EXPECT_EQ(error.pointer(), "Wavelength");
  EXPECT_TRUE(contains(error.allowed(), "option 'wavelength'"));
  source.wavelength = 632.8e-9;
  test::expect_marker(read_opd(source), 1e-14);
  source = map_source(kFloats);
  source.pitch = 2e-3;
  EXPECT_EQ(refusal([&] { read_opd(source); }).pointer(), "option 'pitch'");
  source = map_source(kFloats);
  source.wavelength = 500e-9;
  EXPECT_EQ(refusal([&] { read_opd(source); }).pointer(), "option 'wavelength'");
  source = map_source(kFloats);
  source.value_factor = 1e-9;
  EXPECT_EQ(refusal([&] { read_opd(source); }).pointer(), "option 'value_unit'");
  source = map_source(kFloats);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_opd(source); }).pointer(), "option 'of'");
}

TEST(Opd, RefusesWhatItCannotReadAndSaysWhere) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& bytes) {
    const std::string path = folder.write("a.opd", bytes);
    const InputError error = refusal([&] { read_opd(map_source(path)); });
    EXPECT_EQ(error.file(), path);
    return error;
  };
  const std::string bytes = test::read_file(kFloats);
  // Records: directory at 2, then Wavelength, Aspect, Pixel_size, Image, Raw, Title.
  const auto record = [](std::size_t i) { return 2 + 24 * i; };
  const std::size_t raw = bytes.find("Raw"), array = 2 + 24 * 8 + 3 * 4 + 6 + 108;
  ASSERT_EQ(raw, record(5));
  EXPECT_EQ(refused("\x01" + bytes.substr(1, 20) + "x").pointer(), "byte 0");
  EXPECT_EQ(refused(with_number(bytes, 0, std::uint16_t(2))).pointer(), "byte 0");
  EXPECT_EQ(refused(with_number(bytes, 20, std::uint32_t(193))).pointer(), "byte 20");
  EXPECT_EQ(refused(with_number(bytes, 20, std::uint32_t(0xfffffff0))).pointer(), "byte 20");
  EXPECT_EQ(refused(with_number(bytes, raw + 18, std::uint32_t(0xffffffff))).pointer(), "byte 122");
  EXPECT_EQ(refused(with_number(bytes, raw + 16, std::uint16_t(5))).pointer(), "byte 122");
  EXPECT_EQ(refused(with_number(bytes, record(1) + 16, std::uint16_t(6))).pointer(), "byte 26");
  EXPECT_EQ(refused(replaced(bytes, "Raw", "Rww")).pointer(), "byte 2");
  EXPECT_EQ(refused(with_number(bytes, array, std::uint16_t(0))).pointer(), fmt::format("byte {}", array));
  EXPECT_EQ(refused(with_number(bytes, array, std::uint16_t(13))).pointer(),
            "byte 122");  // one column too many
  EXPECT_EQ(refused(with_number(bytes, array + 4, std::uint16_t(1))).pointer(),
            fmt::format("byte {}", array + 4));
  EXPECT_EQ(refused(with_number(bytes, 2 + 24 * 8 + 4, 0.0f)).pointer(), "Aspect");
  EXPECT_EQ(refused(with_number(bytes, 2 + 24 * 8, 0.6328f)).pointer(), "Wavelength");  // micrometres
  const std::string counts = test::read_file(kCounts);
  const std::size_t mult = counts.find(std::string("\x20\x4e", 2), 2 + 24 * 9);  // 20000
  EXPECT_EQ(refused(with_number(counts, mult, std::int16_t(0))).pointer(), "Mult");
  for (const std::size_t length : {std::size_t(0), std::size_t(20), std::size_t(100), bytes.size() - 1})
    refused(bytes.substr(0, length));
  refusal([&] { read_opd(map_source(folder.file("missing.opd"))); });
}

TEST(Opd, DamagedFilesAreRefusedOrReadNeverACrash) {
  for (const std::string& path : {kFloats, kCounts}) {
    const auto count =
        test::read_damaged(test::read_file(path), 230, "opd", 700,
                           [](const std::string& damaged) { return read_opd(map_source(damaged)); });
    EXPECT_GT(count.refused, 200);
    EXPECT_GT(count.read, 50);
  }
}

TEST_F(InstrumentsOnRealData, OpdHasTheSizeAndTheFactorThatAreKnown) {
  MeasuredSource source = map_source(file("opd-1.opd"));
  const HeightMap map = std::get<HeightMap>(read_measurement(source));
  EXPECT_EQ(map.columns(), 640);
  EXPECT_EQ(map.rows(), 480);
  EXPECT_NEAR(640 * map.pitch_x, 0.125909140e-3, 1e-12);
  EXPECT_NEAR(480 * map.pitch_y, 0.094431855e-3, 1e-12);
  // Heights are 0.000577295 mm times the floats, whose 1228800 bytes start 6 bytes after byte 24020.
  const std::string bytes = test::read_file(source.path);
  float value = 0;
  Eigen::Index holes = 0;
  for (Eigen::Index column = 0; column < 640; ++column)
    for (Eigen::Index row = 0; row < 480; ++row) {
      std::memcpy(&value, bytes.data() + 24026 + 4 * (column * 480 + row), 4);
      if (value < 1e38f)
        ASSERT_NEAR(map.height(row, column), 0.0005772949829101563e-3 * double(value), 1e-15);
      else
        holes += std::isnan(map.height(row, column));
    }
  EXPECT_EQ(holes, 116);
}

}  // namespace
}  // namespace aberfit
