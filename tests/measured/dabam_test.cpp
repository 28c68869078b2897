// DABAM files made by the test are compared with their input, real files with a second, simple parser;
// damaged files must be read or refused.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "aberfit/measured/read_measurement.h"
#include "mutation.h"
#include "shared_data.h"
#include "synthetic_files.h"

namespace aberfit::test {
namespace {

double metadata_number(const std::string& json, const std::string& key, double otherwise) {
  const std::size_t at = json.find("\"" + key + "\"");
  return at == std::string::npos ? otherwise : std::strtod(json.c_str() + json.find(':', at) + 1, nullptr);
}

// Reads rows as numpy.loadtxt does: skip the header, split at blanks.
std::vector<std::vector<double>> plain_rows(const std::string& path, int skip) {
  std::istringstream file(file_bytes(path));
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 0; std::getline(file, line); ++number) {
    if (number < skip) continue;
    std::istringstream fields(line);
    std::vector<double> row;
    for (double value; fields >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

struct Expected {
  const char* id;
  std::size_t scans;
  Eigen::Index points;
  ProfileQuantity quantity;
  double length;  // length of the scan [m], from the README and the metadata; NaN if not stated
};

constexpr ProfileQuantity kSlope = ProfileQuantity::kSlope, kHeight = ProfileQuantity::kHeight;
// Row counts are from `wc -l` minus the header; scan lines and quantities are from the README and the
// metadata. The columns of 010 are height, residual height, slope and residual slope of one scan line.
const Expected kExpected[] = {
    {"001", 1, 1201, kSlope, 1.2},     {"004", 1, 161, kSlope, 0.032},    {"007", 1, 100, kSlope, 0.099},
    {"010", 1, 435, kHeight, 0.44268}, {"019", 1, 1751, kSlope, 0.350},   {"022", 1, 2261, kSlope, 1.130},
    {"024", 4, 775, kSlope, 0.774},    {"025", 12, 171, kSlope, 0.2},     {"039", 1, 1001, kSlope, 1.0},
    {"049", 1, 1201, kSlope, 1.2},     {"071", 1, 9230, kSlope, 0.96846}, {"083", 1, 681, kHeight, 0.5},
    {"094", 3, 241, kSlope, 0.12},     {"095", 1, 207, kSlope, 0.059832}};

TEST_F(DabamOnRealData, EveryFileReadsAsASecondParserReadsIt) {
  for (const Expected& expected : kExpected) {
    SCOPED_TRACE(expected.id);
    const std::string stem = file(std::string("dabam-") + expected.id);
    const std::string json = file_bytes(stem + ".txt");
    const auto rows = plain_rows(stem + ".dat", int(metadata_number(json, "FILE_HEADER_LINES", -1)));
    const bool pairs = metadata_number(json, "FILE_FORMAT", 0) >= 3;
    const std::vector<Profile> profiles = read_dabam(stem + ".txt");
    ASSERT_EQ(profiles.size(), expected.scans);
    for (std::size_t scan = 0; scan < profiles.size(); ++scan) {
      const Profile& profile = profiles[scan];
      const std::string n = std::to_string(scan + 1);
      const double x_factor =
          metadata_number(json, "X" + n + "_FACTOR", metadata_number(json, "X1_FACTOR", NAN));
      const double y_factor = metadata_number(json, "Y" + n + "_FACTOR", NAN);
      ASSERT_EQ(profile.size(), expected.points);
      ASSERT_EQ(std::size_t(profile.size()), rows.size());
      EXPECT_EQ(profile.quantity, expected.quantity);
      EXPECT_EQ(valid_count(profile), expected.points);
      EXPECT_NE(profile.label.find(expected.id), std::string::npos);
      // The product of two doubles is rounded once on both sides.
      constexpr double kRounding = 1e-15;
      for (Eigen::Index i = 0; i < profile.size(); ++i) {
        const std::vector<double>& row = rows[std::size_t(i)];
        const double x = row[pairs ? 2 * scan : 0] * x_factor;
        const double y = row[pairs ? 2 * scan + 1 : scan + 1] * y_factor;
        ASSERT_LE(std::abs(profile.x[i] - x), kRounding * std::abs(x)) << "row " << i;
        ASSERT_LE(std::abs(profile.value[i] - y), kRounding * std::abs(y)) << "row " << i;
        ASSERT_TRUE(i == 0 || profile.x[i] > profile.x[i - 1]) << "row " << i;
      }
      // Stated lengths are rounded to about a pitch.
      const double length = profile.x[profile.size() - 1] - profile.x[0];
      EXPECT_NEAR(length, expected.length, 1e-3 * expected.length);
    }
  }
}

TEST_F(DabamOnRealData, RmsSlopesAreWhatTheOwnersState) {
  // The owners detrended these profiles; the last per cent depends on their instruments.
  struct Case {
    const char* id;
    double stated;
  };
  for (const Case& c : {Case{"025", 0.072352e-6}, Case{"095", 0.37e-6}}) {
    const Profile profile = read_dabam(file(std::string("dabam-") + c.id)).front();
    const double rms = std::sqrt((profile.value - profile.value.mean()).square().mean());
    EXPECT_NEAR(rms, c.stated, 0.05 * c.stated) << c.id;
  }
}

// A layout of the columns, and the scan lines in the file [m] and [m] or [rad].
struct Layout {
  const char* name;
  DabamFile file;
  ProfileQuantity quantity;
  std::vector<std::pair<std::vector<double>, std::vector<double>>> scans;
};

// A slope or height that differs for every position, scan and column.
double made_value(std::size_t i, std::size_t scan) {
  return 1e-7 * std::sin(0.1 * double(i) + double(scan)) + 1e-9 * double(scan);
}

std::vector<Layout> layouts() {
  constexpr std::size_t kPoints = 60;
  std::vector<Layout> all;
  const auto add = [&all](const char* name, DabamFile file, ProfileQuantity quantity, std::size_t scans,
                          double x_factor, double y_factor, bool pairs) {
    Layout layout{name, std::move(file), quantity, {}};
    layout.scans.resize(scans);
    for (std::size_t i = 0; i < kPoints; ++i) {
      std::vector<double> row;
      for (std::size_t scan = 0; scan < scans; ++scan) {
        // The pitch is 0.5 mm, and every position is off by up to 2 % of it; each pair has its own positions.
        const double wobble = std::cos(2.3 * double(i) + (pairs ? double(scan) : 0));
        const double x = -0.02 + 5e-4 * (double(i) + 0.02 * wobble), y = made_value(i, scan);
        if (scan == 0 || pairs) row.push_back(x / x_factor);
        row.push_back(y / y_factor);
        layout.scans[scan].first.push_back(x), layout.scans[scan].second.push_back(y);
      }
      layout.file.rows.push_back(row);
    }
    all.push_back(std::move(layout));
  };
  add("slopes in urad over mm",
      {1,
       {"a mirror", "Scan Length = 30 mm", "", "x(mm)\tSlope (urad)"},
       R"("X1_FACTOR": 1e-3, "Y1_FACTOR": "1e-6")",
       "\t",
       {}},
      kSlope, 1, 1e-3, 1e-6, false);
  add("scan lines in columns, x in m",
      {1, {}, R"("X1_FACTOR": 1, "Y1_FACTOR": 1e-6, "Y2_FACTOR": 1e-6, "Y3_FACTOR": 1e-6)", "  ", {}}, kSlope,
      3, 1, 1e-6, false);
  add("heights in mm",
      {2,
       {},
       R"("X1_FACTOR": 0.001, "Y1_FACTOR": 0.001, "COLUMN_INDEX_ABSCISSAS": 0, "COLUMN_INDEX_ORDINATES": 1)",
       " ",
       {}},
      kHeight, 1, 1e-3, 1e-3, false);
  add("pairs of slopes",
      {3,
       {"a b c d", "# tangential coordinate"},
       R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-6, "X2_FACTOR": 0.001, "Y2_FACTOR": 1e-6)",
       " ",
       {}},
      kSlope, 4, 1e-3, 1e-6, true);
  add("pairs of heights in nm over um", {4, {"x z x z"}, R"("X1_FACTOR": 1e-6, "Y1_FACTOR": 1e-9)", " ", {}},
      kHeight, 2, 1e-6, 1e-9, true);
  // Height, residual height, slope: one scan line and two columns derived from it.
  add("heights in nm and what follows from them",
      {2,
       {"X(mm) height residual slope"},
       R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-9, "Y2_FACTOR": 1e-9, "Y3_FACTOR": 1e-6, "PLOT_TITLE_Y1": "Height",
          "PLOT_TITLE_Y2": "Residual height", "PLOT_TITLE_Y3": "Slope")",
       "\t",
       {}},
      kHeight, 3, 1e-3, 1e-9, false);
  all.back().scans.resize(1);
  return all;
}

TEST(Dabam, EveryLayoutGivesWhatWasPutIn) {
  const Scratch scratch;
  for (const Layout& layout : layouts()) {
    SCOPED_TRACE(layout.name);
    const std::vector<Profile> profiles = read_dabam(layout.file.write(scratch, "made-077"));
    ASSERT_EQ(profiles.size(), layout.scans.size());
    for (std::size_t scan = 0; scan < profiles.size(); ++scan) {
      const auto& [x, y] = layout.scans[scan];
      ASSERT_EQ(std::size_t(profiles[scan].size()), x.size());
      EXPECT_EQ(profiles[scan].quantity, layout.quantity);
      EXPECT_EQ(std::size_t(valid_count(profiles[scan])), x.size());
      EXPECT_NE(profiles[scan].label.find("077"), std::string::npos);
      // Division by the factor, 17 digits, and multiplication round once each.
      constexpr double kRounding = 4e-16;
      for (std::size_t i = 0; i < x.size(); ++i) {
        ASSERT_NEAR(profiles[scan].x[Eigen::Index(i)], x[i], kRounding * std::abs(x[i])) << i;
        ASSERT_NEAR(profiles[scan].value[Eigen::Index(i)], y[i], kRounding * std::abs(y[i])) << i;
      }
    }
  }
}

TEST(Dabam, TxtDatAndBareNameGiveTheSame) {
  const Scratch scratch;
  layouts().front().file.write(scratch, "made-004");
  const Profile by_txt = read_dabam(scratch.path("made-004.txt")).front();
  for (const char* name : {"made-004.dat", "made-004"}) {
    const Profile other = read_dabam(scratch.path(name)).front();
    EXPECT_TRUE((other.x == by_txt.x).all() && (other.value == by_txt.value).all()) << name;
    EXPECT_EQ(other.label, by_txt.label);
  }
}

std::vector<Profile> read_text(const Scratch& scratch, const std::string& json, const std::string& data) {
  scratch.write("a.dat", data);
  return read_dabam(scratch.write("a.txt", json));
}

TEST(Dabam, AllFourFormatsGiveTheirQuantityAndScanLines) {
  const Scratch scratch;
  const std::string rows = "0 1 0.5 10\n1 2 1.5 20\n2 4 2.5 40\n";
  const std::string more = R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-6, "X2_FACTOR": 1, "Y2_FACTOR": 1e-9})";
  for (const int format : {1, 2, 3, 4}) {
    SCOPED_TRACE(format);
    const auto profiles =
        read_text(scratch, "{\"FILE_FORMAT\": " + std::to_string(format) + ", " + more, rows);
    ASSERT_EQ(profiles.size(), format >= 3 ? 2u : 1u);  // formats 1, 2: the factor of column 2 differs
    EXPECT_EQ(profiles[0].quantity, format % 2 == 1 ? kSlope : kHeight);
    EXPECT_EQ(profiles[0].x[2], 2 * 0.001);
    EXPECT_EQ(profiles[0].value[2], 4 * 1e-6);
    if (format < 3) continue;
    EXPECT_EQ(profiles[1].x[2], 2.5);
    EXPECT_EQ(profiles[1].value[2], 40 * 1e-9);
  }
  // Further pairs without their own factors use the first.
  const auto pairs =
      read_text(scratch, R"({"FILE_FORMAT": 3, "X1_FACTOR": 0.001, "Y1_FACTOR": "1e-6"})", rows);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[1].x[0], 0.5 * 0.001);
  EXPECT_EQ(pairs[1].value[0], 10 * 1e-6);
}

