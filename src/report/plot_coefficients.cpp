#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "aberfit/scene/zernike.h"
#include "picture.h"

namespace aberfit::internal {
namespace {

// Standard deviation of coefficient i, 0 where none was computed (the band then vanishes).
double deviation(const ResultDocument& result, Eigen::Index i) {
  const Eigen::VectorXd& std = result.fit.coefficient_std;
  return i < std.size() && std::isfinite(std[i]) ? std[i] : 0.0;
}

bool has_deviations(const ResultDocument& result) { return result.fit.coefficient_std.size() > 0; }

// One panel: what to set, and what to plot.
using Panels = std::vector<std::string>;

// Coefficients by Noll index: on a linear axis with the band of their standard deviations about zero; over
// decades their magnitude, with colours for the sign and the standard deviation as a line.
std::string value_panel(const AxisUnit& unit, const Eigen::ArrayXd& noll, bool steep, double lowest,
                        bool band) {
  const std::string file = "'coefficients_zernike.dat'";
  const double count = double(noll.size());
  std::string panel = fmt::format(
      "s = {:.9g}  # axis units per metre\nset xlabel 'Noll index j'\nset xrange [{:.9g}:{:.9g}]\n",
      unit.per_si, noll.minCoeff() - 1, noll.maxCoeff() + 1);
  if (steep) {
    const double size = count > 400 ? 0.35 : 0.7;
    panel += fmt::format(
        "set ylabel 'size of Zernike coefficient [{0}]'\nset logscale y\nset yrange [{5:.9g}:*]\nset format "
        "y '%g'\n"
        "plot {1} using 1:($4>0?$4*s:1/0) with points pointtype 7 pointsize {2} linecolor rgb '{3}' title "
        "'positive', \\\n"
        "  {1} using 1:($4<0?-$4*s:1/0) with points pointtype 7 pointsize {2} linecolor rgb '{4}' title "
        "'negative'",
        unit.name, file, size, kTargetColour, kFittedColour, lowest * unit.per_si);
    if (band)
      panel += fmt::format(
          ", \\\n  {} using 1:($5>0?$5*s:1/0) with lines linecolor rgb 'black' linewidth 1.5 dashtype 1 "
          "title 'posterior standard deviation'",
          file);
    return panel + "\n";
  }
  panel += fmt::format("set ylabel 'Zernike coefficient [{}]'\nplot ", unit.name);
  if (band)
    panel += file +
             " using 1:(-$5*s):($5*s) with filledcurves fillcolor rgb '#d5d5d5' title 'posterior standard "
             "deviation, about zero', \\\n  ";
  return panel +
         fmt::format(
             "{0} using 1:($4*s) with impulses linecolor rgb '{1}' linewidth {2} dashtype 1 notitle, \\\n"
             "  {0} using 1:($4*s) with points pointtype 7 pointsize {3} linecolor rgb '{1}' title 'fitted "
             "value'\n",
             file, kTargetColour, count > 400 ? 0.6 : 1.5, count > 400 ? 0.25 : 0.6);
}

// RMS height of each radial order; bars where they can stand on zero.
std::string order_panel(const AxisUnit& unit, const Eigen::ArrayXd& radial, bool steep, bool band) {
  std::string panel = fmt::format(
      "s = {0:.9g}  # axis units per metre\n"
      "set xlabel 'radial order n'\nset ylabel 'RMS height of one order [{1}]'\nset xrange "
      "[{2:.9g}:{3:.9g}]\n{4}"
      "plot 'coefficients_orders.dat' using 1:($2*s) with {5} linecolor rgb '{6}' title 'fitted'",
      unit.per_si, unit.name, radial.minCoeff() - 1, radial.maxCoeff() + 1,
      steep ? "set logscale y\nset format y '%g'\n"
            : "set yrange [0:*]\nset boxwidth 0.7\nset style fill solid 0.6 noborder\n",
      steep ? "linespoints pointtype 7 pointsize 0.8 dashtype 1" : "boxes", kTargetColour);
  if (band)
    panel += fmt::format(
        ", \\\n  '' using 1:($3*s) with linespoints pointtype 6 linecolor rgb '{}' dashtype 3 title "
        "'posterior standard deviation'",
        kFittedColour);
  return panel + "\n";
}

void zernike_panels(const ResultDocument& result, Picture* picture, Panels* panels) {
  const std::vector<ZernikeMode>& modes = result.terms.zernike;
  const Eigen::Index count = Eigen::Index(modes.size());
  std::vector<Eigen::Index> order(modes.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return noll_index(modes[std::size_t(a)]) < noll_index(modes[std::size_t(b)]);
  });
  Eigen::ArrayXd noll(count), n(count), m(count), value(count), std(count);
  struct Sum {
    double value2 = 0, std2 = 0;
  };
  std::map<int, Sum> orders;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = order[std::size_t(i)];
    const ZernikeMode& mode = modes[std::size_t(k)];
    noll[i] = noll_index(mode);
    n[i] = mode.n;
    m[i] = mode.m;
    value[i] = result.fit.coefficients[k];
    std[i] = deviation(result, k);
    orders[mode.n].value2 += value[i] * value[i];
    orders[mode.n].std2 += std[i] * std[i];
  }
  picture->add_columns("coefficients_zernike.dat",
                       {"Orthonormal Zernike coefficients of the fitted surface, by Noll index",
                        "columns: noll n m value_m std_m"},
                       {noll, n, m, value, std});
  Eigen::ArrayXd radial(Eigen::Index(orders.size())), rms(radial.size()), spread(radial.size());
  Eigen::Index row = 0;
  for (const auto& [degree, sum] : orders) {
    radial[row] = degree;
    rms[row] = std::sqrt(sum.value2);
    spread[row++] = std::sqrt(sum.std2);
  }
  picture->add_columns("coefficients_orders.dat",
                       {"Root sum of squares over the Zernike coefficients of one radial order",
                        "columns: n rms_height_m rms_std_m"},
                       {radial, rms, spread});

