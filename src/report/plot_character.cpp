#include <fmt/format.h>

#include "picture.h"

namespace aberfit::internal {
namespace {

// One row per bin or zone: edges, value and the band of draws.
template <class Rows>
std::vector<Eigen::ArrayXd> columns(const Rows& rows, auto low, auto high) {
  std::vector<Eigen::ArrayXd> result(6, Eigen::ArrayXd(Eigen::Index(rows.size())));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto k = Eigen::Index(i);
    const BesideDraws& ratio = rows[i].ratio;
    result[0][k] = low(rows[i]), result[1][k] = high(rows[i]);
    result[2][k] = ratio.value, result[3][k] = ratio.mean;
    result[4][k] = ratio.low, result[5][k] = ratio.high;
  }
  return result;
}

std::string curves(const std::string& file, const std::string& middle) {
  return fmt::format(
      "'{0}' using ({1}):5:6 with filledcurves fillcolor rgb '#cfe3f1' title '99 % of draws', \\\n"
      "  '{0}' using ({1}):4 with lines linetype 2 title 'draws, mean', \\\n"
      "  '{0}' using ({1}):3 with linespoints linecolor rgb '{2}' linewidth 2 pointtype 7 title 'fitted'\n",
      file, middle, kFittedColour);
}

}  // namespace

// Left, the PSD over that of the specification; right, slopes by zone; both in the band of draws.
Picture character_picture(const PlotInput& input) {
  const Character& character = *input.result.character;
  Picture picture{"character", script_head("character", 1200, 720), {}};
  const std::vector<std::string> header = {
      "value of the surface, mean of draws, and the band that holds 99 % of draws",
      "columns: low edge, high edge, value, mean, band low, band high"};
  const bool has_psd = !character.psd.empty();
  if (has_psd) {
    auto psd = header;
    psd.insert(psd.begin(), "PSD over the mean of draws of the specification; edges f_per_m [cycles/m]");
    picture.add_columns("character_psd.dat", psd,
                        columns(
                            character.psd, [](const CharacterBin& b) { return b.low; },
                            [](const CharacterBin& b) { return b.high; }));
  }
  auto zones = header;
  zones.insert(zones.begin(),
               "RMS slope of zones as a share of that of the aperture; edges in aperture radii");
  picture.add_columns("character_zones.dat", zones,
                      columns(
                          character.zones, [](const ZoneSlope& z) { return z.rho_min; },
                          [](const ZoneSlope& z) { return z.rho_max; }));
  picture.script += fmt::format("set multiplot layout 1,{} title {} noenhanced\n", has_psd ? 2 : 1,
                                picture_title(input, "The surface beside draws of its roughness"));
  if (has_psd)
    picture.script += fmt::format(
        "set logscale xy\nset xrange [{:.6g}:{:.6g}]\nset xlabel 'spatial frequency [cycles/m]'\n"
        "set ylabel 'PSD over that of the specification'\nset format '%g'\nset xtics {}\n"
        "set yrange [*<0.3:3<*]\nset ytics (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)\nplot {}",
        character.psd.front().low, character.psd.back().high,
        log_tics(character.psd.front().low, character.psd.back().high),
        curves("character_psd.dat", "sqrt($1*$2)"));
  picture.script +=
      "unset logscale\nset xtics autofreq\nset ytics autofreq\nset xrange [0:1]\nset yrange [*<0.8:1.2<*]\n"
      "set xlabel 'distance from the axis [aperture radii]'\n"
      "set ylabel 'RMS slope over that of the aperture'\nplot " +
      curves("character_zones.dat", "0.5*($1+$2)") + "unset multiplot\n";
  return picture;
}

}  // namespace aberfit::internal