TEST(Dabam, NamedColumnsAloneAreRead) {
  const Scratch scratch;
  const auto profiles = read_text(scratch,
                                  R"({"FILE_FORMAT": 2, "X1_FACTOR": 1, "Y1_FACTOR": 1, "Y2_FACTOR": 1,
                                      "COLUMN_INDEX_ABSCISSAS": 2, "COLUMN_INDEX_ORDINATES": "1"})",
                                  "9 5 0\n9 6 1\n9 7 2\n");
  ASSERT_EQ(profiles.size(), 1u);
  EXPECT_EQ(profiles[0].x[2], 2);
  EXPECT_EQ(profiles[0].value[2], 7);
}

TEST(Dabam, HolesStayHolesAndDescendingRowsAreTurned) {
  const Scratch scratch;
  const Profile profile =
      read_text(
          scratch,
          R"({"FILE_FORMAT": 1, "FILE_HEADER_LINES": "1", "X1_FACTOR": 1, "Y1_FACTOR": 1, "LENGTH": ""})",
          "x 1 slope\n3 nan\n2.5 5\n1 --\n0 7\n")
          .front();
  EXPECT_EQ(profile.x[0], 0);
  EXPECT_EQ(profile.x[3], 3);
  EXPECT_EQ(profile.value[0], 7);
  EXPECT_TRUE(std::isnan(profile.value[1]));
  EXPECT_EQ(profile.value[2], 5);
  EXPECT_TRUE(std::isnan(profile.value[3]));
  EXPECT_EQ(valid_count(profile), 2);
}

