#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include "aberfit/measured/read_measurement.h"
#include "map_mutation.h"
#include "map_samples.h"
#include "shared_data.h"
#include "synthetic_files.h"

namespace aberfit {
namespace {

using test::contains;
using test::MetroProFile;
using test::put_bytes;
using test::refusal;
using test::ScratchFolder;

MeasuredSource source_of(const std::string& path) {
  MeasuredSource source;
  source.path = path;
  return source;
}

void expect_reads_as(const MetroProFile& file) {
  const ScratchFolder folder;
  const HeightMap map = read_zygo(source_of(folder.write("a.dat", file.bytes())));
  ASSERT_EQ(map.rows(), Eigen::Index(file.rows));
  ASSERT_EQ(map.columns(), Eigen::Index(file.columns));
  for (std::uint32_t r = 0; r < file.rows; ++r)
    for (std::uint32_t c = 0; c < file.columns; ++c) {
      const double found = map.height(file.rows - 1 - r, c);  // the top row is first in the file
      if (r == 0 && c == 1) {
        EXPECT_TRUE(std::isnan(found));
      } else {
        const double height = file.unit() * file.count(r, c);
        EXPECT_NEAR(found, height, 1e-15 * std::abs(height));
      }
    }
}

using test::ZygoOnRealData;

TEST_F(ZygoOnRealData, SampleAgreesWithItsReadme) {
  const HeightMap map = read_zygo(source_of(file("valid_zygo_dat_file.dat")));
  EXPECT_EQ(map.columns(), 425);
  EXPECT_EQ(map.rows(), 432);
  EXPECT_EQ(valid_count(map), 136359);
  EXPECT_NEAR(map.pitch_x, 1.1792420264e-4, 1e-13);
  EXPECT_EQ(map.pitch_x, map.pitch_y);
  EXPECT_NEAR(map.x(0), -map.x(424), 1e-15);
  double sum = 0, squares = 0, low = 1, high = -1;
  for (const double h : map.height.reshaped())
    if (std::isfinite(h)) sum += h, squares += h * h, low = std::min(low, h), high = std::max(high, h);
  const double mean = sum / 136359;
  EXPECT_NEAR(std::sqrt(squares / 136359 - mean * mean), 44.591e-9, 0.5e-12);  // last digit of the README
  EXPECT_NEAR(high - low, 330.70e-9, 5e-12);
}

TEST_F(ZygoOnRealData, SampleAgreesPointByPointWithAReadingFromItsEnd) {
  // The phase is at the end of the file. It is read backwards from there, without the lengths in the header.
  const std::string bytes = test::read_file(file("valid_zygo_dat_file.dat"));
  const HeightMap map = read_zygo(source_of(file("valid_zygo_dat_file.dat")));
  std::size_t at = bytes.size();
  const double per_count = 0.5 * double(6.32799981e-7f) / 32768;
  for (Eigen::Index r = 0; r < 432; ++r)  // last row of the file = lowest
    for (Eigen::Index c = 424; c >= 0; --c) {
      std::int64_t count = 0;
      at -= 4;
      for (std::size_t i = 0; i < 4; ++i) count = count * 256 + static_cast<unsigned char>(bytes[at + i]);
      if (count >= std::int64_t(1) << 31) count -= std::int64_t(1) << 32;
      if (count >= 2147483640) {
        ASSERT_TRUE(std::isnan(map.height(r, c)));
      } else {
        ASSERT_NEAR(map.height(r, c), double(count) * per_count, 1e-15 * std::abs(double(count) * per_count));
      }
    }
}

TEST(Zygo, ReadsAPartWithRimHolesAndIntensityPointByPoint) {
  const ScratchFolder folder;
  const test::Interferogram made = test::made_interferogram(85, 80);
  const HeightMap map = read_zygo(source_of(folder.write("a.dat", made.file.bytes())));
  ASSERT_EQ(map.rows(), 85);
  ASSERT_EQ(map.columns(), 80);
  EXPECT_EQ(map.pitch_x, made.map.pitch_x);
  EXPECT_EQ(map.pitch_y, made.map.pitch_y);
  EXPECT_NEAR(map.x(0), -map.x(79), 1e-15);
  EXPECT_EQ(map.label, made.file.comment);
  EXPECT_EQ(valid_count(map), made.map.height.isFinite().count());
  EXPECT_GT(valid_count(map), 4000);
  for (Eigen::Index i = 0; i < map.height.size(); ++i) {
    const double found = map.height.data()[i], put_in = made.map.height.data()[i];
    ASSERT_EQ(std::isnan(found), std::isnan(put_in)) << i;
    if (std::isnan(put_in)) continue;
    ASSERT_NEAR(found, put_in, 1e-15 * std::abs(put_in)) << i;
  }
}

TEST(Zygo, ReadsEveryHeaderFormatPhaseResolutionAndSign) {
  for (const std::uint32_t magic : {0x881B036Fu, 0x881B0370u, 0x881B0371u})
    for (std::uint32_t resolution = 0; resolution < 3; ++resolution)
      for (std::uint32_t sign = 0; sign < 2; ++sign) {
        SCOPED_TRACE(::testing::Message() << std::hex << magic << " " << resolution << " " << sign);
        MetroProFile file;
        file.magic = magic;
        file.header_bytes = magic == 0x881B0371u ? 4096 : 834;
        file.phase_resolution = resolution;
        file.sign = sign;
        expect_reads_as(file);
      }
}

TEST(Zygo, SkipsTheIntensityWithAllItsFrames) {
  for (const std::uint32_t frames : {0u, 1u, 5u}) {
    MetroProFile file;
    file.intensity_width = 7;
    file.intensity_height = 5;
    file.frames = frames;
    expect_reads_as(file);
  }
}

TEST(Zygo, AppliesObliquityAndScale) {
  MetroProFile file;
  file.obliquity = 1.25f;
  file.scale = 1;
  expect_reads_as(file);
}

TEST(Zygo, TakesEveryCodeFrom2147483640AsInvalid) {
  const ScratchFolder folder;
  std::string bytes = MetroProFile().bytes();
  const std::uint32_t codes[] = {2147483639, 2147483640, 2147483646, 2147483647};
  for (std::size_t i = 0; i < 4; ++i) put_bytes(&bytes, 834 + 4 * (4 + i), codes[i], 4);  // the middle row
  const HeightMap map = read_zygo(source_of(folder.write("a.dat", bytes)));
  EXPECT_TRUE(std::isfinite(map.height(1, 0)));
  for (Eigen::Index c = 1; c < 4; ++c) EXPECT_TRUE(std::isnan(map.height(1, c)));
}

TEST(Zygo, TakesFromTheOptionsOnlyWhatTheFileDoesNotSay) {
  const ScratchFolder folder;
  MetroProFile file;
  file.lateral = 0;
  MeasuredSource source = source_of(folder.write("a.dat", file.bytes()));
  EXPECT_EQ(read_zygo(source).pitch_x, 0);
  EXPECT_EQ(read_zygo(source).label, "Sphere 7");
  source.pitch = 2e-3;
  EXPECT_EQ(read_zygo(source).pitch_x, 2e-3);
  EXPECT_NEAR(read_zygo(source).x0, -3e-3, 1e-15);
  const double surface = read_zygo(source).height(0, 3);
  source.wavefront = false;
  EXPECT_EQ(read_zygo(source).height(0, 3), surface);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_zygo(source); }).pointer(), "option 'of'");
  source.wavefront.reset();
  source.wavelength = 2 * double(file.wavelength);
  EXPECT_EQ(refusal([&] { read_zygo(source); }).pointer(), "option 'wavelength'");
  file.lateral = 1e-4f;
  source = source_of(folder.write("a.dat", file.bytes()));
  source.pitch = 2e-3;
  EXPECT_EQ(refusal([&] { read_zygo(source); }).pointer(), "option 'pitch'");
}

