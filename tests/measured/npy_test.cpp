// Tests arrays that are written here byte by byte after numpy/lib/format.py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "map_mutation.h"
#include "packed_files.h"

namespace aberfit {
namespace {

using test::contains;
using test::map_source;
using test::refusal;
using test::ScratchFolder;

std::string npy_header(const std::string& dictionary, int version = 1) {
  const int width = version == 1 ? 2 : 4;
  std::string text = dictionary;
  text += std::string(63 - (text.size() + std::size_t(8 + width)) % 64, ' ') + "\n";
  return "\x93NUMPY" + test::little(std::uint64_t(version), 2) + test::little(text.size(), width) + text;
}
std::string npy_of(const std::string& type, const std::string& order, const std::string& shape,
                   const std::string& data, int version = 1) {
  return npy_header(
             fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': ({}), }}", type, order, shape),
             version) +
         data;
}

template <class Number>
std::string numbers(const std::vector<double>& values, bool big = false) {
  std::string bytes;
  for (const double value : values) {
    const Number number = Number(value);
    char raw[sizeof number];
    std::memcpy(raw, &number, sizeof number);
    if (big) std::reverse(std::begin(raw), std::end(raw));
    bytes.append(raw, sizeof number);
  }
  return bytes;
}

// 2 rows of 3: 1 2 3, then 4 5 6.
const std::vector<double> kSix = {1, 2, 3, 4, 5, 6}, kByColumns = {1, 4, 2, 5, 3, 6};

HeightMap read_array(const std::string& bytes, const std::function<void(MeasuredSource*)>& options = {}) {
  const ScratchFolder folder;
  MeasuredSource source = map_source(folder.write("a.npy", bytes));
  source.wavefront = false;
  source.value_factor = 1e-9;
  if (options) options(&source);
  return std::get<HeightMap>(read_measurement(source));
}

TEST(Npy, ReadsEveryNumberInBothByteOrdersAndBothOrdersOfAxes) {
  struct Case {
    const char* type;
    std::string data;
  };
  for (const bool fortran : {false, true}) {
    const std::vector<double>& values = fortran ? kByColumns : kSix;
    for (const Case& c : {Case{"<f8", numbers<double>(values)},
                          {">f8", numbers<double>(values, true)},
                          {"<f4", numbers<float>(values)},
                          {">f4", numbers<float>(values, true)},
                          {"<i2", numbers<std::int16_t>(values)},
                          {">i4", numbers<std::int32_t>(values, true)},
                          {"<i8", numbers<std::int64_t>(values)},
                          {"<u2", numbers<std::uint16_t>(values)},
                          {">u8", numbers<std::uint64_t>(values, true)},
                          {"|u1", numbers<std::uint8_t>(values)},
                          {"|i1", numbers<std::int8_t>(values)}}) {
      const HeightMap map = read_array(npy_of(c.type, fortran ? "True" : "False", "2, 3", c.data));
      ASSERT_EQ(map.rows(), 2);
      ASSERT_EQ(map.columns(), 3);
      // The first row is the top row.
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(map.height(1 - i / 3, i % 3), (i + 1) * 1e-9, 1e-22) << c.type;
      EXPECT_EQ(map.pitch_x, 0);
    }
  }
  EXPECT_NEAR(
      read_array(npy_of("<i2", "False", "2, 3", numbers<std::int16_t>({-7, 2, 3, 4, 5, 6}))).height(1, 0),
      -7e-9, 1e-22);
}

TEST(Npy, TakesEveryVersionOfTheHeaderAndTheOptionsOfAMatrix) {
  const std::string data = numbers<double>(kSix);
  for (const int version : {1, 2, 3})
    EXPECT_NEAR(read_array(npy_of("<f8", "False", "2, 3", data, version)).height(0, 0), 4e-9, 1e-22);
  EXPECT_NEAR(read_array(npy_header("{\"shape\":(2L,3L),\"fortran_order\":False,\"descr\":\"<f8\"}") + data)
                  .height(0, 2),
              6e-9, 1e-22);
  const std::string bytes = npy_of("<f8", "False", "2, 3", data);
  EXPECT_NEAR(read_array(bytes, [](MeasuredSource* s) { s->bottom_first = true; }).height(0, 0), 1e-9, 1e-22);
  EXPECT_EQ(read_array(bytes, [](MeasuredSource* s) { s->pitch = 2e-3; }).pitch_y, 2e-3);
  EXPECT_NEAR(read_array(bytes, [](MeasuredSource* s) { s->wavefront = true; }).height(1, 1), 1e-9, 1e-22);
  const auto waves = [](MeasuredSource* s) {
    s->value_factor.reset(), s->value_in_waves = true, s->wavelength = 500e-9;
  };
  EXPECT_NEAR(read_array(bytes, waves).height(1, 1), 2 * 500e-9, 1e-20);
}

TEST(Npy, NumbersThatAreNotFiniteAreHoles) {
  const HeightMap map =
      read_array(npy_of("<f8", "False", "2, 3", numbers<double>({1, NAN, 3, INFINITY, -INFINITY, 6})));
  EXPECT_EQ(valid_count(map), 3);
  EXPECT_TRUE(std::isnan(map.height(1, 1)) && std::isnan(map.height(0, 0)) && std::isnan(map.height(0, 1)));
}

TEST(Npy, AsksForEverythingThatAnArrayDoesNotSay) {
  const ScratchFolder folder;
  using Facts = std::vector<std::string>;
  MeasuredSource source =
      map_source(folder.write("a.npy", npy_of("<f8", "False", "2, 3", numbers<double>(kSix))));
  EXPECT_EQ(detect_format(source.path), MeasuredFormat::kNpy);
  EXPECT_EQ(missing_facts(source), (Facts{"of", "value_unit", "pitch"}));
  std::vector<double> cube(24);
  for (std::size_t i = 0; i < cube.size(); ++i) cube[i] = double(i);
  source.path = folder.write("b.npy", npy_of("<f8", "False", "4, 2, 3", numbers<double>(cube)));
  EXPECT_EQ(missing_facts(source), (Facts{"plane", "of", "value_unit", "pitch"}));
}

TEST(Npy, ReadsThePlaneOfACube) {
  // value = 100 plane + 10 row + column.
  std::vector<double> c_order, fortran_order;
  for (int p = 0; p < 4; ++p)
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 3; ++c) c_order.push_back(100 * p + 10 * r + c);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 2; ++r)
      for (int p = 0; p < 4; ++p) fortran_order.push_back(100 * p + 10 * r + c);
  for (const bool fortran : {false, true}) {
    const std::string bytes = npy_of("<i2", fortran ? "True" : "False", "4, 2, 3",
                                     numbers<std::int16_t>(fortran ? fortran_order : c_order));
    const HeightMap map = read_array(bytes, [](MeasuredSource* s) { s->plane = 3; });
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.height(1 - r, c), (200 + 10 * r + c) * 1e-9, 1e-21);
    EXPECT_TRUE(contains(refusal([&] { read_array(bytes); }).allowed(), "option 'plane'"));
    for (const int k : {0, 5})
      EXPECT_EQ(refusal([&] { read_array(bytes, [k](MeasuredSource* s) { s->plane = k; }); }).pointer(),
                "option 'plane'");
  }
}

