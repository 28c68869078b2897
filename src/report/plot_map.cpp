#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "map_report.h"
#include "picture.h"

namespace aberfit::internal {
namespace {

// Points a side of a drawn map, at most: beyond, every second, third, ... is shown.
constexpr Eigen::Index kMostDrawn = 512;
constexpr double kShownShare = 0.999;  // of the heights; a spike takes the last colour, not all the others

// Largest height but for the share that kShownShare leaves out [m].
double colour_reach(const std::vector<const Grid*>& maps) {
  std::vector<double> heights;
  for (const Grid* map : maps)
    for (const double h : map->reshaped())
      if (std::isfinite(h)) heights.push_back(std::abs(h));
  if (heights.empty()) return 1e-12;
  const auto at = std::ptrdiff_t(kShownShare * double(heights.size() - 1));
  std::nth_element(heights.begin(), heights.begin() + at, heights.end());
  return std::max(heights[std::size_t(at)], 1e-12);
}

Eigen::ArrayXXd thinned(const Grid& height, Eigen::Index step) {
  const auto every = [&](Eigen::Index n) { return Eigen::seqN(0, (n + step - 1) / step, step); };
  return height(every(height.rows()), every(height.cols()));
}

std::string screen_margins(double left, double right, double bottom, double top) {
  return fmt::format("set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n", left, right) +
         fmt::format("set bmargin at screen {:.4f}\nset tmargin at screen {:.4f}\n", bottom, top);
}

std::string nanometres(double metres) { return fmt::format("{:.4g} nm", 1e9 * metres); }

struct MapPanelPlace {
  const char* key;
  const char* label;
  const MapPanel& panel;
  double reach;  // of the colours [m]
  double left;   // on the screen
  bool colours;  // beside it
};

}  // namespace

/// The map, its terms and what they leave, on the same axes; the first two in the same colours.
Picture map_heights_picture(const PlotInput& input) {
  const std::string name = "map_heights";
  constexpr double kWidth = 0.235, kBottom = 0.13, kTop = 0.85;
  const MapPanels& panels = *input.result.map_panels;
  const HeightMap& map = panels.measured.map;
  const Eigen::Index step = (std::max(map.rows(), map.columns()) + kMostDrawn - 1) / kMostDrawn;
  const double both = colour_reach({&map.height, &panels.fitted.map.height});
  const MapPanelPlace places[] = {
      {"measured", "measured", panels.measured, both, 0.065, false},
      {"fitted", "fitted terms", panels.fitted, both, 0.335, true},
      {"residual", "residual", panels.residual, colour_reach({&panels.residual.map.height}), 0.685, true}};
  Picture picture{name, script_head(name, 1800, 640), {}};
  picture.script += fmt::format(
      "p = {:.9g}; q = {:.9g}; x0 = {:.9g}; y0 = {:.9g}  # pitch along x and y, first point [mm]\n"
      "set multiplot title {} font 'DejaVu Sans,16'\n"
      "unset key\nunset grid\nset size ratio -1\nset tics out\n{}"
      "set xlabel 'x [mm]'\nset xrange [{:.9g}:{:.9g}]\nset yrange [{:.9g}:{:.9g}]\n",
      map.pitch_x * double(step) * 1e3, map.pitch_y * double(step) * 1e3, map.x0 * 1e3, map.y0 * 1e3,
      picture_title(input, "Measured map without piston and tilt, its terms, and what they leave"),
      signed_palette(), (map.x0 - map.pitch_x) * 1e3, (map.x(map.columns() - 1) + map.pitch_x) * 1e3,
      (map.y0 - map.pitch_y) * 1e3, (map.y(map.rows() - 1) + map.pitch_y) * 1e3);
  for (const MapPanelPlace& place : places) {
    const std::string file = fmt::format("{}_{}.dat", name, place.key);
    picture.add_matrix(
        file,
        {fmt::format(
             "Height [m] of the surface, {}, positive towards the light, piston and tilt of the mount "
             "off; nan where nothing was measured; RMS {:.6g}, peak to valley {:.6g} of all points",
             place.label, place.panel.rms, place.panel.peak_to_valley),
         fmt::format("rows from -y to +y, columns from -x to +x, every {} of the map's points; the first at "
                     "{:.9g}, {:.9g} m",
                     step, map.x0, map.y0)},
        thinned(place.panel.map.height, step));
    picture.script += screen_margins(place.left, place.left + kWidth, kBottom, kTop);
    picture.script += fmt::format(
        "set title {}\n{}{}{}plot '{}' matrix using ($1*p+x0):($2*q+y0):($3*1e9) with image\n",
        gnuplot_text(fmt::format("{}: RMS {}, PV {}", place.label, nanometres(place.panel.rms),
                                 nanometres(place.panel.peak_to_valley))),
        place.left < 0.1 ? "set ylabel 'y [mm]'\n" : "set format y ''\nunset ylabel\n",
        symmetric_range("cb", place.reach * 1e9),
        place.colours ? fmt::format("set colorbox user origin screen {:.4f},{:.4f} size screen 0.012,{:.4f}\n"
                                    "set cblabel {} offset 1,0\n",
                                    place.left + kWidth + 0.008, kBottom + 0.03, kTop - kBottom - 0.06,
                                    gnuplot_text(place.left < 0.5 ? "height of both [nm], colours of 99.9 %"
                                                                  : "height [nm], colours of 99.9 %"))
                      : "unset colorbox\n",
        file);
  }
  picture.script += "unset multiplot\n";
  return picture;
}

namespace {

constexpr double kFaintest = 1e-5;  // of the perfect mirror's peak

// Line of each column's curve, in their order.
const char* const kMapLines[] = {"linetype 2", "linetype 3",
                                 "linecolor rgb '#009E73' linewidth 2.5 dashtype (4,4)", "linetype 1"};

std::string map_light_curves(const MapLight& light, const AxisUnit& unit, const std::string& name) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < light.columns().size(); ++k) {
    const LitSurface& lit = *light.columns()[k];
    if (!lit.obstacle.empty()) continue;
    lines.push_back(fmt::format(
        "'{}.dat' using ($1*u):{} with lines {} title {}", name, k + 2, kMapLines[k],
        gnuplot_text(fmt::format("{}: ee50 {}, ee80 {}, ee90 {}, FWHM {}", kMapColumns[k].label,
                                 display(lit.ee50, Dimension::kLength), display(lit.ee80, Dimension::kLength),
                                 display(lit.ee90, Dimension::kLength),
                                 display(lit.spot_fwhm, Dimension::kLength)))));
  }
  if (lines.empty()) return "";
  return fmt::format(
      "unset title\nset size noratio\nset grid\nset xrange [0:{:.9g}]\nset yrange [0:1.05]\nset ytics 0.2\n"
      "set format y '%g'\nset xlabel 'radius [{}]'\nset ylabel 'share of the light within'\n"
      "set key bottom right inside vertical maxcols 1 Left reverse\n"
      "plot {}\n",
      light.radius[light.radius.size() - 1] * unit.per_si, unit.name, fmt::join(lines, kNextCurve));
}

