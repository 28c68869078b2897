#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/report/psd_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr const char* kLineColour = "#CC79A7";

/// Bins of the surface's PSD with their intervals, the fitted model, and lines.
Picture psd_picture(const PsdReport& report) {
  const PsdEstimate& e = report.estimate;
  const SurfacePsd& s = report.surface;
  const bool profiles = e.kind == PsdTableKind::k1dOneSided;
  const std::string name = "psd";
  const Eigen::ArrayXd model =
      (s.frequency >= report.fit.f_min && s.frequency <= report.fit.f_max).select(s.model, NAN);
  Picture picture{name, script_head(name, 1200, 800), {}};
  picture.add_columns(name + ".dat",
                      {fmt::format("PSD of the surface in {}",
                                   profiles ? "m^3, one-sided, of the profile" : "m^4, two-sided"),
                       "frequency [1/m], PSD, lower and upper end of the interval, model"},
                      {s.frequency, s.psd, s.lower, s.upper, model});
  // Axes: cycles/mm, and the units in which opticians quote PSDs.
  std::string marks;
  for (const SpectralLine& line : e.lines)
    marks += fmt::format(
        "set arrow from first {0:.9g}, graph 0 to first {0:.9g}, graph 1 nohead linecolor rgb '{1}' dashtype "
        "2\n",
        1e-3 * line.frequency, kLineColour);
  picture.script += fmt::format(
      "u = 1e-3  # cycles/mm\n"
      "s = {0}  # nm^2 and mm\n"
      "set termoption enhanced\n"
      "set title {1} noenhanced\n"
      "set logscale xy\nset format x '10^{{%L}}'\nset format y '10^{{%L}}'\n"
      "set xlabel 'spatial frequency [cycles/mm]'\nset ylabel '{2}'\n"
      "set grid xtics ytics\n"
      "{3}"
      "plot '{4}.dat' using ($1*u):($2*s):($3*s):($4*s) with yerrorbars pointtype 7 pointsize 0.8 linecolor "
      "rgb '{5}' linewidth 1.2 dashtype 1 title 'estimate, {6:.4g} % intervals', \\\n"
      "  '' using ($1*u):($5*s) with lines linecolor rgb '{7}' linewidth 2.5 dashtype 1 title 'model: "
      "{8}'{9}\n",
      profiles ? "1e21" : "1e24",
      picture_title(profiles ? "PSD of the profile" : "PSD of the surface", report.title),
      profiles ? "one-sided PSD [nm² mm]" : "two-sided 2-D PSD [nm² mm²]", marks, name, kTargetColour,
      100 * e.options.confidence, kFittedColour, to_string(report.fit.family),
      e.lines.empty()
          ? ""
          : fmt::format(
                ", \\\n  NaN with lines linecolor rgb '{}' dashtype 2 title 'spectral lines, left out'",
                kLineColour));
  return picture;
}

/// Structure functions of the measurements, one curve each, and of the model.
Picture structure_function_picture(const PsdReport& report) {
  const std::string name = "structure_function";
  Picture picture{name, script_head(name, 1200, 800), {}};
  picture.script += fmt::format(
      "set title {} noenhanced\nset termoption enhanced\nset logscale xy\nset format x '10^{{%L}}'\n"
      "set format y '10^{{%L}}'\nset xlabel 'separation s [mm]'\n"
      "set ylabel 'mean square difference D(s) [nm²]'\nset grid xtics ytics\nset key bottom right\nplot ",
      picture_title("Structure function, detrended", report.title));
  for (std::size_t i = 0; i < report.differences.size(); ++i) {
    const HeightDifferences& d = report.differences[i];
    const std::string file = i == 0 ? name + ".dat" : fmt::format("{}_{}.dat", name, i + 1);
    picture.add_columns(file, {"separation [m], D of the measurement [m^2], D of the model"},
                        {d.separation, d.mean_square,
                         model_height_differences(report.fit, report.estimate.kind, d.separation)});
    picture.script += fmt::format(
        "{0}'{1}' using ($1*1e3):($2*1e18) with points pointtype {2} pointsize 0.9 linecolor rgb '{3}' title "
        "'measured{4}'",
        i == 0 ? "" : kNextCurve, file, 7 + 2 * int(i), kTargetColour,
        report.differences.size() > 1 ? fmt::format(", file {}", i + 1) : "");
    picture.script += fmt::format(
        "{}'{}' using ($1*1e3):($3*1e18) with lines linecolor rgb '{}' linewidth 2.5 dashtype 1 {}",
        kNextCurve, file, kFittedColour,
        i == 0 ? "title 'model in its band: " + to_string(report.fit.family) + "'" : std::string("notitle"));
  }
  picture.script += "\n";
  return picture;
}

