#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/report/psd_of_focus_report.h"
#include "picture.h"

namespace aberfit {
using namespace internal;

std::vector<std::string> write_focus_plots(const PsdOfFocus& result, const std::string& directory,
                                           Warnings* warnings) {
  if (result.radius.size() == 0) return {};
  const Eigen::ArrayXd deviation = (result.noise.square() + result.spread.square()).sqrt();
  const Eigen::ArrayXd left = (result.measured - result.fitted) / deviation;
  Picture picture{"focus", script_head("focus", 1000, 900), {}};
  picture.add_columns(
      "focus.dat",
      {"Radius [m], measured light, fitted light, standard deviation (noise and one mirror's own "
       "spread), what is left over that"},
      {result.radius, result.measured, result.fitted, deviation, left});
  const AxisUnit unit = length_unit(result.radius.maxCoeff());
  const double low = result.radius.minCoeff() * unit.per_si / 1.1,
               high = result.radius.maxCoeff() * unit.per_si * 1.1;
  const double reach = std::max(3.5, 1.1 * left.abs().maxCoeff());
  const bool logs = result.is_image && (result.measured > 0).all() && (result.fitted > 0).all();
  picture.script += fmt::format(
      "set multiplot\nset lmargin at screen 0.12\nset rmargin at screen 0.97\nset logscale x\n"
      "set xrange [{0:.9g}:{1:.9g}]\nset xtics {2}\nset format x ''\n"
      "set tmargin at screen 0.93\nset bmargin at screen 0.36\nset title {3}\nset ylabel {4}\n{5}"
      "set key inside {6}\n"
      "plot 'focus.dat' using ($1*{7:.9g}):2:4 with yerrorbars dashtype solid pointtype 7 pointsize 0.7 "
      "linecolor rgb '{8}' "
      "title {9}, \\\n"
      "  'focus.dat' using ($1*{7:.9g}):3 with lines linewidth 2 linecolor rgb '{10}' title 'fitted "
      "roughness'\n"
      "unset title\nunset logscale y\nset tmargin at screen 0.33\nset bmargin at screen 0.09\n"
      "set format x '%g'\nset format y '%g'\nset yrange [{11:.4g}:{12:.4g}]\nset xlabel {13}\n"
      "set ylabel 'left over / deviation'\n"
      "plot 0 with lines dashtype solid linecolor rgb '{10}' notitle, \\\n"
      "  'focus.dat' using ($1*{7:.9g}):5 with points pointtype 7 pointsize 0.7 linecolor rgb '{8}' notitle\n"
      "unset multiplot\n",
      low, high, log_tics(low, high), picture_title("Light of the measured focus", result.title),
      gnuplot_text(result.is_image ? "mean light of a pixel of the ring [unit of the image]"
                                   : "encircled energy"),
      logs ? "set logscale y\nset format y '%g'\n" : "", result.is_image ? "top right" : "bottom right",
      unit.per_si, kTargetColour,
      gnuplot_text(result.is_one_mirror ? "measured, with noise and one mirror's spread"
                                        : "measured, with noise"),
      kFittedColour, -reach, reach,
      gnuplot_text(unit.label(result.is_image ? "mean radius of the ring" : "radius")));
  return draw_pictures({picture}, directory, warnings);
}

}  // namespace aberfit
