// Tests against files written by h5py (write_instrument_files.py).
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "map_mutation.h"

namespace aberfit {
namespace {

using test::contains;
using test::instrument_file;
using test::map_source;
using test::refusal;
using test::ScratchFolder;

constexpr double kWavelength = 632.8e-9;

MeasuredSource four_d_source(const std::string& name) {
  MeasuredSource source = map_source(instrument_file(name));
  source.wavefront = false;
  return source;
}

TEST(FourD, ReadsWavesTheTopRowFirst) {
  const HeightMap marker = test::marker_map(9, 12, 0.25e-3);
  const HeightMap map = read_4d(four_d_source("marker-4d.h5"));
  constexpr double kSingle = 6e-8;  // relative, of about 50 nm
  test::expect_same_map(map, marker, kSingle * 60e-9);
  EXPECT_NEAR(map.pitch_x, 0.25e-3, 1e-18);
  EXPECT_EQ(map.pitch_y, map.pitch_x);
  EXPECT_NEAR(map.x0, -5.5 * 0.25e-3, 1e-15);
  // Compressed doubles with another no-data mark and without pitch.
  MeasuredSource source = four_d_source("marker-4d-packed.h5");
  test::expect_same_map(read_4d(source), marker, 1e-21);
  EXPECT_EQ(read_4d(source).pitch_x, 0);
  source.pitch = 2e-3;
  EXPECT_EQ(read_4d(source).pitch_y, 2e-3);
  // A file of the later program.
  source = four_d_source("marker-4d-focus.h5");
  source.wavelength = kWavelength;
  test::expect_same_map(read_4d(source), marker, 1e-21);
}

TEST(FourD, IsKnownByItsContentAndAsksForWhatTheFileDoesNotSay) {
  using Facts = std::vector<std::string>;
  const auto open = [](const char* name) { return missing_facts(map_source(instrument_file(name))); };
  for (const char* name : {"marker-4d.h5", "marker-4d-packed.h5", "marker-4d-focus.h5"})
    EXPECT_EQ(to_string(detect_format(instrument_file(name))), "4d");
  EXPECT_EQ(open("marker-4d.h5"), Facts{"of"});
  EXPECT_EQ(open("marker-4d-packed.h5"), (Facts{"of", "pitch"}));
  EXPECT_EQ(open("marker-4d-focus.h5"), (Facts{"of", "wavelength", "pitch"}));
  MeasuredSource source = four_d_source("marker-4d.h5");
  source.wavefront = true;
  EXPECT_NEAR(read_4d(source).height(7, 9), 0.5 * test::marker_map(9, 12, 1).height(7, 9), 1e-14);
  source.pitch = 1e-3;
  EXPECT_EQ(refusal([&] { read_4d(source); }).pointer(), "option 'pitch'");
  source = four_d_source("marker-4d.h5");
  source.wavelength = 500e-9;
  EXPECT_EQ(refusal([&] { read_4d(source); }).pointer(), "option 'wavelength'");
  source = four_d_source("marker-4d.h5");
  source.value_factor = 1e-9;
  EXPECT_EQ(refusal([&] { read_4d(source); }).pointer(), "option 'value_unit'");
}

TEST(FourD, ALengthWithoutAUnitIsNone) {
  const ScratchFolder folder;
  const std::string bytes = test::read_file(instrument_file("marker-4d.h5"));
  for (const char* written : {"0.25  ", "0.25px", "0.0 mm", "-1. mm", "      "}) {
    MeasuredSource source =
        map_source(folder.write("a.h5", test::replaced(bytes, "0.25 mm", written + std::string(1, '\0'))));
    source.wavefront = false;
    EXPECT_EQ(read_4d(source).pitch_x, 0) << written;
    source.path = folder.write("b.h5", test::replaced(bytes, "632.8 nm", written + std::string(2, ' ')));
    EXPECT_EQ(missing_facts(source), (std::vector<std::string>{"wavelength"})) << written;
  }
}

// HDF5 files of other programs are described by their content, whichever reader is used.
TEST(FourD, NamesOtherHdf5FilesByWhatTheyHold) {
  const std::string path = instrument_file("other.h5");
  MeasuredSource source = map_source(path);
  for (const auto& read : std::vector<std::function<void()>>{
           [&] { read_measurement(source); }, [&] { read_4d(source); }, [&] { read_datx(source); }}) {
    const InputError error = refusal(read);
    EXPECT_TRUE(contains(error.found(), "an HDF5 file, not of Zygo Mx or 4D")) << error.what();
    EXPECT_TRUE(contains(error.found(), "its top level holds entry, notes")) << error.what();
  }
  // A .datx file is still recognised.
  EXPECT_EQ(to_string(detect_format(instrument_file("marker-nm.datx"))), "datx");
  EXPECT_EQ(to_string(detect_format(instrument_file("marker-fringes.datx"))), "datx");
}

TEST(FourD, RefusesWhatIsDamagedAndSaysWhere) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& bytes) {
    MeasuredSource source = map_source(folder.write("a.h5", bytes));
    source.wavefront = false;
    return refusal([&] { read_4d(source); });
  };
  const std::string bytes = test::read_file(instrument_file("marker-4d.h5"));
  EXPECT_EQ(refused(test::replaced(bytes, "genraw", "genrow")).pointer(), "/measurement0/genraw");
  refused(bytes.substr(0, bytes.size() / 2));
  refused("");
  const auto read = [](const std::string& path) {
    MeasuredSource source = map_source(path);
    source.wavefront = false;
    source.wavelength = 632.8e-9;
    return read_4d(source);
  };
  for (const char* name : {"marker-4d.h5", "marker-4d-packed.h5"}) {
    const std::string original = test::read_file(instrument_file(name));
    const auto count = test::read_damaged(original, original.size(), name, 300, read);
    EXPECT_GT(count.refused, 30);
    EXPECT_GT(count.read, 20);
  }
}

}  // namespace
}  // namespace aberfit
