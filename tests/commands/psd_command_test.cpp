// Results, files and warnings of `aberfit psd` for random profiles of known PSD. Text, JSON and CSV must
// agree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "aberfit/roughness/k_correlation.h"
#include "aberfit/study/read_study.h"
#include "spectrum/random_line.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using namespace test;
using nlohmann::ordered_json;
constexpr double kPi = EIGEN_PI;

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
  EXPECT_EQ(run_program(folder, "psd mirror.csv --pictures none -o out"), 0)
      << read_file(folder.file("stderr.txt"));
  return {ordered_json::parse(read_file(folder.file("out/result.json"))),
          read_file(folder.file("stdout.txt")), read_file(folder.file("out/psd.csv"))};
}

// The RMS of a red PSD lies in a few noisy bins. If the model has another RMS, the text says so, with the
// factor.
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
    // The block for the measured surface has both numbers. We sum them over the line A / f^B itself.
    const ordered_json& block = ran.result["roughness_as_measured"];
    EXPECT_EQ(block.is_null(), !other) << seed;
    if (other) {
      const ordered_json& psd = block["psd"];
      const double a = std::stod(psd["profile_psd"]["A"].get<std::string>()), b = psd["profile_psd"]["B"];
      const double low = psd["f_min"], high = psd["f_max"];
      double heights = 0, slopes = 0;
      constexpr int kSteps = 20000;
      for (int k = 0; k < kSteps; ++k) {
        const double step = std::log(high / low) / kSteps, f = low * std::exp((k + 0.5) * step);
        heights += a * std::pow(f, 1 - b) * step;
        slopes += 4 * kPi * kPi * a * std::pow(f, 3 - b) * step;
      }
      EXPECT_NEAR(std::sqrt(heights) / data["rms_height_m"].get<double>(), 1, 1e-5) << seed;
      EXPECT_NEAR(std::sqrt(slopes) / data["rms_slope"].get<double>(), 1, 1e-5) << seed;
      EXPECT_NE(ran.text.find("\"roughness\": " + block.dump()), std::string::npos);
    }
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
    // The rows of the table are the known bins of the JSON, in order.
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
    EXPECT_EQ(run_program(folder, "psd mirror.csv --pictures none --json -o out " + options), 0);
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

// The words of a text, with single blanks.
std::string unwrapped(const std::string& text) {
  std::istringstream words(text);
  std::string joined;
  for (std::string word; words >> word;) joined += (joined.empty() ? "" : " ") + word;
  return joined;
}

double number(const ordered_json& value) { return value.get<double>(); }

TEST(PsdCommand, TellsBandsInTextJsonAndTable) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  const std::string bands =
      " --bands 'low=5/m..0.05/mm, mid=0.05/mm..0.3/mm,beyond=1/mm..2/mm,all=1/km..1/um'";
  ASSERT_EQ(run_program(folder, "psd mirror.csv --pictures none -o out" + bands), 0)
      << read_file(folder.file("stderr.txt"));
  const ordered_json result = ordered_json::parse(read_file(folder.file("out/result.json")));
  const std::string text = read_file(folder.file("stdout.txt")),
                    table = read_file(folder.file("out/bands.csv"));
  ASSERT_EQ(result["bands"].size(), 4u);
  const ordered_json &low = result["bands"][0], &mid = result["bands"][1], &beyond = result["bands"][2];
  EXPECT_EQ(mid["name"], "mid");
  EXPECT_NEAR(number(mid["f_max_per_m"]), 300, 1e-9);
  // Both follow from 1e-15 f^-4 between the limits. Two degrees of freedom per ordinate give 7 and 2 % of the
  // RMS.
  EXPECT_NEAR(number(low["model"]["rms_height_m"]), std::sqrt(1e-15 / 3 * (1 / 125.0 - 1 / 125e3)),
              0.3 * 1.6e-9);
  EXPECT_NEAR(number(mid["data"]["rms_slope"]),
              2 * std::numbers::pi * std::sqrt(1e-15 * (1 / 50.0 - 1 / 300.0)), 0.2 * 2.6e-8);
  EXPECT_TRUE(beyond["data"].is_null());
  EXPECT_NE(unwrapped(text).find("Band mid, 50 /m to 300 /m: RMS height"), std::string::npos) << text;
  EXPECT_NE(unwrapped(text).find("Band beyond, 1 /mm to 2 /mm: no bins"), std::string::npos) << text;
  EXPECT_NE(table.find(fmt::format("mid,50,300,50,300,{:.9g},{:.9g},", number(mid["data"]["rms_height_m"]),
                                   number(mid["data"]["rms_slope"]))),
            std::string::npos)
      << table;
  EXPECT_NE(text.find("band-beyond-data"), std::string::npos);
  EXPECT_NE(table.find("\nbeyond,1000,2000,,,,,,\n"), std::string::npos) << table;
  // Octaves add up to the whole band of the bins.
  double sum = 0;
  for (const ordered_json& octave : result["octaves"])
    sum += std::pow(number(octave["data"]["rms_height_m"]), 2);
  EXPECT_NEAR(std::sqrt(sum) / number(result["bands"][3]["data"]["rms_height_m"]), 1, 1e-9);
  for (const char* wrong : {"low", "low=1/m", "low=1/m..0.5/m", "=1/m..2/m", "low=1..2 mm"})
    EXPECT_EQ(run_program(folder, fmt::format("psd mirror.csv --pictures none -o out --bands '{}'", wrong)),
              2)
        << wrong;
}