TEST(Zygo, RefusesWhatItCannotReadAndSaysWhere) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& bytes) {
    const std::string path = folder.write("a.dat", bytes);
    const InputError error = refusal([&] { read_zygo(source_of(path)); });
    EXPECT_EQ(error.file(), path);
    return error;
  };
  const auto with = [](std::size_t at, std::uint32_t value, int width) {
    std::string bytes = MetroProFile().bytes();
    put_bytes(&bytes, at, value, width);
    return bytes;
  };
  InputError error = refused(with(0, 0x6F031B88, 4));
  EXPECT_EQ(error.pointer(), "byte 0");
  EXPECT_TRUE(contains(error.found(), "little-endian")) << error.what();
  EXPECT_FALSE(contains(refused(with(0, 0x12345678, 4)).found(), "little-endian"));
  EXPECT_EQ(refused(with(6, 4096, 4)).pointer(), "byte 6");
  EXPECT_EQ(refused(with(6, 0xffffffff, 4)).pointer(), "byte 6");
  EXPECT_EQ(refused(with(68, 0, 2)).pointer(), "byte 68");
  EXPECT_EQ(refused(with(72, 47, 4)).pointer(), "byte 72");
  EXPECT_EQ(refused(with(218, 3, 2)).pointer(), "byte 218");
  EXPECT_EQ(refused(with(164, 0, 4)).pointer(), "byte 164");
  EXPECT_EQ(refused(with(176, 0x7fc00000, 4)).pointer(), "byte 176");  // NaN
  EXPECT_EQ(refused(with(184, 0xbf800000, 4)).pointer(), "byte 184");  // -1
  // The wavelength is in micrometres instead of metres.
  EXPECT_EQ(refused(with(168, std::bit_cast<std::uint32_t>(0.6328f), 4)).pointer(), "byte 168");
  // The file claims 65535 x 65535 x 65535 intensity values; no memory is allocated.
  std::string huge = MetroProFile().bytes();
  for (const std::size_t at : {52u, 54u, 56u}) put_bytes(&huge, at, 65535, 2);
  EXPECT_TRUE(contains(refused(huge).found(), "too early"));
  std::string wide = MetroProFile().bytes();
  put_bytes(&wide, 68, 65535, 2), put_bytes(&wide, 70, 65535, 2), put_bytes(&wide, 72, 0, 4);
  EXPECT_TRUE(contains(refused(wide).found(), "too early"));
  const std::string whole = MetroProFile().bytes();
  for (const std::size_t length : {std::size_t(0), std::size_t(3), std::size_t(500), whole.size() - 1})
    refused(whole.substr(0, length));
  refusal([&] { read_zygo(source_of(folder.file("missing.dat"))); });
  refusal([&] { read_zygo(source_of(folder.file("."))); });
}

TEST(Zygo, DamagedFilesAreRefusedOrReadNeverACrash) {
  MetroProFile file;
  file.intensity_width = file.intensity_height = 4;
  const auto count = test::read_damaged(file.bytes(), 240, "zygo", 1400,
                                        [](const std::string& path) { return read_zygo(source_of(path)); });
  EXPECT_GT(count.refused, 300);
  EXPECT_GT(count.read, 100);
  ::testing::Test::RecordProperty("refused", count.refused);
}

}  // namespace
}  // namespace aberfit
