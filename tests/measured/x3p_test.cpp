// Tests against files of an independent writer (write_instrument_files.py), archives made here, and a
// measured one.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/measured/read_measurement.h"
#include "instrument_files.h"
#include "map_mutation.h"
#include "packed_files.h"
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
using test::zip_of;

const std::string kDoubles = instrument_file("marker-double.x3p"),
                  kCounts = instrument_file("marker-counts.x3p");

// 3 x 2 points of doubles, 1 nm to 6 nm.
const std::string kMain =
    "<x:ISO5436_2 xmlns:x='u'><x:Record1><x:FeatureType>SUR</x:FeatureType><x:Axes>"
    "<x:CX><x:AxisType>I</x:AxisType><x:Increment>1e-6</x:Increment></x:CX>"
    "<x:CY><x:AxisType>I</x:AxisType><x:Increment>2e-006</x:Increment></x:CY>"
    "<x:CZ><x:AxisType>A</x:AxisType><x:DataType>D</x:DataType></x:CZ></x:Axes></x:Record1>"
    "<x:Record3><x:MatrixDimension><x:SizeX>3</x:SizeX><x:SizeY>2</x:SizeY><x:SizeZ>1</x:SizeZ></"
    "x:MatrixDimension>"
    "<x:DataLink><x:PointDataLink>data.bin</x:PointDataLink></x:DataLink></x:Record3></x:ISO5436_2>";

template <class Number>
std::string values_of(std::array<Number, 6> values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof values};
}
const std::string kValues = values_of<double>({1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9});

class X3p : public ::testing::Test {
 protected:
  HeightMap read(const std::string& main, const std::string& values = kValues) {
    return read_x3p(map_source(folder_.write("a.x3p", zip_of({{"main.xml", main}, {"data.bin", values}}))));
  }
  InputError refused(const std::string& main, const std::string& values = kValues) {
    return refused_bytes(zip_of({{"main.xml", main}, {"data.bin", values}}));
  }
  InputError refused_bytes(const std::string& bytes) {
    const std::string path = folder_.write("a.x3p", bytes);
    const InputError error = refusal([&] { read_x3p(map_source(path)); });
    EXPECT_EQ(error.file(), path);
    EXPECT_FALSE(error.found().empty());
    return error;
  }

  ScratchFolder folder_;
};

TEST_F(X3p, ReadsDoublesAndCountsWithTheirMaskFromTheLowestRowUpwards) {
  const HeightMap map = read_x3p(map_source(kDoubles));
  test::expect_marker(map, 1e-24);
  EXPECT_EQ(map.label, "marker");
  constexpr double kHalfACount = 2e-12;
  test::expect_marker(read_x3p(map_source(kCounts)), 1.001 * kHalfACount);
}

TEST_F(X3p, ReadsEveryTypeAndTakesNumbersThatAreNotFiniteForHoles) {
  const HeightMap map = read(kMain);
  EXPECT_EQ(map.height(0, 2), 3e-9);
  EXPECT_EQ(map.height(1, 0), 4e-9);
  EXPECT_EQ(map.pitch_y, 2e-6);
  const auto typed = [](const std::string& type) {
    return replaced(kMain, ">D</x:DataType>", ">" + type + "</x:DataType><x:Increment>1e-9</x:Increment>");
  };
  EXPECT_NEAR(read(typed("F"), values_of<float>({1, 2, 3, 4, 5, INFINITY})).height(1, 1), 5e-9, 1e-22);
  EXPECT_TRUE(std::isnan(read(typed("F"), values_of<float>({1, 2, 3, 4, 5, INFINITY})).height(1, 2)));
  EXPECT_NEAR(read(typed("I"), values_of<std::int16_t>({1, 2, 3, 4, 5, -32768})).height(1, 2), -32768e-9,
              1e-19);
  EXPECT_NEAR(read(typed("L"), values_of<std::int32_t>({1, 2, 3, 4, 5, -70000})).height(1, 2), -70000e-9,
              1e-19);
}