Picture profile_data_picture(const PsdReport& report, const Profile& measured, const std::string& name) {
  const Profile heights = detrend(heights_of(measured), report.estimate.options.detrend);
  const AxisUnit lateral = length_unit(heights.x.abs().maxCoeff());
  const AxisUnit height = length_unit(largest_size(heights.value));
  Picture picture{name, script_head(name, 1200, 600), {}};
  picture.add_columns(name + ".dat", {"Detrended heights of the measured profile: x [m], height [m]"},
                      {heights.x, heights.value});
  picture.script += fmt::format(
      "set title {}\nset xlabel 'x [{}]'\nset ylabel 'height [{}]'\nunset key\n"
      "plot '{}.dat' using ($1*{:.9g}):($2*{:.9g}) with lines linecolor rgb '{}' linewidth 1.5 dashtype 1\n",
      picture_title("Measured profile, detrended", report.title), lateral.name, height.name, name,
      lateral.per_si, height.per_si, kTargetColour);
  return picture;
}

Picture map_data_picture(const PsdReport& report, const HeightMap& measured, const ClearRegion& clear,
                         const std::string& name) {
  HeightMap map = detrend(measured, report.estimate.options.detrend);
  centre_on_grid(&map);
  const double largest = std::max(1e-15, largest_size(map.height));
  const double reach = std::max(std::abs(map.x0), std::abs(map.y0));
  const AxisUnit lateral = length_unit(reach), height = length_unit(largest);
  Picture picture{name, script_head(name, 1200, 1050), {}};
  picture.add_matrix(name + ".dat",
                     {"Detrended heights of the measured map [m]; nan where nothing was measured",
                      fmt::format("rows from -y to +y, {:.9g} m apart; columns from -x to +x, {:.9g} m apart",
                                  map.pitch_y, map.pitch_x)},
                     map.height);
  picture.script += fmt::format(
      "set title {}\nunset key\nunset grid\nset xlabel 'x [{}]'\nset ylabel 'y [{}]'\n"
      "set cblabel 'height [{}]' offset 1.5,0\nset size ratio -1\nset tics out\n"
      "{}{}"
      "plot '{}.dat' matrix using ($1*{:.9g}+{:.9g}):($2*{:.9g}+{:.9g}):($3*{:.9g}) with image{}\n",
      picture_title("Measured map, detrended", report.title), lateral.name, lateral.name, height.name,
      symmetric_range("cb", largest * height.per_si), signed_palette(), name, map.pitch_x * lateral.per_si,
      map.x0 * lateral.per_si, map.pitch_y * lateral.per_si, map.y0 * lateral.per_si, height.per_si,
      rim_curves(&picture, clear, map.x0 - measured.x0, map.y0 - measured.y0, lateral.per_si));
  return picture;
}

}  // namespace

std::vector<std::string> write_psd_plots(const PsdReport& report, const std::string& directory,
                                         Warnings* warnings) {
  std::vector<Picture> pictures = {psd_picture(report)};
  if (!report.differences.empty() && report.differences.front().separation.size() > 1)
    pictures.push_back(structure_function_picture(report));
  for (std::size_t i = 0; i < report.data.size(); ++i) {
    const std::string name = i == 0 ? "data" : fmt::format("data_{}", i + 1);
    if (const auto* profile = std::get_if<Profile>(&report.data[i]))
      pictures.push_back(profile_data_picture(report, *profile, name));
    else
      pictures.push_back(
          map_data_picture(report, std::get<HeightMap>(report.data[i]), report.clear.at(i), name));
  }
  return draw_pictures(pictures, directory, warnings);
}

}  // namespace aberfit
