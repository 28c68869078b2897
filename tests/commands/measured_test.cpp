// Measured surfaces through the program: aberfit psd, psd.model "measured", target.map, target.psd and
// exports.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/study/read_study.h"
#include "measured/synthetic_files.h"
#include "report/listing_reader.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

// Slopes of a surface with a red PSD every millimetre, with a turning line of 1 nm RMS every 8 mm. The
// positions are uneven by `uneven` of the pitch.
test::DabamFile made_slopes(std::size_t points, double uneven) {
  test::DabamFile file;
  file.header = {"a mirror", "x(mm)\tSlope (urad)"};
  file.separator = "\t";
  std::vector<double> x = test::even_positions(points, -0.5e-3 * double(points - 1), 1e-3);
  for (std::size_t i = 0; i < points; ++i) x[i] += uneven * 1e-3 * std::sin(1.7 * double(i * i % 97));
  const test::DrawnLine line = test::drawn_line(
      x, [](double f) { return 1e-19 * std::pow(1 + f / 20, -3); }, points);
  const double k = 2 * EIGEN_PI * 125, amplitude = 1e-9 * std::sqrt(2.0);
  for (std::size_t i = 0; i < points; ++i)
    file.rows.push_back({1e3 * x[i], 1e6 * (line.slope[i] + amplitude * k * std::cos(k * x[i]))});
  return file;
}

// Heights every 1.02 mm, and derived columns, in one row.
test::DabamFile made_heights() {
  test::DabamFile file;
  file.format = 2;
  file.header = {"X(mm)\theight (nm)\tresidual height (nm)"};
  file.keys =
      R"("X1_FACTOR": 0.001, "Y1_FACTOR": 1e-9, "PLOT_TITLE_Y1": "Height", "PLOT_TITLE_Y2": "Residual")";
  const test::DrawnLine line = test::drawn_line(
      test::even_positions(435, -0.22, 1.02e-3), [](double f) { return 1e-19 * std::pow(1 + f / 20, -3); },
      435);
  for (std::size_t i = 0; i < line.x.size(); ++i)
    file.rows.push_back({1e3 * line.x[i], 1e9 * line.height[i], 1e9 * line.height[i] - 1});
  return file;
}

test::Interferogram made_map() { return test::made_interferogram(212, 206); }