// One image with the diameter of the line spread (dashed) and the radius of 80 % of the light.
std::string map_light_image(const LitSurface& lit, const char* label, const std::string& file) {
  std::string plot = fmt::format(
      "set title {}\nfwhm = {:.9g}; ee80 = {:.9g}  # [m]\n"
      "plot '{}' matrix using ($1*p+o):($2*p+o):($3>lowest?$3:lowest) with image notitle",
      gnuplot_text(fmt::format("{}: Strehl {:.4f}", label, lit.strehl)), lit.spot_fwhm, lit.ee80, file);
  for (const auto& [circle, radius, dash] :
       {std::tuple{"0.5*fwhm", 0.5 * lit.spot_fwhm, "(4,4)"}, {"ee80", lit.ee80, "1"}})
    if (radius < -lit.psf.first)
      plot += fmt::format(
          ", \\\n  [0:2*pi] '+' using ({0}*u*cos($1)):({0}*u*sin($1)) with lines linecolor rgb 'white' "
          "linewidth 1.2 dashtype {1} notitle",
          circle, dash);
  return plot + "\n";
}

}  // namespace

/// Encircled energies and diffraction patterns of the map, of its terms, and of these with the residual's
/// PSD.
Picture map_light_picture(const PlotInput& input) {
  const std::string name = "map_light";
  constexpr double kWidth = 0.26, kStep = 0.285, kLeft = 0.07;
  const MapLight& light = *input.result.map_light;
  const AxisUnit unit = length_unit(light.radius[light.radius.size() - 1]);
  std::vector<Eigen::ArrayXd> curves = {light.radius};
  for (const LitSurface* lit : light.columns())
    curves.push_back(lit->share.size() > 0 ? lit->share : Eigen::ArrayXd::Constant(light.radius.size(), NAN));
  Picture picture{name, "", {}};
  picture.add_columns(name + ".dat",
                      {"Share of the light within a radius of the nominal focus, at z = f",
                       "columns: radius_m measured terms terms_and_residual_psd perfect (nan: no light)"},
                      curves);
  const PsfImage& first = light.perfect.psf;
  const bool images = first.intensity.size() > 0;
  picture.script =
      script_head(name, 1500, images ? 1080 : 620) +
      fmt::format(
          "u = {:.9g}  # axis units per metre\n"
          "p = {:.9g}; o = {:.9g}; lowest = {:.9g}\n"
          "set samples 181\n"
          "set multiplot title {} font 'DejaVu Sans,16'\n",
          unit.per_si, first.pitch * unit.per_si, first.first * unit.per_si, kFaintest,
          picture_title(input, "Light of the map in focus (circles: ee80; dashed, across: FWHM)"));
  if (images) {
    picture.script += fmt::format(
        "unset key\nunset grid\nset size ratio -1\nset tics out\n{}{}"
        "set logscale cb\nset cbrange [lowest:1]\nset format cb '%.0e'\n"
        "set cblabel {} offset 1,0\nset palette defined (0 '#000004', 1 '#1b0c41', 2 '#4a0c6b', 3 '#781c6d', "
        "4 "
        "'#a52c60', 5 '#cf4446', 6 '#ed6925', 7 '#fb9b06', 8 '#f7d13d', 9 '#fcffa4')\n"
        "set xlabel 'x [{}]'\nset ylabel 'y [{}]'\n",
        symmetric_range("x", -first.first * unit.per_si), symmetric_range("y", -first.first * unit.per_si),
        gnuplot_text("irradiance / perfect mirror's peak"), unit.name, unit.name);
    for (std::size_t k = 0; k < 3; ++k) {
      const LitSurface& lit = *light.columns()[k];
      if (lit.psf.intensity.size() == 0) continue;
      const std::string file = fmt::format("{}_{}.dat", name, kMapColumns[k].key);
      picture.add_matrix(
          file,
          {fmt::format("Irradiance over the peak of the perfect mirror, {}", kMapColumns[k].label),
           fmt::format("samples {:.9g} m apart, rows from -y to +y, columns from -x to +x, the "
                       "first at {:.9g} m in x and y",
                       lit.psf.pitch, lit.psf.first)},
          lit.psf.intensity);
      const double left = kLeft + double(k) * kStep;
      picture.script += screen_margins(left, left + kWidth, 0.52, 0.90);
      if (k > 0) picture.script += "set format y ''\nunset ylabel\n";
      picture.script +=
          k < 2 ? "unset colorbox\n" : "set colorbox user origin screen 0.908,0.54 size screen 0.014,0.34\n";
      picture.script += map_light_image(lit, kMapColumns[k].label, file);
    }
  }
  picture.script += screen_margins(kLeft, 0.97, images ? 0.07 : 0.12, images ? 0.43 : 0.88);
  picture.script += map_light_curves(light, unit, name) + "unset multiplot\n";
  return picture;
}

}  // namespace aberfit::internal
