#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "aberfit/measured/read_measurement.h"
#include "mutation.h"
#include "shared_data.h"
#include "synthetic_files.h"

namespace aberfit::test {
namespace {

TEST(DetectFormat, TellsEveryFormatByItsContent) {
  const Scratch scratch;
  std::string long_matrix;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4000; ++j) long_matrix += "1.5 ";
    long_matrix += "\n";
  }
  std::string long_rows, long_profile;  // the head ends within a row
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 900; ++j) long_rows += std::to_string((i * j) % 7) + "," + (j == 899 ? "0\n" : "");
  }
  for (int i = 0; i < 2000; ++i) long_profile += std::to_string(i) + "\t" + std::to_string(i % 9) + "\t0.5\n";
  struct Case {
    std::string bytes;
    MeasuredFormat format;
  };
  const Case cases[] = {
      {"\x88\x1b\x03\x6f rest", MeasuredFormat::kZygo},
      {"\x88\x1b\x03\x70 rest", MeasuredFormat::kZygo},
      {"\x88\x1b\x03\x71 rest", MeasuredFormat::kZygo},
      {"\x88\x1b\x03\x72 rest", MeasuredFormat::kAuto},
      {"SIMPLE  =                    T / a FITS file", MeasuredFormat::kFits},
      {"\x89HDF\r\n\x1a\n rest", MeasuredFormat::kDatx},
      {std::string("\x01\0Directory\0", 12), MeasuredFormat::kOpd},
      {std::string("\x01\0Directorx\0", 12), MeasuredFormat::kAuto},
      {"aISO-1.0\nManufacID = x\n", MeasuredFormat::kSdf},
      {std::string("bBCR-1.0\0\0", 10), MeasuredFormat::kSdf},
      {"PK\x03\x04 rest", MeasuredFormat::kX3p},
      {"\x1f\x8b\x08 rest", MeasuredFormat::kFits},
      {"\x93NUMPY\x01 rest", MeasuredFormat::kNpy},
      {"! a remark\r\n! another\r\na title, 1 2 3\r\nGRD 2 2 SUR WVL 0.6328 SSZ 100\r\n1 2 3 4\r\n",
       MeasuredFormat::kCodeVInt},
      {"a title\nZFR 3 WFR WVL 0.5 SSZ 1\n0\n1\n2\n", MeasuredFormat::kCodeVInt},
      {"a title\nno header\nGRD 2 2 SUR\n", MeasuredFormat::kAuto},
      {"! grid sag\n5 6 0.1 0.1 0 0 0\n0 0 0 0\n0.5 0 0 0\n", MeasuredFormat::kZemaxGridSag},
      {"5 5 0.1 0.1 0 0 0\n0 0 0 0 0\n0 0 0 0 1\n", MeasuredFormat::kZemaxGridSag},
      {"4 5 0.1 0.1 0 0 0\n0 0 0 0 0\n", MeasuredFormat::kAuto},
      {"5 5 1 1 1 1 1\n6 5 1 1 1 1 1\n4 5 1 1 1 1 1\n", MeasuredFormat::kMapText},
      {"{\n \"FILE_FORMAT\": 1 }", MeasuredFormat::kDabam},
      {"{\n \"aberfit\": 1 }", MeasuredFormat::kAuto},
      {"x_mm,height_nm\n0,1\n1,2\n", MeasuredFormat::kProfileText},
      {"# remarks\n3\t1\t5\n2\t1\t6\n1\tnan\t7\n", MeasuredFormat::kProfileText},
      {"0 7 1\n1 7 2\n2 7 3\n", MeasuredFormat::kMapText},  // a row of points: y stays constant
      {"x y z\n0 0 1\n1 0 2\n0 1 3\n1 1 4\n", MeasuredFormat::kMapText},
      {"0.5 0.6 0.7 0.8\n0.4 0.2 0.1 0\n0.6 0.5 0.4 0.1\n", MeasuredFormat::kMapText},
      {"# pitch = 1 mm\n0 1 2\n1 2 3\n", MeasuredFormat::kMapText},
      {"\xef\xbb\xbf# quantity: slope\n0 1 2\n0 2 3\n", MeasuredFormat::kProfileText},
      {long_matrix, MeasuredFormat::kMapText},
      {"# of: surface\n# pitch = 1 mm\n" + long_matrix, MeasuredFormat::kMapText},
      {long_rows, MeasuredFormat::kMapText},
      {long_profile, MeasuredFormat::kProfileText},
      {"some prose\nand more prose\n", MeasuredFormat::kAuto},
      {"1\n2\n3\n", MeasuredFormat::kProfileText},  // its reader reports what is missing
      {"Zygo XYZ Data File - Format 1\n1 2\n", MeasuredFormat::kZygoText},
      {"Zygo ASCII Data File - Format 2\r\n1 2\r\n", MeasuredFormat::kZygoText},
      {"Wyko ASCII Data File Format 0\t0\t1\nX Size\t4\n", MeasuredFormat::kWykoText},
      {"2\n2\n0.5\n0.25\n1\n2\noutside ellipse 1 1 1 1\nDIAM 200\n", MeasuredFormat::kDftfringe},
      {"# Channel: Height\n# Width: 2 mm\n# Height: 2 mm\n# Value units: m\n0 1\n1 3\n",
       MeasuredFormat::kMapText},
      // a matrix with axes
      {"0 1 2 3 4\n1 5 2 9 4\n2 6 1 7 3\n3 4 8 1 2\n4 1 2 3 3\n", MeasuredFormat::kMapText},
      {std::string("x\0,\0z\0\n\0"
                   "0\0,\0"
                   "1\0\n\0"
                   "1\0,\0"
                   "2\0\n\0",
                   24),
       MeasuredFormat::kProfileText},

      {"", MeasuredFormat::kAuto},
      {std::string("1 2\n2 3\0\n", 9), MeasuredFormat::kAuto},
  };
  for (const Case& c : cases)
    EXPECT_EQ(to_string(detect_format(scratch.write("a.bin", c.bytes))), to_string(c.format))
        << c.bytes.substr(0, 60);
}