TEST(Npy, RefusesWhatItCannotReadAndSaysWhere) {
  const std::string data = numbers<double>(kSix);
  const auto refused = [](const std::string& bytes) { return refusal([&] { read_array(bytes); }); };
  EXPECT_EQ(refused(npy_of("<f8", "False", "6,", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "False", "", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "False", "1, 1, 2, 3", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "False", "-2, 3", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "False", "2, x", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "False", "0, 3", data)).pointer(), "header, 'shape'");
  EXPECT_EQ(refused(npy_of("<f8", "Perhaps", "2, 3", data)).pointer(), "header, 'fortran_order'");
  for (const char* type : {"<c16", "<U4", "|O", "<f2", "f8", "", "|b1"})
    EXPECT_EQ(refused(npy_of(type, "False", "2, 3", data)).pointer(), "header, 'descr'") << type;
  EXPECT_EQ(
      refused(npy_header("{'descr': [('x', '<f8'), ('z', '<f8')], 'fortran_order': False, 'shape': (3,)}") +
              data)
          .pointer(),
      "header, 'descr'");
  EXPECT_EQ(refused(npy_header("{'shape': (2, 3)}") + data).pointer(), "header, 'descr'");
  EXPECT_EQ(refused("\x93NUMPY\x04\0").pointer(), "byte 0");
  const std::string good = npy_of("<f8", "False", "2, 3", data);
  for (const std::size_t length : {std::size_t(7), std::size_t(40), good.size() - 1})
    refused(good.substr(0, length));
}

TEST(Npy, TakesNoMoreMemoryThanTheFileHasNumbers) {
  const std::string data = numbers<double>(kSix);
  for (const char* shape :
       {"30000, 30000", "1000000000, 1000000000", "9223372036854775807, 2", "4000000000, 2, 3",
        "9223372036854775807, 9223372036854775807, 9223372036854775807", "3, 3"})
    for (const char* order : {"False", "True"})
      EXPECT_FALSE(refusal([&] { read_array(npy_of("<f8", order, shape, data)); }).found().empty()) << shape;
}

TEST(Npy, DamagedFilesAreRefusedOrReadNeverACrash) {
  const auto read = [](const std::string& path) {
    MeasuredSource source = map_source(path);
    source.wavefront = false;
    source.value_factor = 1e-9;
    return read_npy(source);
  };
  const std::string bytes = npy_of("<f4", "True", "7, 9", numbers<float>(std::vector<double>(63, 1.5)));
  const auto count = test::read_damaged(bytes, 80, "npy", 350, read);
  EXPECT_GT(count.refused, 70);
  EXPECT_GT(count.read, 20);
}

}  // namespace
}  // namespace aberfit