TEST(PsdCommand, QuotesNamesOfBandsInTheTable) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "2 m"},
    "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "600 nm"},
    "roughness": {"psd": {"model": "measured", "file": "mirror.csv",
      "bands": [{"name": "low, \"figure\"", "f_min": "5 /m", "f_max": "50 /m"}]}}})");
  ASSERT_EQ(run_program(folder, "psd study.json --pictures none -o out"), 0)
      << read_file(folder.file("stderr.txt"));
  EXPECT_NE(read_file(folder.file("out/bands.csv")).find("\n\"low, \"\"figure\"\"\",5,50,"),
            std::string::npos);
}

TEST(PsdCommand, TellsTheStructureFunctionInTextAndJson) {
  const Ran ran = measured(kSteep, ProfileQuantity::kHeight, 5);
  const ordered_json& d = ran.result["structure_function"].at(0);
  const std::size_t n = d["separation_m"].size();
  ASSERT_GT(n, 20u);
  for (const std::size_t k : {std::size_t(0), n - 1}) {
    const std::string row = fmt::format("{:.4g} nm^2", 1e18 * number(d["mean_square_m2"][k]));
    EXPECT_NE(ran.text.find(row), std::string::npos) << row << "\n" << ran.text;
    EXPECT_NE(ran.text.find(fmt::format("{:.4g} nm^2", 1e18 * number(d["model_m2"][k]))), std::string::npos);
  }
  EXPECT_NEAR(number(d["separation_m"][0]), 1e-3, 1e-12);
}

// The picture shows the printed values. Its files are written even without gnuplot.
TEST(PsdCommand, DrawsTheStructureFunctionThatItTells) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  ASSERT_EQ(run_program(folder, "psd mirror.csv -o out"), 0);
  const ordered_json d =
      ordered_json::parse(read_file(folder.file("out/result.json")))["structure_function"][0];
  std::istringstream rows(read_file(folder.file("out/plots/structure_function.dat")));
  std::size_t k = 0;
  for (std::string row; std::getline(rows, row);) {
    if (row.empty() || row.starts_with("#")) continue;
    std::istringstream numbers(row);
    for (const char* key : {"separation_m", "mean_square_m2", "model_m2"}) {
      double drawn = 0;
      numbers >> drawn;
      EXPECT_NEAR(drawn / number(d[key].at(k)), 1, 1e-8) << key << k;
    }
    ++k;
  }
  EXPECT_EQ(k, d["separation_m"].size());
}

// The RMS slope has one definition; the value by the other convention is shown if it differs by over 1 %.
TEST(PsdCommand, TellsBothConventionsOfARmsSlopeWhereTheyDiffer) {
  int differ = 0;
  for (int seed = 1; seed <= 4; ++seed)
    for (const ProfileQuantity quantity : {ProfileQuantity::kHeight, ProfileQuantity::kSlope}) {
      const Ran ran = measured(kSteep, quantity, seed);
      const ordered_json& e = ran.result["estimate"];
      if (quantity == ProfileQuantity::kHeight) {
        EXPECT_TRUE(e["rms_slope_as_slopes"].is_null());
        continue;
      }
      const bool other = std::abs(number(e["rms_slope_as_slopes"]) / number(e["rms_slope"]) - 1) > 0.01;
      EXPECT_EQ(unwrapped(ran.text).find("when the slopes themselves are detrended") != std::string::npos,
                other);
      differ += other;
    }
  EXPECT_GT(differ, 0);
}