TEST(DetectFormat, KnowsDabamByEitherFileAndByTheBareName) {
  const Scratch scratch;
  DabamFile slopes{1, {"40mm x 20mm", "measurement step = 1mm", "x(mm)\tSlope (urad)"}, {}, "\t", {}}, many,
      bare;
  slopes.keys = R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-6)";
  for (int i = 0; i < 300; ++i) {
    const double x = -100 + 0.735 * i, y = 1e-6 * std::sin(0.05 * i);
    slopes.rows.push_back({double(i), 1e6 * y});
    many.rows.push_back({1e-3 * x, y, 2 * y, 3 * y, 4 * y, 5 * y, 6 * y});
    bare.rows.push_back({x, y});
  }
  slopes.write(scratch, "slopes"), many.write(scratch, "many"), bare.write(scratch, "bare");
  for (const char* name : {"slopes", "slopes.txt", "slopes.dat", "many.dat", "bare.dat"})
    EXPECT_EQ(to_string(detect_format(scratch.path(name))), "dabam") << name;
  // The same numbers without metadata are columns.
  EXPECT_EQ(to_string(detect_format(scratch.write("lone.dat", bare.numbers()))), "profile");
}

TEST_F(DabamOnRealData, EveryFileIsKnownByItsContent) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(*shared_data("dabam")))
    if (const std::string path = entry.path().string(); path.find("/dabam-") != std::string::npos) {
      EXPECT_EQ(to_string(detect_format(path)), "dabam") << path;
      ++found;
    }
  EXPECT_GE(found, 28);
}

TEST(DetectFormat, NamesTheFileThatCannotBeOpened) {
  const Scratch scratch;
  for (const std::string& path : {scratch.path("missing.dat"), scratch.path("")}) {
    const std::string message = input_error([&] { detect_format(path); });
    EXPECT_NE(message.find(path + ": found a file that cannot be opened"), std::string::npos) << message;
  }
}

TEST(DetectFormat, AnyDamageLeavesAnAnswer) {
  const Scratch scratch;
  const std::string codev = "! a\ntitle\nGRD 2 2 SUR WVL 0.6328 SSZ 100\n1 2 3 4\n";
  DabamFile made{2, {"X(mm)\theight (nm)\tresidual"}, {}, "\t", {}};
  made.keys = R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-9, "PLOT_TITLE_Y1": "Height [nm]")";
  for (int i = 0; i < 400; ++i) made.rows.push_back({-200 + 1.02 * i, 5.58 - 0.01 * i * i, -12 + 0.2 * i});
  for (const std::string& original : {codev, made.metadata(), made.numbers()}) {
    const std::string path = scratch.path("a.dat");
    const MutationCounts counts =
        read_mutations(original, path, 200, "DetectFormat", [&] { detect_format(path); });
    EXPECT_EQ(counts.read, 200);  // reading the head of any file is valid
  }
}

}  // namespace
}  // namespace aberfit::test