TEST_F(X3p, PutsPointsWhereTheAxesSay) {
  EXPECT_EQ(read(replaced(kMain, ">1e-6<", ">-1e-6<")).height(0, 0), 3e-9);
  EXPECT_EQ(read(replaced(kMain, ">2e-006<", ">-2e-6<")).height(0, 0), 4e-9);
  EXPECT_EQ(read(replaced(kMain, ">2e-006<", ">-2e-6<")).pitch_y, 2e-6);
}

TEST_F(X3p, TakesFromTheOptionsOnlyWhatTheFileDoesNotSay) {
  read(replaced(replaced(kMain, ">1e-6<", "><"), ">2e-006<", ">0<"));
  MeasuredSource source = map_source(folder_.file("a.x3p"));
  EXPECT_EQ(read_x3p(source).pitch_x, 0);
  source.pitch = 2e-3;
  EXPECT_EQ(read_x3p(source).pitch_y, 2e-3);
  read(kMain);
  EXPECT_EQ(refusal([&] { read_x3p(source); }).pointer(), "option 'pitch'");
  source = map_source(source.path);
  source.wavefront = true;
  EXPECT_EQ(refusal([&] { read_x3p(source); }).pointer(), "option 'of'");
  source = map_source(source.path);
  source.value_factor = 1e-9;
  EXPECT_EQ(refusal([&] { read_x3p(source); }).pointer(), "option 'value_unit'");
  const std::string counts = replaced(kMain, ">D<", ">I<"),
                    values = values_of<std::int16_t>({1, 2, 3, 4, 5, 6});
  EXPECT_TRUE(contains(refused(counts, values).allowed(), "option 'value_unit'"));
  EXPECT_NEAR(read_x3p(source).height(0, 1), 2e-9, 1e-22);
  using Facts = std::vector<std::string>;
  MeasuredSource unsaid = map_source(source.path);
  EXPECT_EQ(missing_facts(unsaid), Facts{"value_unit"});
  unsaid.value_in_waves = true;
  EXPECT_EQ(missing_facts(unsaid), Facts{"wavelength"});
  unsaid.wavelength = 500e-9;
  EXPECT_NEAR(read_x3p(unsaid).height(0, 1), 2 * 500e-9, 1e-18);
}