  // Linear axes while all orders can be read on them.
  const bool steep = rms.minCoeff() > 0 && largest_size(rms) > 30 * rms.minCoeff();
  const bool band = has_deviations(result);
  // A coefficient that happens to be next to nothing must not stretch the axis.
  const double lowest = rms.minCoeff() / 300;
  panels->push_back(
      value_panel(length_unit(std::max(largest_size(value), largest_size(std))), noll, steep, lowest, band));
  panels->push_back(
      order_panel(length_unit(std::max(largest_size(rms), largest_size(spread))), radial, steep, band));
}

void fourier_panel(const ResultDocument& result, Picture* picture, Panels* panels) {
  const std::vector<FourierMode>& modes = result.terms.fourier;
  const Eigen::Index count = Eigen::Index(modes.size());
  Eigen::ArrayXd fx(count), fy(count), f(count), amplitude(count), std(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = result.terms.fourier_begin() + 2 * i;
    fx[i] = modes[std::size_t(i)].fx;
    fy[i] = modes[std::size_t(i)].fy;
    f[i] = std::hypot(fx[i], fy[i]);
    amplitude[i] = std::hypot(result.fit.coefficients[k], result.fit.coefficients[k + 1]);
    std[i] = std::hypot(deviation(result, k), deviation(result, k + 1));
  }
  picture->add_columns("coefficients_fourier.dat",
                       {"Amplitudes of the plane waves of the fitted surface",
                        "columns: frequency_per_m fx_per_m fy_per_m amplitude_m std_m"},
                       {f, fx, fy, amplitude, std});
  const AxisUnit unit = length_unit(std::max(largest_size(amplitude), largest_size(std)));
  const bool logarithmic = f.minCoeff() > 0 && f.maxCoeff() > 10 * f.minCoeff();
  const std::string spread = has_deviations(result)
                                 ? fmt::format(
                                       ", \\\n  '' using 1:($5*{:.9g}) with points pointtype 6 pointsize 0.5 "
                                       "linecolor rgb '{}' title 'posterior standard deviation'",
                                       unit.per_si, kFittedColour)
                                 : "";
  panels->push_back(
      fmt::format("set xlabel 'spatial frequency [cycles/m]'\nset ylabel 'Fourier amplitude [{}]'\n"
                  "{}set xrange [{:.9g}:{:.9g}]\nset yrange [0:*]\n"
                  "plot 'coefficients_fourier.dat' using 1:($4*{:.9g}) with points pointtype 7 pointsize 0.6 "
                  "linecolor rgb '{}' title 'fitted value'{}\n",
                  unit.name, logarithmic ? "set logscale x\n" : "", f.minCoeff() / 1.05, f.maxCoeff() * 1.05,
                  unit.per_si, kTargetColour, spread));
}

void spherical_panel(const ResultDocument& result, Picture* picture, Panels* panels) {
  const std::vector<int>& powers = result.terms.spherical;
  const Eigen::Index count = Eigen::Index(powers.size());
  Eigen::ArrayXd power(count), value(count), std(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index k = result.terms.spherical_begin() + i;
    power[i] = powers[std::size_t(i)];
    value[i] = result.fit.coefficients[k];
    std[i] = deviation(result, k);
  }
  picture->add_columns(
      "coefficients_spherical.dat",
      {"Spherical terms of the fitted surface: height at the rim", "columns: power_of_rho value_m std_m"},
      {power, value, std});
  const AxisUnit unit = length_unit(std::max(largest_size(value), largest_size(std)));
  panels->push_back(
      fmt::format("set xlabel 'power of rho'\nset ylabel 'spherical term at the rim [{}]'\n"
                  "set xrange [3:13]\nset xtics 4,2,12\nset xzeroaxis linecolor rgb '#666666'\nset boxwidth "
                  "1\nset style fill solid 0.6 noborder\n"
                  "plot 'coefficients_spherical.dat' using 1:($2*{}) with boxes linecolor rgb '{}' title "
                  "'fitted value', \\\n"
                  "  '' using 1:($2*{}):($3*{}) with yerrorbars pointtype 7 pointsize 0.6 linecolor rgb "
                  "'black' title 'posterior standard deviation'\n",
                  unit.name, unit.per_si, kTargetColour, unit.per_si, unit.per_si));
}

}  // namespace

/// The coefficients with their uncertainty: Zernikes by Noll index and by radial order, Fourier amplitudes,
/// spherical terms.
Picture coefficients_picture(const PlotInput& input) {
  const std::string name = "coefficients";
  const ResultDocument& result = input.result;
  Picture picture{name, "", {}};
  Panels panels;
  if (!result.terms.zernike.empty()) zernike_panels(result, &picture, &panels);
  if (!result.terms.fourier.empty()) fourier_panel(result, &picture, &panels);
  if (!result.terms.spherical.empty()) spherical_panel(result, &picture, &panels);
  if (panels.empty()) return {};
  const bool four = panels.size() > 2;
  const int rows = four ? 2 : int(panels.size());
  picture.script = script_head(name, four ? 1500 : 1200, rows == 1 ? 700 : 1000);
  picture.script += fmt::format("set multiplot layout {},{} title {} font 'DejaVu Sans,16'\n", rows,
                                four ? 2 : 1, picture_title(input, "Coefficients of the fitted surface"));
  for (const std::string& panel : panels)
    picture.script += "unset logscale\nset autoscale\nset xtics autofreq\nset format '%g'\n" + panel;
  picture.script += "unset multiplot\n";
  return picture;
}

}  // namespace aberfit::internal
