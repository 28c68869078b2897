// Tests against files of an independent writer (write_instrument_files.py) and the standard's example.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
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

const std::string kText = instrument_file("marker-text.sdf"), kIso1 = instrument_file("marker-iso1.sdf"),
                  kIso2 = instrument_file("marker-iso2.sdf"), kBcr = instrument_file("marker-bcr.sdf");

// Positions in the binary header.
constexpr std::size_t kPoints = 42, kXscale = 46, kZscale = 62, kCompression = 78, kDataType = 79,
                      kCheckType = 80, kFirst = 81;

TEST(Sdf, ReadsTextAndBinaryOfIsoUpwardsAndOfBcrDownwards) {
  test::expect_marker(read_sdf(map_source(kText)), 1e-18);
  test::expect_marker(read_sdf(map_source(kIso2)), 1e-22);
  constexpr double kHalfACount = 2e-12;
  test::expect_marker(read_sdf(map_source(kIso1)), 1.001 * kHalfACount);
  test::expect_marker(read_sdf(map_source(kBcr)), 1.001 * kHalfACount);
  EXPECT_EQ(read_sdf(map_source(kText)).label, "aberfit");
  EXPECT_EQ(read_sdf(map_source(kBcr)).label, "aberfit");
}

// A 2 x 2 file with given values.
template <class Number>
Grid two_by_two(const ScratchFolder& folder, const std::string& version, std::uint8_t type,
                const std::vector<Number>& values) {
  std::string bytes = replaced(test::read_file(kIso1).substr(0, kFirst), "bISO-1.0", version);
  bytes = with_number(with_number(bytes, kPoints, std::uint16_t(2)), kPoints + 2, std::uint16_t(2));
  bytes = with_number(with_number(bytes, kDataType, type), kZscale, 1e-9);
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
  return read_sdf(map_source(folder.write("a.sdf", bytes))).height;
}

template <class Number>
void expect_type(std::uint8_t type) {
  SCOPED_TRACE(int(type));
  const ScratchFolder folder;
  using Limits = std::numeric_limits<Number>;
  const std::vector<Number> values = {Number(1), Number(100), Limits::lowest(), Limits::max()};
  const Grid bcr = two_by_two(folder, "bBCR-1.0", type, values);
  EXPECT_NEAR(bcr(1, 0), 1e-9, 1e-20);
  EXPECT_NEAR(bcr(1, 1), 100e-9, 1e-20);
  EXPECT_TRUE(std::isnan(bcr(0, 1)));  // the highest number is no data, the lowest one is a height
  EXPECT_NEAR(bcr(0, 0) / (double(values[2]) * 1e-9 + 1e-30), values[2] == 0 ? 0 : 1, 1e-9);
  if (type < 3) {
    EXPECT_EQ(refusal([&] { two_by_two(folder, "bISO-1.0", type, values); }).pointer(), "DataType");
  } else {
    const Grid iso = two_by_two(folder, "bISO-1.0", type, values);
    EXPECT_NEAR(iso(0, 1), 100e-9, 1e-20);
    EXPECT_TRUE(std::isnan(iso(1, 0)));
    EXPECT_NEAR(iso(1, 1) / (double(values[3]) * 1e-9), 1, 1e-9);
  }
}

TEST(Sdf, ReadsEveryTypeWithItsMarkOfNoData) {
  expect_type<std::uint8_t>(0);
  expect_type<std::uint16_t>(1);
  expect_type<std::uint32_t>(2);
  expect_type<float>(3);
  expect_type<std::int8_t>(4);
  expect_type<std::int16_t>(5);
  expect_type<std::int32_t>(6);
  expect_type<double>(7);
}

TEST(Sdf, TakesFromTheOptionsOnlyWhatTheFileDoesNotSay) {
  const ScratchFolder folder;
  const std::string bytes = test::read_file(kIso1);
  MeasuredSource source =
      map_source(folder.write("a.sdf", with_number(with_number(bytes, kXscale, 0.0), kXscale + 8, 0.0)));
  EXPECT_EQ(read_sdf(source).pitch_x, 0);
  source.pitch = 2e-3;
  EXPECT_EQ(read_sdf(source).pitch_y, 2e-3);
  source.path = kIso1;
  EXPECT_EQ(refusal([&] { read_sdf(source); }).pointer(), "option 'pitch'");
  source = map_source(kIso1);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_sdf(source); }).pointer(), "option 'of'");
  source = map_source(kIso1);
  source.value_factor = 1e-9;
  EXPECT_EQ(refusal([&] { read_sdf(source); }).pointer(), "option 'value_unit'");
  source.value_factor = 4e-12;
  EXPECT_NO_THROW(read_sdf(source));
}

