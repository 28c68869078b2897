// What `aberfit psd` prints, writes and warns of, on random profiles of known PSD: text, JSON and CSV agree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "spectrum/random_line.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;

std::string profile_csv(const Spectrum& spectrum, ProfileQuantity quantity, int seed) {
  const Profile profile = random_line(spectrum, quantity, seed);
  std::string text = quantity == ProfileQuantity::kSlope ? "x [m],slope [rad]\n" : "x [m],height [m]\n";
  for (Eigen::Index i = 0; i < profile.size(); ++i)
    text += fmt::format("{:.17g},{:.17g}\n", profile.x[i], profile.value[i]);
  return text;
}

const Spectrum kSteep = [](double f) { return 1e-15 * std::pow(f, -4); };

struct Ran {
  ordered_json result;
  std::string text, csv;
  bool warned(const std::string& code) const {
    for (const auto& warning : result["warnings"])
      if (warning["code"] == code) return true;
    return false;
  }
};

Ran measured(const Spectrum& spectrum, ProfileQuantity quantity, int seed) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(spectrum, quantity, seed));
  EXPECT_EQ(run_program(folder, "psd mirror.csv --no-plots -o out"), 0)
      << read_file(folder.file("stderr.txt"));
  return {ordered_json::parse(read_file(folder.file("out/result.json"))),
          read_file(folder.file("stdout.txt")), read_file(folder.file("out/psd.csv"))};
}

// A red PSD has its RMS in a few bins of chance: where the model has another, that is said with the factor.
TEST(PsdCommand, SaysWhereTheModelHasAnotherRmsThanTheBins) {
  int warned = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    const Ran ran = measured(kSteep, ProfileQuantity::kHeight, seed);
    const ordered_json &model = ran.result["in_band"]["model"], &data = ran.result["in_band"]["data"];
    const auto ratio = [&](const char* key) { return model[key].get<double>() / data[key].get<double>(); };
    const double height = ratio("rms_height_m"), slope = ratio("rms_slope");
    const bool other = std::abs(height - 1) > 0.1 || std::abs(slope - 1) > 0.1;
    EXPECT_EQ(ran.warned("rms-not-as-measured"), other) << seed;
    EXPECT_NE(ran.text.find(fmt::format("(ratio {:.3f})", height)), std::string::npos) << ran.text;
    EXPECT_EQ(ran.text.find(fmt::format("{:.2f} times the RMS height", height)) != std::string::npos, other);
    warned += other;
  }
  EXPECT_GT(warned, 0);
  EXPECT_LT(warned, 8);
}

TEST(PsdCommand, WritesTheSurfacesPsdAndTheLineOfADrawing) {
  for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope}) {
    const Ran ran = measured(kSteep, quantity, 5);
    const ordered_json& line = ran.result["drawing_line"];
    EXPECT_NEAR(line["exponent"], 4, 3.5 * line["exponent_std"].get<double>());
    EXPECT_TRUE(line["describes"]);
    EXPECT_NE(ran.text.find(fmt::format("B = {:.3f}", line["exponent"].get<double>())), std::string::npos);
    // Bins of the table, in order, are those of the JSON that are known.
    std::istringstream rows(ran.csv);
    std::vector<std::string> read;
    for (std::string row; std::getline(rows, row);)
      if (!row.starts_with("#") && !row.starts_with("frequency")) read.push_back(row);
    std::size_t next = 0;
    for (const auto& bin : ran.result["estimate"]["bins"]) {
      if (bin["psd_m3"].is_null()) continue;
      ASSERT_LT(next, read.size());
      EXPECT_TRUE(read[next].starts_with(
          fmt::format("{:.9g},{:.9g},", bin["frequency_per_m"].get<double>(), bin["psd_m3"].get<double>())))
          << read[next];
      ++next;
    }
    EXPECT_EQ(next, read.size());
    EXPECT_GT(next, 20u);
  }
}

TEST(PsdCommand, SaysWhereTheBandThatIsAskedForHasNoBins) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  const auto warns = [&](const std::string& options) {
    EXPECT_EQ(run_program(folder, "psd mirror.csv --no-plots --json -o out " + options), 0);
    return read_file(folder.file("stdout.txt")).find("band-beyond-data") != std::string::npos;
  };
  EXPECT_FALSE(warns("--f-min '3 /m' --f-max '400 /m'"));
  EXPECT_FALSE(warns("--degree +2"));
  EXPECT_TRUE(warns("--f-max '2 /mm'"));  // Nyquist: 0.5 /mm
  EXPECT_TRUE(warns("--f-min '0.1 /m'"));
}

TEST(PsdCommand, SaysWhereTheInstrumentEnds) {
  const Ran ran = measured([](double f) { return 1e-15 * (f < 200 ? std::pow(f, -3) : 1e-10); },
                           ProfileQuantity::kHeight, 7);
  EXPECT_TRUE(ran.warned("instrument-cut-off"));
  EXPECT_NEAR(ran.result["model"]["f_max_per_m"], 200, 25);
  EXPECT_EQ(ran.result["estimate"]["trusted_to_per_m"], ran.result["model"]["f_max_per_m"]);
  EXPECT_TRUE(measured(kSteep, ProfileQuantity::kHeight, 7).result["estimate"]["trusted_to_per_m"].is_null());
}

}  // namespace
}  // namespace aberfit