TEST_F(X3p, RefusesWhatItCannotReadAndSaysWhere) {
  EXPECT_EQ(refused(replaced(kMain, "SUR", "PRF")).pointer(), "main.xml, Record1/FeatureType");
  EXPECT_EQ(refused(replaced(kMain, ">I<", ">A<")).pointer(), "main.xml, Record1/Axes/CX/AxisType");
  EXPECT_EQ(refused(replaced(kMain, ">A<", ">I<")).pointer(), "main.xml, Record1/Axes/CZ/AxisType");
  EXPECT_EQ(refused(replaced(kMain, ">D<", ">Q<")).pointer(), "main.xml, Record1/Axes/CZ/DataType");
  EXPECT_EQ(refused(replaced(kMain, ">1e-6<", ">wide<")).pointer(), "main.xml, Record1/Axes/CX/Increment");
  EXPECT_EQ(refused(replaced(kMain, ">3<", ">3.5<")).pointer(), "main.xml, Record3/MatrixDimension/SizeX");
  EXPECT_EQ(refused(replaced(kMain, ">3<", ">-3<")).pointer(), "main.xml, Record3/MatrixDimension");
  EXPECT_EQ(refused(replaced(kMain, ">3<", ">9223372036854775807<")).pointer(),
            "main.xml, Record3/MatrixDimension");
  EXPECT_EQ(refused(replaced(kMain, ">1</x:SizeZ", ">2</x:SizeZ")).pointer(),
            "main.xml, Record3/MatrixDimension/SizeZ");
  EXPECT_EQ(refused(replaced(kMain, ">data.bin<", "><")).pointer(),
            "main.xml, Record3/DataLink/PointDataLink");
  EXPECT_EQ(refused(replaced(kMain, "data.bin", "date.bin")).pointer(), "date.bin");
  EXPECT_EQ(refused(replaced(kMain, ">3<", ">4<")).pointer(), "data.bin");  // too short
  EXPECT_EQ(refused(replaced(kMain, ">3<", ">2<")).pointer(), "data.bin");  // too long
  EXPECT_TRUE(contains(refused(kMain.substr(0, 300)).pointer(), "main.xml, byte"));
  EXPECT_EQ(refused("<html/>").pointer(), "main.xml");
  EXPECT_TRUE(contains(refused_bytes(zip_of({{"other.xml", kMain}})).found(), "it holds other.xml"));
  EXPECT_EQ(refused_bytes("PK\x03\x04 and nothing more").pointer(), "");
  EXPECT_EQ(refused_bytes(zip_of({{"main.xml", kMain}}, 12)).pointer(), "main.xml");       // bzip2
  EXPECT_EQ(refused_bytes(zip_of({{"main.xml", kMain}}, 0, 0, 1)).pointer(), "main.xml");  // encrypted
  const std::string archive = zip_of({{"main.xml", kMain}, {"data.bin", kValues}});
  EXPECT_TRUE(contains(refused_bytes(replaced(archive, kValues, values_of<double>({}))).found(), "CRC"));
  for (const std::size_t length : {std::size_t(0), std::size_t(3), archive.size() / 2, archive.size() - 1})
    refused_bytes(archive.substr(0, length));
  refusal([&] { read_x3p(map_source(folder_.file("missing.x3p"))); });
}

// An archive of a folder instead of its content has one more level.
TEST_F(X3p, ReadsAnArchiveWhoseMembersLieInOneFolder) {
  const auto with = [&](const test::PackedFiles& files) {
    return read_x3p(map_source(folder_.write("a.x3p", zip_of(files))));
  };
  const HeightMap flat = read(kMain);
  for (const std::string& at : {std::string("part/"), std::string("two/levels/"), std::string("a b.x3p/")}) {
    test::PackedFiles files = {{at + "main.xml", kMain}, {at + "data.bin", kValues}};
    test::expect_same_map(with(files), flat, 0);
    // macOS adds such files.
    files.insert(files.begin(), {"__MACOSX/" + at + "._main.xml", "junk"});
    test::expect_same_map(with(files), flat, 0);
  }
  // A main.xml at the top level has precedence.
  test::expect_same_map(with({{"old/main.xml", "junk"}, {"main.xml", kMain}, {"data.bin", kValues}}), flat,
                        0);
  EXPECT_TRUE(contains(refused_bytes(zip_of({{"a/main.xml", kMain}, {"b/main.xml", kMain}})).found(),
                       "several surfaces, a/main.xml and b/main.xml"));
  EXPECT_EQ(refused_bytes(zip_of({{"part/main.xml", kMain}})).pointer(), "part/data.bin");
}

TEST_F(X3p, NamesArchivesOfOtherKinds) {
  struct Case {
    const char *member, *found, *allowed;
  };
  for (const Case& c : {Case{"xl/workbook.xml", "it holds xl/workbook.xml, an Excel workbook", "as CSV"},
                        {"word/document.xml", "a Word document", "as CSV"},
                        {"META-INF/manifest.xml", "an OpenDocument file", "as CSV"},
                        {"Index/Tables/DataList.iwa", "Apple Numbers", "as CSV"},
                        {"arr_0.npy", "a NumPy archive (.npz)", "numpy.save"},
                        {"LAYER_0.raw", "a Sensofar .plux", "Gwyddion"},
                        {"map.csv", "it holds [Content_Types].xml, map.csv", "unpacked"}}) {
    const InputError error = refused_bytes(zip_of({{"[Content_Types].xml", "<a/>"}, {c.member, "b"}}));
    EXPECT_TRUE(contains(error.found(), "a zip archive that is not an X3P")) << error.what();
    EXPECT_TRUE(contains(error.found(), c.found)) << error.what();
    EXPECT_TRUE(contains(error.allowed(), c.allowed)) << error.what();
  }
  EXPECT_TRUE(contains(refused_bytes(zip_of({})).what(), "zip"));
}