TEST(Dabam, EveryFaultIsToldWithItsPlace) {
  const Scratch scratch;
  const std::string good = R"({"FILE_FORMAT": 1, "X1_FACTOR": 1, "Y1_FACTOR": 1})";
  struct Case {
    std::string json, data, message;
  };
  const Case cases[] = {
      {good, "0 1\n1 abc\n", "a.dat: line 2: found 'abc'; allowed: a number"},
      {good, "0 1\n1 inf\n", "a.dat: line 2: found 'inf'; allowed: a finite number"},
      {good, "0 1\n1 1e999\n", "a.dat: line 2: found '1e999'"},
      {good, "0 1\n1 2\n1 3\n", "a.dat: line 3: found position 1 twice"},
      {good, "0 1\n2 2\n1 3\n4 4\n", "a.dat: line 3: found position 1 after 2"},
      {good, "0 1\n1 2 3\n", "a.dat: line 2: found 3 columns; allowed: 2 columns, as in line 1"},
      {good, "0 1\n", "found 1 row of numbers"},
      {good, "0\n1\n", "a.dat: line 1: found 1 columns"},
      {good, "", "a.dat: found no row of numbers"},
      {good, "nan 1\n1 2\n", "a.dat: line 1: found a row without position"},
      {good, "0 nan\n1 2\n", "a.dat: column 2: found 1 numbers"},
      {"[]", "0 1\n1 2\n", "a.txt: found JSON array"},
      {"{\n\"FILE_FORMAT\" 1}", "0 1\n1 2\n", "a.txt: line 2: found '\"FILE_FORMAT\" 1}'"},
      {"", "0 1\n1 2\n", "a.txt: line 1"},
      {"{}", "0 1\n1 2\n", "a.txt: /FILE_FORMAT: found nothing; allowed: 1 (slope)"},
      {R"({"FILE_FORMAT": 5, "X1_FACTOR": 1, "Y1_FACTOR": 1})", "0 1\n1 2\n", "/FILE_FORMAT: found '5'"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": "mm", "Y1_FACTOR": 1})", "0 1\n1 2\n",
       "/X1_FACTOR: found '\"mm\"'"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": -1, "Y1_FACTOR": 1})", "0 1\n1 2\n", "a factor above zero"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": 1, "Y1_FACTOR": 1e999})", "0 1\n1 2\n", "range of a double"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": 1})", "0 1\n1 2\n", "/Y1_FACTOR: found nothing"},
      {R"({"FILE_FORMAT": 1, "FILE_HEADER_LINES": 900, "X1_FACTOR": 1, "Y1_FACTOR": 1})", "0 1\n1 2\n",
       "found the end of the file after 2 lines; allowed: rows of numbers after 900 header lines"},
      {R"({"FILE_FORMAT": 1, "FILE_HEADER_LINES": -1, "X1_FACTOR": 1, "Y1_FACTOR": 1})", "0 1\n1 2\n",
       "/FILE_HEADER_LINES: found '-1'"},
      {R"({"FILE_FORMAT": 3, "X1_FACTOR": 1, "Y1_FACTOR": 1})", "0 1 2\n1 2 3\n",
       "found 3 columns; allowed: pairs"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": 1, "Y1_FACTOR": 1, "COLUMN_INDEX_ORDINATES": 4})", "0 1\n1 2\n",
       "found 2 columns; allowed: at least 5 columns"},
      {R"({"FILE_FORMAT": 1, "X1_FACTOR": 1e10, "Y1_FACTOR": 1})", "0 1\n1e305 2\n", "a.dat: line 2"},
  };
  for (const Case& c : cases) {
    const std::string message = input_error([&] { read_text(scratch, c.json, c.data); });
    EXPECT_NE(message.find(c.message), std::string::npos) << "got: " << message << "\nwanted: " << c.message;
  }
  std::filesystem::remove(scratch.path("a.dat"));
  EXPECT_NE(input_error([&] { read_dabam(scratch.path("a")); }).find("a.dat: found no file"),
            std::string::npos);
  EXPECT_NE(input_error([&] { read_dabam(scratch.path("b")); }).find("b.txt: found a file that cannot be"),
            std::string::npos);
}

TEST(Dabam, DamagedFilesAreReadOrRefused) {
  const Scratch scratch;
  // The file is short, so that damage hits every part of it.
  DabamFile made = layouts()[3].file;
  made.rows.resize(24);
  const std::string json = made.metadata(), whole_lines = made.numbers();
  const std::string metadata_path = made.write(scratch, "a"), data_path = scratch.path("a.dat");
  const auto read = [&] { read_dabam(metadata_path); };
  const MutationCounts of_data = read_mutations(whole_lines, data_path, 400, "DabamData", read);
  scratch.write("a.dat", whole_lines);
  const MutationCounts of_metadata = read_mutations(json, metadata_path, 400, "DabamMetadata", read);
  // Both outcomes must occur: the damage neither misses nor destroys every file.
  for (const MutationCounts& counts : {of_data, of_metadata}) {
    EXPECT_GT(counts.read, 20);
    EXPECT_GT(counts.refused, 100);
  }
  RecordProperty("read", of_data.read + of_metadata.read);
}

}  // namespace
}  // namespace aberfit::test
