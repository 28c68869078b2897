// Tests against files written by h5py and the HDF5 library (write_instrument_files.py).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "map_mutation.h"

namespace aberfit {
namespace {

using test::contains;
using test::instrument_file;
using test::map_source;
using test::refusal;
using test::replaced;
using test::ScratchFolder;

const std::string kFringes = instrument_file("marker-fringes.datx"),
                  kMetres = instrument_file("marker-nm.datx");

std::string double_bytes(double value) { return test::with_number(std::string(8, '\0'), 0, value); }

std::string replaced_all(std::string text, std::string_view from, std::string_view to) {
  EXPECT_NE(text.find(from), std::string::npos);
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

TEST(Datx, ReadsFringesWithScaleAndObliquityAndLengths) {
  test::expect_marker(read_datx(map_source(kFringes)), 1e-21);
  test::expect_marker(read_datx(map_source(kMetres)), 1e-14);  // single precision, 6e-8 of 50 nm
}

TEST(Datx, TakesFromTheOptionsOnlyWhatTheFileDoesNotSay) {
  const ScratchFolder folder;
  const std::string bytes = test::read_file(kFringes);
  // The parameters of X and Y are in the global heap.
  MeasuredSource source =
      map_source(folder.write("a.datx", replaced(replaced(bytes, double_bytes(0.25e-3), double_bytes(0)),
                                                 double_bytes(0.5e-3), double_bytes(0))));
  EXPECT_EQ(read_datx(source).pitch_x, 0);
  source.pitch = 2e-3;
  EXPECT_EQ(read_datx(source).pitch_y, 2e-3);
  source.path = kFringes;
  EXPECT_EQ(refusal([&] { read_datx(source); }).pointer(), "option 'pitch'");
  source = map_source(kFringes);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_datx(source); }).pointer(), "option 'of'");
  source = map_source(kFringes);
  source.wavelength = 500e-9;
  EXPECT_EQ(refusal([&] { read_datx(source); }).pointer(), "option 'wavelength'");
  for (const std::string& path : {kFringes, kMetres}) {
    source = map_source(path);
    source.value_factor = 1e-6;
    EXPECT_EQ(refusal([&] { read_datx(source); }).pointer(), "option 'value_unit'");
  }
  source =
      map_source(folder.write("b.datx", replaced_all(bytes, "Fringes", std::string_view("Smoots\0", 7))));
  const InputError error = refusal([&] { read_datx(source); });
  EXPECT_EQ(error.pointer(), "attribute 'Unit'");
  EXPECT_TRUE(contains(error.allowed(), "option 'value_unit'"));
  source.value_factor = 0.5 * 1.25 * 632.8e-9;
  test::expect_marker(read_datx(source), 1e-21);
  source.value_factor.reset();
  source.value_in_waves = true;
  source.wavelength = 0.5 * 1.25 * 632.8e-9;
  test::expect_marker(read_datx(source), 1e-21);
  // Neither wavelength nor unit is in the file.
  using Facts = std::vector<std::string>;
  const std::string bare = replaced_all(bytes, "Z Converter", "Z Converted");
  source = map_source(folder.write("c.datx", replaced_all(bare, "Wavelength", "Wavelengtx")));
  EXPECT_EQ(missing_facts(source), Facts{"wavelength"});
  source.wavelength = 632.8e-9;
  test::expect_marker(read_datx(source), 1e-21);
  std::string unitless = bare;  // changes the attribute, not the BaseUnit of the converters
  for (std::size_t at = 0; (at = unitless.find(std::string_view("Unit\0", 5), at)) != unitless.npos; ++at)
    if (unitless.substr(at - 4, 4) != "Base") unitless[at] = 'X';
  source = map_source(folder.write("d.datx", unitless));
  EXPECT_EQ(missing_facts(source), Facts{"value_unit"});
}