TEST_F(X3p, UnpacksNoMoreThanItsSizeAsksFor) {
  // The directory claims 4 GB, in a method that could hold them and in one that could not.
  for (const std::uint64_t method : {0, 8}) {
    const InputError error = refused_bytes(zip_of({{"main.xml", kMain}}, method, 0xf0000000));
    EXPECT_EQ(error.pointer(), "main.xml");
    EXPECT_TRUE(contains(error.found(), "4026531840 bytes")) << error.what();
  }
  // Below the limit of main.xml, but more than deflate can hold in so few bytes.
  EXPECT_TRUE(contains(refused_bytes(zip_of({{"main.xml", kMain}}, 8, 1 << 23)).found(), "8388608 bytes"));
  // A map of 8 GB in an archive of 1 kB.
  const std::string huge = replaced(replaced(kMain, ">3<", ">1000000<"), ">2<", ">1000<");
  EXPECT_TRUE(contains(refused(huge).found(), "48 bytes"));
}

TEST_F(X3p, DamagedFilesAreRefusedOrReadNeverACrash) {
  const auto read_file = [](const std::string& path) { return read_x3p(map_source(path)); };
  for (const std::string& path : {kDoubles, kCounts}) {
    const std::string bytes = test::read_file(path);
    EXPECT_GT(test::read_damaged(bytes, bytes.size(), "x3p", 700, read_file).refused, 200);
  }
  // A damaged member fails its CRC, so damaged descriptions and heights are packed anew.
  const auto read_main = [&](const std::string& path) {
    folder_.write("b.x3p", zip_of({{"main.xml", test::read_file(path)}, {"data.bin", kValues}}));
    try {
      return read_x3p(map_source(folder_.file("b.x3p")));
    } catch (const InputError& error) {
      throw InputError(path, error.pointer(), error.found(), error.allowed());
    }
  };
  const auto count = test::read_damaged(kMain, kMain.size(), "x3p main.xml", 700, read_main);
  EXPECT_GT(count.refused, 200);
  EXPECT_GT(count.read, 5);
}

TEST_F(InstrumentsOnRealData, X3pHasTheSizeAndTheRmsThatAreKnown) {
  const HeightMap map = std::get<HeightMap>(read_measurement(map_source(file("x3p-2.x3p"))));
  EXPECT_EQ(map.columns(), 650);
  EXPECT_EQ(map.rows(), 650);
  EXPECT_EQ(valid_count(map), 650 * 650);
  EXPECT_NEAR(650 * map.pitch_x, 8.29767313942749e-5, 1e-17);
  EXPECT_NEAR(650 * map.pitch_y, 2.044783737930349e-4, 1e-17);
  const double rms = std::sqrt((map.height - map.height.mean()).square().mean());
  EXPECT_NEAR(rms, 7.728033273597876e-8, 1e-6 * 7.7e-8);
  // The RMS gradient by forward differences distinguishes x from y.
  const Eigen::Index n = 649;
  const Grid dx = (map.height.block(0, 1, n, n) - map.height.block(0, 0, n, n)) / map.pitch_x,
             dy = (map.height.block(1, 0, n, n) - map.height.block(0, 0, n, n)) / map.pitch_y;
  EXPECT_NEAR(std::sqrt((dx.square() + dy.square()).mean()), 0.062070073998443276, 1e-3);
}

}  // namespace
}  // namespace aberfit