// For formats known by their first bytes or name, the message names the format and a way to convert it.
TEST(ReadMeasurement, NamesFormatsThatAreKnownAndNotRead) {
  const aberfit::test::Scratch scratch;
  struct Case {
    std::string name, bytes, found, allowed;
  };
  const std::string binary("\0\1\2\3", 4);
  for (const Case& c :
       {Case{"a.sur", "DIGITAL SURF" + binary, "a Digital Surf surface (.sur, MountainsMap), which",
             "Gwyddion"},
        {"a.bin", "DSCOMPRESSED" + binary, "a Digital Surf surface", "Gwyddion"},
        {"a.PLU", binary, "a Sensofar surface (.plu) by its name", "saves text with a header"},
        {"a.nms", binary, "a NanoFocus surface (.nms) by its name", "Gwyddion"},
        {"a.gwy", "GWYP" + binary, "a Gwyddion file (.gwy)", "Gwyddion"},
        {"a.al3d", "AliconaImaging" + binary, "an Alicona surface", "Gwyddion"},
        {"a.mnt", binary, "a MountainsMap document", "Gwyddion"},
        {"a.opdx", "VCA DATA\x01" + binary, "a Bruker or Dektak surface", "Gwyddion"},
        {"a.vk4", "VK4_" + binary, "a Keyence surface", "Gwyddion"},
        {"a.dat", std::string("II*\0", 4) + binary, "a TIFF picture", "not as grey levels"},
        {"a.xls", "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + binary, "an old Excel", "CSV"},
        {"a.mat", "MATLAB 5.0 MAT-file" + binary, "a MATLAB file", "numpy.save"},
        {"a.bmp", "BM" + binary, "a BMP picture", "not as grey levels"},
        {"a.bin", "BM" + binary, "a file of unknown format", "zygo"}}) {
    aberfit::MeasuredSource source;
    source.path = scratch.write(c.name, c.bytes);
    const std::string message = aberfit::test::input_error([&] { aberfit::read_measurement(source); });
    EXPECT_NE(message.find(c.found), std::string::npos) << message;
    EXPECT_NE(message.find(c.allowed), std::string::npos) << message;
  }
  // If the content is known, the name is irrelevant.
  aberfit::MeasuredSource source;
  source.path = scratch.write("columns.sur", "x_mm,height_nm\n0,1\n1,2\n2,5\n");
  EXPECT_TRUE(std::holds_alternative<aberfit::Profile>(aberfit::read_measurement(source)));
}

TEST(ReadMeasurement, RefusesOptionsThatAFormatHasNoUseFor) {
  const aberfit::test::Scratch scratch;
  aberfit::MeasuredSource source;
  source.path = scratch.write("a.csv", "# pitch = 1 mm\n# of: surface\n# unit: nm\n0 1 2\n1 2 3\n");
  source.plane = 1;
  EXPECT_NE(aberfit::test::input_error([&] { aberfit::read_measurement(source); }).find("'plane'"),
            std::string::npos);
  source.plane.reset(), source.hdu = "0";
  EXPECT_NE(aberfit::test::input_error([&] { aberfit::read_measurement(source); }).find("'hdu'"),
            std::string::npos);
  source.hdu.reset(), source.columns = 3, source.bottom_first = true;
  EXPECT_EQ(std::get<aberfit::HeightMap>(aberfit::read_measurement(source)).height(0, 0), 0);
}

// Values outside the range of any mirror indicate a wrong unit or a damaged file.
TEST(ReadMeasurement, RefusesSizesThatNoMirrorHas) {
  const auto refused = [](const std::string& text, const std::string& where) {
    const std::string path = (std::filesystem::path(::testing::TempDir()) / "aberfit-insane.csv").string();
    std::ofstream(path) << text;
    aberfit::MeasuredSource source;
    source.path = path;
    source.format = aberfit::MeasuredFormat::kProfileText;
    try {
      aberfit::read_measurement(source);
      ADD_FAILURE() << text;
    } catch (const aberfit::InputError& error) {
      EXPECT_EQ(error.pointer(), where) << error.what();
    }
    std::filesystem::remove(path);
  };
  refused("x_m,height_m\n0,0\n1e303,1e-9\n", "position");
  refused("x_m,height_m\n0,0\n1,5e3\n", "height");
  refused("x_m,slope_rad\n0,0\n1,50\n", "slope");
}
