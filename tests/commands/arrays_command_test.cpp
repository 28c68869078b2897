// --arrays and output.arrays from the outside: which files are written, what their folder holds before and
// after, and the message if there is nothing to write.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "report/fits_reader.h"
#include "report/npz_reader.h"
#include "study/run_program.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using test::NpzReader;
using test::read_file;
using test::run_program;
using test::ScratchFolder;

// A study smooth enough for waves, with few grid points.
std::string study_text(const std::string& theory, const std::string& output = "") {
  return R"({
  "aberfit": 1, "title": "arrays",
  "mirror": { "focal_length": "2.8 m" },
  "aperture": { "shape": "circle", "diameter": "0.4 m" },
  "light": { "wavelength": "632.8 nm" },
  "roughness": { "psd": { "model": "uniform", "rms": "50 nm", "f_min": "2.5 /m", "f_max": "5 /m" } },
  "terms": { "zernike": { "n_max": 8 } }, "trace": { "rays": 4096 },
  "fit": { "starts": 1, "max_iterations": 3 },
  "target": { "theory": ")" +
         theory + R"(", "statistics": { "ee50": {}, "ee90": { "planes": ["0 mm", "0.1 mm"] } } })" + output +
         "\n}\n";
}

std::set<std::string> files_below(const std::string& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder)) return names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with('.'))
      names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

class ArraysCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("waves.json", study_text("ghs"));
    folder_.write("rays.json", study_text("geometric"));
    folder_.write("asks.json", study_text("ghs", R"(, "output": { "pictures": "none", "arrays": "npz" })"));
  }
  int run(const std::string& arguments) const { return run_program(folder_, arguments); }
  std::string file(const std::string& name) const { return folder_.file(name); }
  std::string err() const { return read_file(file("stderr.txt")); }
  std::set<std::string> warnings(const std::string& result) const {
    std::set<std::string> codes;
    const ordered_json read = ordered_json::parse(read_file(file(result)));
    for (const ordered_json& warning : read["warnings"]) codes.insert(warning["code"].get<std::string>());
    return codes;
  }

  ScratchFolder folder_;
};

TEST_F(ArraysCommand, FitWritesThemWithItsResultAndAnotherRunReplacesThem) {
  EXPECT_LE(run("fit waves.json --pictures none --arrays npz -o out"), 1) << err();
  EXPECT_EQ(files_below(file("out")).count("arrays.npz"), 1u);
  const NpzReader npz(read_file(file("out/arrays.npz")));
  // The theory's curve, read at the radius in the result.
  const ordered_json result = ordered_json::parse(read_file(file("out/result.json")));
  EXPECT_EQ(npz.at("plane_dz_m").values, (std::vector<double>{0, 0.1e-3}));
  const auto& radius = npz.at("ee_radius_m").values;
  const auto share_at = [&](const std::string& name, std::size_t plane, double at) {
    const auto next = std::size_t(std::lower_bound(radius.begin(), radius.end(), at) - radius.begin());
    const double* share = npz.at(name).values.data() + plane * radius.size();
    return share[next - 1] +
           (at - radius[next - 1]) / (radius[next] - radius[next - 1]) * (share[next] - share[next - 1]);
  };
  ASSERT_EQ(result["target"].size(), 3u);
  for (const auto& [name, target] : result["target"].items()) {
    const std::size_t plane = name.ends_with("@0.1mm") ? 1 : 0;
    EXPECT_NEAR(share_at("ee_theory", plane, target["value"]), name.starts_with("ee50") ? 0.5 : 0.9, 1e-4)
        << name;
    const double fitted = result["statistics"]["fitted"][name];
    EXPECT_NEAR(share_at("ee_surface", plane, fitted), name.starts_with("ee50") ? 0.5 : 0.9, 1e-4) << name;
  }
  EXPECT_EQ(warnings("out/result.json").count("arrays-left-out"), 0u);

  // The files of one run are a unit; those of the next run replace them.
  EXPECT_LE(run("fit waves.json --pictures none --arrays fits -o out"), 1) << err();
  const std::set<std::string> after = files_below(file("out"));
  EXPECT_EQ(after.count("arrays.npz"), 0u);
  EXPECT_TRUE(after.contains("psf.fits") && after.contains("otf.fits"));
  EXPECT_EQ(test::read_fits_units(read_file(file("out/psf.fits"))).size(), 2u);
  EXPECT_LE(run("fit waves.json --pictures none -o out"), 1);
  EXPECT_EQ(files_below(file("out")).count("psf.fits"), 0u);
}