std::string study_with(const std::string& blocks, const std::string& diameter = "0.4 m") {
  return R"({"aberfit": 1, "mirror": {"focal_length": "2.8 m"}, "light": {"wavelength": "632.8 nm"},
             "aperture": {"shape": "circle", "diameter": ")" +
         diameter + "\"}" + blocks + "}";
}

TEST(PsdCommand, MeasuresAProfileAndOffersARoughnessBlock) {
  const ScratchFolder folder;
  made_slopes(1001, 0).write(folder, "mirror");
  ASSERT_EQ(run_program(folder, "psd mirror.txt --json --pictures none -o out"), 0)
      << read_file(folder.file("stderr.txt"));
  const ordered_json result = ordered_json::parse(read_file(folder.file("stdout.txt")));
  EXPECT_EQ(result, ordered_json::parse(read_file(folder.file("out/result.json"))));
  EXPECT_EQ(result["kind"], "psd");
  EXPECT_EQ(result["measurements"][0]["quantity"], "slope");
  EXPECT_GT(result["estimate"]["bins"].size(), 10u);
  // The simulated line. The trapezoid rule over the slopes leaves x/tan(x) of its height, x = pi/8.
  const auto& lines = result["estimate"]["lines"];
  ASSERT_GE(lines.size(), 1u) << lines;
  EXPECT_NEAR(lines[0]["frequency_per_m"].get<double>(), 125, 0.1);
  const double left = EIGEN_PI / 8 / std::tan(EIGEN_PI / 8);
  EXPECT_NEAR(lines[0]["rms_height_m"].get<double>() / (left * 1e-9), 1,
              0.04);  // the continuum is 1/60 of it
  // The printed block can be pasted into a study as it is.
  const Study study =
      parse_study(study_with(", \"roughness\": " + read_file(folder.file("out/roughness.json")) +
                             R"(, "terms": {"zernike": {"n_max": 6}})"),
                  "pasted.json");
  EXPECT_TRUE(study.roughness.has_value());
  // The bins are a table that the study reader accepts.
  fs::copy_file(folder.file("out/psd.csv"), folder.file("psd.csv"));
  EXPECT_NO_THROW(parse_study(
      study_with(R"(, "roughness": {"psd": {"model": "table", "file": "psd.csv", "kind": "1d"}})"),
      folder.file("study.json")));
}

TEST(PsdCommand, DrawsThePsdAndTheData) {
  const ScratchFolder folder;
  made_heights().write(folder, "heights");
  ASSERT_EQ(run_program(folder, "psd heights.txt --quiet -o out"), 0) << read_file(folder.file("stderr.txt"));
  EXPECT_EQ(read_file(folder.file("stderr.txt")), "");
  for (const char* name : {"plots/psd.svg", "plots/data.svg", "psd.csv", "summary.txt"})
    EXPECT_GT(fs::file_size(folder.file(std::string("out/") + name)), 100u) << name;
}

TEST(PsdCommand, RefusesDamagedFilesAndLeavesNothing) {
  const ScratchFolder folder;
  const std::string zygo = made_map().file.bytes();
  folder.write("map.dat", zygo);
  made_heights().write(folder, "heights");
  folder.write("cut.dat", zygo.substr(0, zygo.size() / 2));
  folder.write("profile.csv", "x,height\n0,1\n1,2\n");
  folder.write("map.fits", "SIMPLE  =                    T" + std::string(50, ' ') + "END");
  for (const std::string& arguments : std::vector<std::string>{
           "psd cut.dat", "psd profile.csv", "psd map.fits", "psd missing.dat", "psd map.dat --window sinc",
           "psd map.dat --f-min 5mm", "psd heights.txt map.dat"}) {
    SCOPED_TRACE(arguments);
    EXPECT_EQ(run_program(folder, arguments + " -o out"), 2);
    const std::string said = read_file(folder.file("stderr.txt"));
    EXPECT_TRUE(said.starts_with("aberfit: ")) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_FALSE(fs::exists(folder.file("out")));
    EXPECT_EQ(read_file(folder.file("stdout.txt")), "");
  }
}

TEST(MeasuredRoughness, IsWhatThePsdCommandFits) {
  const ScratchFolder folder;
  made_slopes(207, 2e-3).write(folder, "mirror");
  folder.write(
      "study.json",
      study_with(
          R"(, "roughness": {"psd": {"model": "measured", "file": "mirror.txt", "scale": 50}}, "terms": {"zernike": {"n_max": 6}})"));
  ASSERT_EQ(run_program(folder, "psd study.json --json --pictures none -o a"), 0)
      << read_file(folder.file("stderr.txt"));
  const ordered_json from_study = ordered_json::parse(read_file(folder.file("stdout.txt")));
  ASSERT_EQ(run_program(folder, "psd mirror.txt --scale 50 --json --pictures none -o b"), 0);
  const ordered_json from_file = ordered_json::parse(read_file(folder.file("stdout.txt")));
  EXPECT_EQ(from_study["model"], from_file["model"]);
  EXPECT_EQ(from_study["roughness"], from_file["roughness"]);
  // The study with its measurement and the study with the pasted block predict the same scene.
  const Study measured = read_study(folder.file("study.json"));
  const Study pasted = parse_study(study_with(", \"roughness\": " + from_file["roughness"].dump() +
                                              R"(, "terms": {"zernike": {"n_max": 6}})"),
                                   "pasted.json");
  const ordered_json a = to_json(run_check(measured, {}), resolved_study(measured)),
                     b = to_json(run_check(pasted, {}), resolved_study(pasted));
  EXPECT_EQ(a["scene"], b["scene"]);
  // The resolved study is a valid study with the same meaning.
  const Study again = parse_study(resolved_study(measured).dump(), folder.file("again.json"));
  EXPECT_EQ(resolved_study(again), resolved_study(measured));
}

TEST(MapTarget, FitsAnInterferogramAndExportsTheSurface) {
  const ScratchFolder folder;
  const test::Interferogram made = made_map();
  folder.write("map.dat", made.file.bytes());
  folder.write(
      "study.json",
      study_with(
          R"(, "target": {"map": {"file": "map.dat"}}, "terms": {"zernike": {"n_max": 6}}, "trace": {"rays": 4096},
                   "output": {"pictures": "none", "export": ["zemax-grid-sag", "zernike-noll", "codev-int", "codev-zfr", "fits-opd", "csv"],
                              "export_grid": 65})",
          "24.5 mm"));
  ASSERT_EQ(run_program(folder, "fit study.json --json -o out"), 0) << read_file(folder.file("stderr.txt"));
  const ordered_json result = ordered_json::parse(read_file(folder.file("stdout.txt")));
  EXPECT_EQ(result["fit"]["status"], "converged");
  EXPECT_EQ(result["map"]["rank"], 25);
  const double before = result["map"]["rms_map_m"], after = result["map"]["rms_residual_m"];
  double sum = 0, squares = 0, count = 0;
  for (const double h : made.map.height.reshaped())
    if (!std::isnan(h)) sum += h, squares += h * h, ++count;
  // The RMS refers to all heights; one tenth of the points is held out.
  EXPECT_NEAR(before / std::sqrt(squares / count - std::pow(sum / count, 2)), 1, 0.01);
  EXPECT_LT(after, before);
  EXPECT_NEAR(result["map"]["rms_held_out_m"].get<double>(), after, 0.05 * after);
  // The listing that goes to OpticStudio holds the coefficients of the result.
  const auto listing = test::read_zernike_listing(read_file(folder.file("out/exports/zernike_standard.txt")));
  for (const auto& term : result["coefficients"]["zernike"]) {
    const std::size_t j = term["noll"].get<std::size_t>();
    ASSERT_LE(j, listing.waves.size());
    EXPECT_NEAR(listing.waves[j - 1] * listing.wavelength, term["value_m"].get<double>(), 1e-14);
  }
  for (const char* name : {"grid_sag.DAT", "surface.int", "zernike_fringe.int", "opd.fits", "surface.csv"})
    EXPECT_TRUE(fs::exists(folder.file(std::string("out/exports/") + name))) << name;
  // The exported map states its format, so its points equal the other export without an option.
  MeasuredSource exported;
  exported.path = folder.file("out/exports/opd.fits");
  const HeightMap opd = std::get<HeightMap>(read_measurement(exported));
  std::istringstream points(read_file(folder.file("out/exports/surface.csv")));
  Eigen::Index seen = 0;
  for (std::string line; std::getline(points, line);) {
    double x = 0, y = 0, h = 0;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &x, &y, &h) != 3) continue;
    const double found = opd.height(Eigen::Index(std::lround((y - opd.y0) / opd.pitch_y)),
                                    Eigen::Index(std::lround((x - opd.x0) / opd.pitch_x)));
    ASSERT_NEAR(found, h, 1e-9 * std::abs(h) + 1e-21) << line;
    ++seen;
  }
  EXPECT_EQ(seen, valid_count(opd));
  EXPECT_GT(seen, 1000);
}

