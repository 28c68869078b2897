// Fuzzes the options that a user types after `aberfit psd FILE`. Each line is one option, "key text". A first
// line "map" selects a small map, otherwise a small profile is measured.
#include "../../src/commands/psd_options.h"

#include <algorithm>
#include <cmath>

#include "aberfit/core/text.h"
#include "aberfit/measured/write_map.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/read_study.h"
#include "harness.h"
#include "targets.h"

namespace aberfit::test {
namespace {

std::string small_profile() {
  std::string text = "x_mm,height_nm\n";
  for (int i = 0; i < 48; ++i)
    text += std::to_string(i) + "," + std::to_string(std::sin(0.7 * i) + 0.4 * std::sin(1.3 * i * i)) + "\n";
  return text;
}

std::string small_surface() {
  HeightMap map;
  map.height = Grid(12, 14);
  for (Eigen::Index i = 0; i < map.height.size(); ++i)
    map.height.data()[i] = 1e-9 * std::sin(0.9 * double(i) + 0.01 * double(i * i));
  map.pitch_x = map.pitch_y = 1e-3;
  centre_on_grid(&map);
  return map_csv(map);
}

bool of_file(std::string_view key) {
  constexpr std::string_view kKeys[] = {
      "format",    "column",     "quantity", "of",   "x_unit", "value_unit", "pitch", "columns",
      "first_row", "wavelength", "scale",    "mask", "erode",  "aperture",   "hdu",   "plane"};
  return std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
}

void read_options(std::string_view bytes) {
  static const std::string profile = fuzz_folder().write("profile.csv", small_profile());
  static const std::string map = fuzz_folder().write("map.csv", small_surface());
  fuzz_folder().write("mask.txt", "1 1\n0 1\n");
  CommandLine line;
  std::vector<std::string_view> lines = words(bytes, "\n");
  const bool of_map = !lines.empty() && lines.front() == "map";
  line.measured_files = {of_map ? map : profile};
  if (of_map) lines.erase(lines.begin());
  for (const std::string_view text : lines) {
    const std::size_t cut = std::min(text.find(' '), text.size());
    const std::string key(text.substr(0, cut)), value(trimmed(text.substr(cut)));
    if (key == "further") line.measured_files.push_back(of_map ? map : profile);
    if (key != "further" && key != "file")
      (of_file(key) ? line.psd_of_file : line.psd_of_block).emplace_back(key, value);
  }
  if (line.measured_files.size() > 4) return;  // each takes time, and the fifth adds nothing
  read_or_refuse([&] {
    const MeasuredPsd measured = read_measured(internal::psd_options_block(line), kCommandLine, 1);
    require(measured.estimate.psd.isFinite().all(), "a PSD is finite");
  });
}

std::vector<std::string> option_seeds() {
  return {
      "quantity height\nof surface\ndetrend ellipse\nfamily k-correlation",
      "aperture interval:length=90%,centre=1mm\nbands low=0.02/mm..0.1/mm,mid=0.1/mm..0.4/mm\nerode 2",
      "map\naperture annulus:outer=95%,inner=30%,centre=0 mm,1e-3\ndetrend zernike\ndegree 3",
      "map\nwindow tukey\nbins_per_decade 5\nconfidence 95 %\nf_min 80 /m\nf_max 0.4 /mm\noutliers reject",
      "x_unit mm\nvalue_unit waves\nwavelength 633 nm\nscale 2\nwindow welch\nfamily power-law-and-floor",
      "map\naperture rectangle:width=5 mm,height=80%\nmask mask.txt\npitch 1 mm\ncolumn 1\nfurther"};
}

}  // namespace

std::vector<FuzzTarget> psd_targets() { return {{"psd-options", read_options, option_seeds, 512}}; }

}  // namespace aberfit::test