// The printed "line of the drawing" is a roughness block. A study with it has that line.
TEST(PsdCommand, PrintsALineThatAStudyTakes) {
  const Ran ran = measured(kSteep, ProfileQuantity::kHeight, 5);
  const std::size_t at = ran.text.find("The line of the drawing:\n\"roughness\": ");
  ASSERT_NE(at, std::string::npos) << ran.text;
  const std::size_t begin = ran.text.find('{', at);
  const std::string block = ran.text.substr(begin, ran.text.find('\n', begin) - begin);
  const ordered_json& line = ran.result["drawing_line"];
  EXPECT_EQ(ordered_json::parse(block), line["roughness"]);
  const Study study = parse_study(
      R"({"aberfit": 1, "mirror": {"focal_length": "2 m"}, "aperture": {"shape": "circle", "diameter": "0.4 m"},
          "light": {"wavelength": "600 nm"}, "roughness": )" +
          block + "}",
      "study.json");
  const auto& law = std::get<PowerLawPsd>(*study.psd);
  const KCorrelation1d back = k_correlation_2d_to_1d({*law.amplitude, 1, law.exponent});
  EXPECT_NEAR(back.exponent, number(line["exponent"]), 1e-12);
  EXPECT_NEAR(back.amplitude / number(line["amplitude"]), 1, 1e-12);
  EXPECT_EQ(law.f_min, number(line["f_min_per_m"]));
  EXPECT_EQ(law.f_max, number(line["f_max_per_m"]));
}

TEST(PsdCommand, HanningIsTheWindowOfHann) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  ASSERT_EQ(run_program(folder, "psd mirror.csv --pictures none -o hann --window hann"), 0);
  const std::string hann = read_file(folder.file("hann/psd.csv"));
  for (const std::string name : {"hanning", "Hanning", "HANNING"}) {
    ASSERT_EQ(run_program(folder, "psd mirror.csv --pictures none -o " + name + " --window " + name), 0);
    EXPECT_EQ(read_file(folder.file(name + "/psd.csv")), hann) << name;
  }
}

TEST(PsdCommand, AFileInPlaceOfACommandOrStudyNamesThisCommand) {
  const ScratchFolder folder;
  folder.write("mirror.csv", profile_csv(kSteep, ProfileQuantity::kHeight, 5));
  for (const char* arguments : {"mirror.csv", "fit mirror.csv", "check mirror.csv", "solve mirror.csv"}) {
    EXPECT_EQ(run_program(folder, arguments), 2) << arguments;
    EXPECT_NE(read_file(folder.file("stderr.txt")).find("`aberfit psd mirror.csv`"), std::string::npos)
        << arguments;
  }
}

TEST(PsdCommand, AsksOnceForAllThatAFileLeavesOpenInTheWordsOfItsUser) {
  const ScratchFolder folder;
  std::string rows;
  for (int row = 0; row < 24; ++row) {
    for (int column = 0; column < 24; ++column)
      rows += fmt::format("{:.4f} ",
                          std::sin(0.7 * row * row + 1.3 * column) + 0.1 * std::cos(2.1 * column * row));
    rows += '\n';
  }
  folder.write("map.txt", rows);
  const auto message = [&](const std::string& command) {
    EXPECT_EQ(run_program(folder, command), 2) << command;
    return read_file(folder.file("stderr.txt"));
  };
  const std::string typed = message("psd map.txt --pictures none -o out");
  for (const char* option : {"--pitch LENGTH", "--of surface|wavefront", "--value-unit UNIT"})
    EXPECT_NE(typed.find(option), std::string::npos) << option << ": " << typed;
  const std::string one = message("psd map.txt --pictures none -o out --pitch '1 mm' --of surface");
  EXPECT_NE(one.find("the option --value-unit"), std::string::npos) << one;
  const std::string waves =
      message("psd map.txt --pictures none -o out --pitch '1 mm' --of surface --value-unit waves");
  EXPECT_NE(waves.find("the option --wavelength"), std::string::npos) << waves;
  folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "2 m"},
    "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "600 nm"},
    "roughness": {"psd": {"model": "measured", "file": "map.txt"}}})");
  const std::string written = message("psd study.json --pictures none -o out");
  for (const char* key : {"\"pitch\": \"0.1 mm\"", "\"of\": \"surface\" or", "\"value_unit\": \"nm\""})
    EXPECT_NE(written.find(key), std::string::npos) << key << ": " << written;
  EXPECT_EQ(written.find("--"), std::string::npos) << written;
}