// A FITS image of 48 x 48 integers without any shape.
std::string fits_card(const std::string& key, const std::string& value) {
  const std::string card = key + std::string(8 - key.size(), ' ') + "= " + value;
  return card + std::string(80 - card.size(), ' ');
}
std::string fits_image(bool primary, const std::string& more, double scale) {
  constexpr int kSide = 48;
  std::string bytes = (primary ? fits_card("SIMPLE", "T") : fits_card("XTENSION", "'IMAGE   '")) +
                      fits_card("BITPIX", "16") + fits_card("NAXIS", "2") +
                      fits_card("NAXIS1", std::to_string(kSide)) +
                      fits_card("NAXIS2", std::to_string(kSide)) +
                      (primary ? "" : fits_card("PCOUNT", "0") + fits_card("GCOUNT", "1")) + more + "END";
  bytes.resize((bytes.size() + 2879) / 2880 * 2880, ' ');
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const auto height = int(scale * std::sin(1.7 * row * row + 0.9 * column * column + row * column));
      bytes += char(height >> 8), bytes += char(height);
    }
  bytes.resize((bytes.size() + 2879) / 2880 * 2880, '\0');
  return bytes;
}

TEST(PsdCommand, ChoosesTheImageOfAFitsFileAndSaysSo) {
  const ScratchFolder folder;
  const std::string said = fits_card("BUNIT", "'nm'") + fits_card("CDELT1", "1.0") +
                           fits_card("CUNIT1", "'mm'") + fits_card("CDELT2", "1.0") +
                           fits_card("CUNIT2", "'mm'");
  folder.write("one.fits",
               fits_image(true, "", 100) + fits_image(false, fits_card("EXTNAME", "'OPD'") + said, 1000));
  folder.write("two.fits", fits_image(true, said, 100) + fits_image(false, said, 1000));
  const auto psd = [&](const std::string& options) {
    run_program(folder, "psd " + options + " --of surface --json --pictures none --keep-lines");
    return ordered_json::parse(read_file(folder.file("stdout.txt")));
  };
  const ordered_json chosen = psd("one.fits");
  EXPECT_EQ(chosen["warnings"][0]["code"], "image-chosen");
  const std::string message = chosen["warnings"][0]["message"];
  EXPECT_NE(message.find("1 'OPD' (48 x 48, nm), hdu 1 is read"), std::string::npos) << message;
  EXPECT_NE(message.find("--hdu"), std::string::npos) << message;
  // If the HDU is named, there is no warning.
  const ordered_json named = psd("one.fits --hdu opd");
  for (const auto& warning : named["warnings"]) EXPECT_NE(warning["code"], "image-chosen");
  EXPECT_EQ(named["request"]["hdu"], "opd");
  EXPECT_EQ(named["estimate"]["rms_height_m"], chosen["estimate"]["rms_height_m"]);
  // With two candidates the program asks, and reads each by its number.
  EXPECT_EQ(run_program(folder, "psd two.fits --of surface"), 2);
  const std::string error = read_file(folder.file("stderr.txt"));
  EXPECT_NE(error.find("images 0 (48 x 48, nm), 1 (48 x 48, nm)"), std::string::npos) << error;
  EXPECT_NE(error.find("--hdu"), std::string::npos) << error;
  const double first = psd("two.fits --hdu 0")["estimate"]["rms_height_m"],
               second = psd("two.fits --hdu 1")["estimate"]["rms_height_m"];
  EXPECT_NEAR(second / first, 10, 0.2);  // integers of up to 100 nm are rounded
  // One message names all open questions, and the keys of a study.
  folder.write("open.fits", fits_image(true, "", 100) + fits_image(false, "", 100));
  EXPECT_EQ(run_program(folder, "psd open.fits"), 2);
  const std::string open = read_file(folder.file("stderr.txt"));
  EXPECT_NE(open.find("which of its images to read (images 0 (48 x 48, no unit)"), std::string::npos) << open;
  EXPECT_NE(open.find("--hdu NAME|N, --of surface|wavefront, --value-unit"), std::string::npos) << open;
  const auto study_file = [](const std::string& hdu) {
    return R"({"psd": {"model": "measured", "file": "two.fits", "of": "surface", "find_lines": false, "hdu": )" +
           hdu + "}}";
  };
  folder.write("study.json", study_with(", \"roughness\": " + study_file("1")));
  run_program(folder, "psd study.json --json --pictures none -o of_study");
  EXPECT_EQ(ordered_json::parse(read_file(folder.file("stdout.txt")))["estimate"]["rms_height_m"], second);
  folder.write("study.json", study_with(", \"roughness\": " + study_file("1.5")));
  EXPECT_EQ(run_program(folder, "psd study.json"), 2);
  EXPECT_NE(read_file(folder.file("stderr.txt")).find("/roughness/psd/hdu"), std::string::npos);
}