TEST_F(ArraysCommand, TheCommandLineOverridesTheStudy) {
  EXPECT_LE(run("fit asks.json -o a"), 1) << err();
  EXPECT_EQ(files_below(file("a")).count("arrays.npz"), 1u);
  EXPECT_LE(run("fit asks.json --arrays none -o b"), 1) << err();
  EXPECT_EQ(files_below(file("b")),
            (std::set<std::string>{"coefficients.csv", "report.html", "result.json", "summary.txt"}));
  EXPECT_LE(run("fit asks.json --arrays csv -o c"), 1) << err();
  EXPECT_EQ(files_below(file("c")).count("arrays.npz"), 0u);
  EXPECT_EQ(files_below(file("c")).count("arrays/mtf.csv"), 1u);
  EXPECT_EQ(run("fit waves.json --arrays npy -o d"), 2);
  EXPECT_NE(err().find("npz"), std::string::npos) << err();
  EXPECT_FALSE(fs::exists(file("d")));
}

// Commands that write nothing else use a folder of their own, beside that of the fit.
TEST_F(ArraysCommand, TraceAndCheckWriteOnlyWhereAsked) {
  EXPECT_EQ(run("trace waves.json"), 0) << err();
  EXPECT_FALSE(fs::exists(file("out")));
  for (const char* command : {"trace", "check"}) {
    EXPECT_EQ(run(command + std::string(" waves.json -o out")), 2);
    EXPECT_NE(err().find("--arrays"), std::string::npos) << err();
    EXPECT_FALSE(fs::exists(file("out")));
  }
  EXPECT_EQ(run("trace waves.json --arrays npz"), 0) << err();
  EXPECT_EQ(files_below(file("out")),
            (std::set<std::string>{"waves/trace/arrays.npz", "waves/trace/report.html",
                                   "waves/trace/result.json", "waves/trace/summary.txt"}));
  EXPECT_NE(err().find("out/waves/trace"), std::string::npos) << err();
  const NpzReader traced(read_file(file("out/waves/trace/arrays.npz")));
  EXPECT_TRUE(traced.arrays().contains("ee_surface") && traced.arrays().contains("mtf_surface_x"));
  EXPECT_EQ(run("check waves.json --arrays csv -o elsewhere"), 0) << err();
  EXPECT_EQ(files_below(file("elsewhere")),
            (std::set<std::string>{"arrays/encircled_energy.csv", "arrays/mtf.csv", "arrays/psf_theory.csv",
                                   "arrays/ring_profile.csv", "report.html", "result.json", "summary.txt"}));
  EXPECT_EQ(ordered_json::parse(read_file(file("elsewhere/result.json")))["kind"], "check");
}

TEST_F(ArraysCommand, RaysHaveNoTransferFunctionAndSayIt) {
  EXPECT_EQ(run("trace rays.json --arrays fits -o rays"), 0) << err();
  EXPECT_EQ(files_below(file("rays")),
            (std::set<std::string>{"psf.fits", "report.html", "result.json", "summary.txt"}));
  EXPECT_EQ(warnings("rays/result.json").count("arrays-left-out"), 1u);
  EXPECT_EQ(run("trace waves.json --arrays fits -o waves"), 0) << err();
  EXPECT_EQ(warnings("waves/result.json").count("arrays-left-out"), 0u);
}

}  // namespace
}  // namespace aberfit