TEST(Sdf, RefusesWhatItCannotReadAndSaysWhere) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& bytes) {
    const std::string path = folder.write("a.sdf", bytes);
    const InputError error = refusal([&] { read_sdf(map_source(path)); });
    EXPECT_EQ(error.file(), path);
    return error;
  };
  const std::string bytes = test::read_file(kIso1), text = test::read_file(kText);
  EXPECT_EQ(refused(replaced(bytes, "ISO-1.0", "ISO-3.0")).pointer(), "version");
  EXPECT_EQ(refused(replaced(text, "aISO-1.0", "aISO-1.")).pointer(), "version");
  EXPECT_EQ(refused(with_number(bytes, kPoints, std::uint16_t(0))).pointer(), "NumPoints, NumProfiles");
  EXPECT_EQ(refused(with_number(bytes, kPoints + 2, std::uint16_t(1))).pointer(),
            "NumProfiles");  // a profile
  EXPECT_TRUE(contains(refused(with_number(bytes, kPoints, std::uint16_t(65535))).found(), "too early"));
  EXPECT_EQ(refused(with_number(bytes, kZscale, 0.0)).pointer(), "Zscale");
  EXPECT_EQ(refused(with_number(bytes, kZscale, std::nan(""))).pointer(), "Zscale");
  EXPECT_EQ(refused(with_number(bytes, kCompression, std::uint8_t(1))).pointer(), "Compression");
  EXPECT_EQ(refused(with_number(bytes, kCheckType, std::uint8_t(1))).pointer(), "CheckType");
  EXPECT_EQ(refused(with_number(bytes, kDataType, std::uint8_t(8))).pointer(), "DataType");
  // The number of points overflows; no memory is allocated.
  const std::string wide = with_number(test::read_file(kIso2), kPoints, std::uint64_t(-1));
  EXPECT_EQ(refused(wide).pointer(), "NumPoints, NumProfiles");
  EXPECT_EQ(refused(replaced(text, "NumPoints   = 12", "NumPoints = 90000000")).pointer(), "line 14");
  EXPECT_EQ(refused(replaced(text, "NumPoints   = 12", "NumPoints = 1.5")).pointer(),
            "NumPoints, NumProfiles");
  EXPECT_EQ(refused(replaced(text, "NumPoints   = 12", "NumPoints = many")).pointer(), "line 5");
  EXPECT_EQ(refused(replaced(text, "Zscale", "Zsacle")).pointer(), "Zscale");
  EXPECT_TRUE(
      contains(refused(replaced(text, "NumPoints   = 12", "NumPoints   = 13")).found(), "after 108 numbers"));
  EXPECT_TRUE(contains(refused(replaced(text, "NumPoints   = 12", "NumPoints   = 11")).found(),
                       "after the last point"));
  EXPECT_EQ(refused(replaced(text, "BAD", "BAAD")).pointer(), "line 15");
  EXPECT_TRUE(contains(refused(text.substr(0, 200)).found(), "end of the file"));
  for (const std::size_t length : {std::size_t(0), std::size_t(5), std::size_t(60), bytes.size() - 20})
    refused(bytes.substr(0, length));
  refusal([&] { read_sdf(map_source(folder.file("missing.sdf"))); });
}

TEST(Sdf, DamagedFilesAreRefusedOrReadNeverACrash) {
  const auto read = [](const std::string& path) { return read_sdf(map_source(path)); };
  const auto text = test::read_damaged(test::read_file(kText), 330, "sdf text", 700, read);
  EXPECT_GT(text.refused, 200);
  EXPECT_GT(text.read, 50);
  for (const std::string& path : {kIso1, kIso2, kBcr}) {
    const auto count = test::read_damaged(test::read_file(path), kFirst + 4, "sdf", 700, read);
    EXPECT_GT(count.refused, 200);
    EXPECT_GT(count.read, 50);
  }
}

TEST_F(InstrumentsOnRealData, SdfOfTheStandardsExampleHasItsHeights) {
  const HeightMap map = std::get<HeightMap>(read_measurement(map_source(file("sdf-1.sdf"))));
  EXPECT_EQ(map.columns(), 7);
  EXPECT_EQ(map.rows(), 4);
  EXPECT_EQ(map.pitch_x, 1e-6);
  EXPECT_EQ(map.pitch_y, 1e-6);
  EXPECT_NEAR(map.height(0, 5), 0.96858e-6, 1e-18);  // the first profile has the lowest y
  EXPECT_NEAR(map.height(3, 0), 0.97986e-6, 1e-18);
  EXPECT_NEAR(map.height(3, 5), 0.94907e-6, 1e-18);
}

}  // namespace
}  // namespace aberfit