TEST(PsdTargets, AreMetBesideTheFocus) {
  const Study study = parse_study(
      study_with(
          R"(, "roughness": {"psd": {"model": "uniform", "rms": "100 nm", "f_min": "2.5 /m", "f_max": "19.96 /m"}},
                     "target": {"theory": "geometric", "statistics": {"ee50": {}, "ee90": {}, "scatter_rms": {}, "rms_height": {}},
                                "psd": {"f_min": "6 /m", "f_max": "18 /m", "bins_per_decade": 12, "tolerance": "2 %"}},
                     "terms": {"zernike": {"n_max": 28}}, "trace": {"rays": 16384})"),
      "study.json");
  const ResultDocument result = run_fit(study, {});
  EXPECT_EQ(result.fitted.fit.status, FitStatus::kConverged) << result.fitted.fit.message;
  ASSERT_EQ(result.fitted.spectrum.size(), 6u);
  const double flat = 1e-14 / (EIGEN_PI * (19.96 * 19.96 - 2.5 * 2.5));  // P0 of the specification
  for (const SpectrumBin& bin : result.fitted.spectrum) {
    EXPECT_LT(std::abs(std::log(bin.fitted / bin.target)), 0.02) << bin.low;
    // Inside the band the mean over realisations is the specification, except for the blur by the disc.
    EXPECT_NEAR(bin.target / flat, 1, 0.15) << bin.low;
  }
}

}  // namespace
}  // namespace aberfit