// The map in nanometres, in waves, with rows over several lines, or turned over has the same PSD.
TEST(PsdCommand, TakesWavesWrappedRowsAndBottomRowsByOptionAndByKey) {
  const ScratchFolder folder;
  constexpr int kSide = 24;
  std::string plain, wrapped, in_waves;
  const auto height = [](int row, int column) {
    return std::sin(0.7 * row * row + 1.3 * column) + 0.1 * std::cos(2.1 * column * row);
  };
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const bool end = column + 1 == kSide;
      plain += fmt::format("{:.10f}{}", height(row, column), end ? "\n" : " ");
      in_waves += fmt::format("{:.13f}{}", height(row, column) / 500, end ? "\n" : " ");
      wrapped +=
          fmt::format("{:.10f}{}", height(kSide - 1 - row, column), end || column % 7 == 6 ? "\n" : " ");
    }
  folder.write("plain.txt", plain), folder.write("wrapped.txt", wrapped), folder.write("waves.txt", in_waves);
  const auto psd_of = [&](const std::string& arguments) {
    EXPECT_LE(run_program(folder, "psd " + arguments + " --pictures none --json -o out"), 1)
        << read_file(folder.file("stderr.txt"));
    const ordered_json result = ordered_json::parse(read_file(folder.file("stdout.txt")));
    std::vector<double> psd;
    for (const ordered_json& bin : result["estimate"]["bins"]) psd.push_back(number(bin["estimated_m4"]));
    return psd;
  };
  const std::string common = " --of surface --pitch '1 mm'";
  std::string mask, turned_mask;
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      mask += fmt::format("{:d}{}", row < 14, column + 1 == kSide ? "\n" : " ");
      turned_mask += fmt::format("{:d}{}", row >= kSide - 14, column + 1 == kSide ? "\n" : " ");
    }
  folder.write("mask.txt", mask), folder.write("turned.txt", turned_mask);
  // The radial PSD does not change if the map is upside down; a part above the middle does.
  const std::string plain_map = "plain.txt --value-unit nm" + common,
                    wrapped_map = "wrapped.txt --value-unit nm --columns 24" + common,
                    upper = " --aperture rectangle:width=100%,height=14mm,centre=0mm,4mm";
  std::vector<double> truth = psd_of(plain_map + upper);
  const auto expect_truth = [&](const std::vector<double>& psd) {
    ASSERT_EQ(psd.size(), truth.size());
    for (std::size_t b = 0; b < psd.size(); ++b) EXPECT_NEAR(psd[b] / truth[b], 1, 1e-4) << b;
  };
  expect_truth(psd_of("waves.txt --value-unit waves --wavelength '500 nm'" + common + upper));
  expect_truth(psd_of(wrapped_map + " --first-row bottom" + upper));
  EXPECT_GT(std::abs(psd_of(wrapped_map + upper)[0] / truth[0] - 1), 0.01);
  const auto study = [&](const std::string& keys) {
    folder.write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "2 m"},
      "aperture": {"shape": "circle", "diameter": "0.4 m"}, "light": {"wavelength": "600 nm"},
      "roughness": {"psd": {"model": "measured", "of": "surface", "pitch": "1 mm", )" +
                                   keys + R"(, "aperture": {"shape": "rectangle", "width": "100 %",
                                             "height": "14 mm", "centre": [0, "4 mm"]}}}})");
    return psd_of("study.json");
  };
  expect_truth(study(R"("file": "waves.txt", "value_unit": "waves", "wavelength": "500 nm")"));
  expect_truth(study(R"("file": "wrapped.txt", "value_unit": "nm", "columns": 24, "first_row": "bottom")"));
  truth = psd_of(plain_map + " --mask mask.txt");
  expect_truth(psd_of(wrapped_map + " --first-row bottom --mask turned.txt"));
  EXPECT_GT(std::abs(psd_of(plain_map + " --mask turned.txt")[0] / truth[0] - 1), 0.01);
}

TEST(PsdCommand, SaysThatAShapeLeaksAndHowToTakeItOff) {
  const auto quartic = [](double degree) {
    const ScratchFolder folder;
    Profile profile =
        random_line([](double f) { return 1e-15 * std::pow(f, -2); }, ProfileQuantity::kHeight, 5);
    profile.value += 1e-5 * (2 * profile.x - 1).pow(4);
    std::string text = "x [m],height [m]\n";
    for (Eigen::Index i = 0; i < profile.size(); ++i)
      text += fmt::format("{:.17g},{:.17g}\n", profile.x[i], profile.value[i]);
    folder.write("mirror.csv", text);
    EXPECT_LE(run_program(folder, fmt::format("psd mirror.csv --pictures none -o out --degree {}", degree)),
              1);
    return Ran{ordered_json::parse(read_file(folder.file("out/result.json"))),
               read_file(folder.file("stdout.txt")), read_file(folder.file("out/psd.csv"))};
  };
  const Ran leaks = quartic(2), clean = quartic(4);
  EXPECT_TRUE(leaks.warned("shape-leaks"));
  EXPECT_NE(leaks.text.find("shape-leaks"), std::string::npos);
  EXPECT_NE(leaks.csv.find("where shape leaks in"), std::string::npos);
  EXPECT_GE(number(leaks.result["model"]["f_min_per_m"]),
            number(leaks.result["estimate"]["trusted_from_per_m"]) * (1 - 1e-9));
  EXPECT_FALSE(clean.warned("shape-leaks"));
  EXPECT_TRUE(clean.result["estimate"]["trusted_from_per_m"].is_null());
}

}  // namespace
}  // namespace aberfit