TEST(Datx, RefusesWhatItCannotReadAndSaysWhere) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& bytes) {
    const std::string path = folder.write("a.datx", bytes);
    ::testing::internal::CaptureStderr();
    const InputError error = refusal([&] { read_datx(map_source(path)); });
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(error.file(), path);
    return error;
  };
  const std::string bytes = test::read_file(kFringes), metres = test::read_file(kMetres);
  EXPECT_EQ(refused(replaced(bytes, "No Data", "No date")).pointer(), "attribute 'No Data'");
  // Attribute and converter must agree, whichever is changed first.
  for (const auto& [value, name] : {std::pair(632.8e-9, "Wavelength"),
                                    {0.5, "Interferometric Scale Factor"},
                                    {1.25, "Obliquity Factor"}}) {
    EXPECT_EQ(refused(replaced(bytes, double_bytes(value), double_bytes(value * 1.5))).pointer(),
              fmt::format("attribute '{}'", name));
    EXPECT_EQ(refused(replaced_all(bytes, double_bytes(value), double_bytes(0))).pointer(),
              fmt::format("attribute '{}'", name));
  }
  EXPECT_EQ(refused(replaced_all(bytes, "Fringes", "Frunges")).pointer(), "attribute 'Unit'");
  EXPECT_EQ(refused(replaced(bytes, "Fringes", "Meters ")).pointer(), "attribute 'Unit'");
  EXPECT_EQ(refused(replaced(bytes, "LateralCat", "LiteralCat")).pointer(), "attribute 'X Converter'");
  EXPECT_EQ(refused(replaced(bytes, "Surface", "Surfact")).pointer(), "/Data/Surface");
  using test::with_number;
  EXPECT_EQ(refused(replaced(bytes, "HDF", "HDG")).pointer(), "byte 0");
  EXPECT_EQ(refused(with_number(bytes, 8, std::uint8_t(4))).pointer(), "byte 8");
  EXPECT_EQ(refused(with_number(bytes, 14, std::uint8_t(4))).pointer(), "byte 14");
  EXPECT_EQ(refused(with_number(bytes, 18, std::uint16_t(65535))).pointer(), "byte 18");
  EXPECT_EQ(refused(with_number(bytes, 24, std::uint64_t(512))).pointer(), "byte 24");
  EXPECT_EQ(refused(bytes.substr(0, bytes.size() - 1)).pointer(), "byte 40");
  EXPECT_EQ(refused(with_number(bytes, 48, std::uint64_t(96))).pointer(), "byte 48");
  EXPECT_EQ(refused(metres.substr(0, metres.size() - 1)).pointer(), "byte 28");
  // The first child of the root group's tree points beyond the file.
  const std::size_t tree = bytes.find("TREE");
  EXPECT_EQ(refused(with_number(bytes, tree + 32, ~std::uint64_t(255))).found(), "another node of a group");
  // A node is its own child.
  const std::string circle = with_number(with_number(bytes, tree + 5, std::uint8_t(1)), tree + 32, tree);
  EXPECT_TRUE(contains(refused(circle).found(), "in a circle"));
  for (const std::size_t length : {std::size_t(0), std::size_t(500), bytes.size() / 2, bytes.size() - 1})
    refused(bytes.substr(0, length));
  for (const std::size_t length : {std::size_t(100), metres.size() / 2}) refused(metres.substr(0, length));
  refusal([&] { read_datx(map_source(folder.file("missing.datx"))); });
}

TEST(Datx, AsksForNoMoreOfATextThanTheHeapHas) {
  const ScratchFolder folder;
  const std::string bytes = test::read_file(kFringes);
  // "Fringes" has seven characters in the global heap.
  const auto pointer = [&](std::uint32_t count) {
    const std::string heap = test::with_number(std::string(8, '\0'), 0, std::uint64_t(bytes.find("GCOL")));
    return test::with_number(std::string(4, '\0'), 0, count) + heap;
  };
  for (const std::uint32_t count : {0xffffffffu, 8u, 1u}) {
    const std::string path = folder.write("a.datx", replaced(bytes, pointer(7), pointer(count)));
    const InputError error = refusal([&] { read_datx(map_source(path)); });
    EXPECT_EQ(error.found(), "7 bytes");
    EXPECT_EQ(error.allowed(), fmt::format("{} elements of 1 bytes", count));
  }
}

// The library allocates the memory that a header claims before it checks whether the file has it.
TEST(Datx, LooksAtHeadersBeforeTheLibraryDoes) {
  const ScratchFolder folder;
  const auto expect_refused = [&](const std::string& bytes, std::uint64_t claimed) {
    const std::string path = folder.write("a.datx", bytes);
    const InputError error = refusal([&] { read_datx(map_source(path)); });
    EXPECT_EQ(error.found(), "the end of the file");
    EXPECT_TRUE(contains(error.allowed(), fmt::format("{} bytes that begin at", claimed))) << error.allowed();
  };
  const std::string fringes = test::read_file(kFringes), metres = test::read_file(kMetres);
  // Continuations of headers: a message of sixteen bytes with place and length. The third one is not read.
  constexpr std::uint64_t kHuge = 0x2000000000000148;
  const std::string continuation("\x10\0\x10\0\0\0\0\0", 8);
  const std::size_t first = fringes.find(continuation), second = fringes.find(continuation, first + 1);
  for (const std::size_t at : {first, second})
    expect_refused(test::with_number(fringes, at + 16, kHuge), kHuge);
  // Headers of the newer kind, of the root and of a member, with 16 bytes of times. The flag is changed to
  // claim that their length has eight bytes instead of one.
  for (const std::size_t at : {metres.find("OHDR"), metres.find("OHDR", metres.find("OHDR") + 1)}) {
    ASSERT_EQ(metres[at + 5], 0x20);
    std::uint64_t claimed;
    std::memcpy(&claimed, metres.data() + at + 22, sizeof claimed);
    expect_refused(test::with_number(metres, at + 5, std::uint8_t(0x23)), claimed);
  }
}

TEST(Datx, DoesNotFollowLinksAndStorageOutOfTheFile) {
  EXPECT_EQ(refusal([&] { read_datx(map_source(instrument_file("link.datx"))); }).found(), "a link");
  EXPECT_TRUE(contains(refusal([&] { read_datx(map_source(instrument_file("outside.datx"))); }).found(),
                       "in other files"));
}

TEST(Datx, DamagedFilesAreRefusedOrReadNeverACrash) {
  const auto read = [](const std::string& path) { return read_datx(map_source(path)); };
  for (const std::string& path : {kFringes, kMetres}) {
    const std::string bytes = test::read_file(path);
    ::testing::internal::CaptureStderr();
    const auto count = test::read_damaged(bytes, bytes.size(), "datx", 700, read);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_GT(count.refused, 100);
    EXPECT_GT(count.read, 50);
    ::testing::Test::RecordProperty("refused", count.refused);
  }
}

}  // namespace
}  // namespace aberfit
