#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/random.h"
#include "focus_curves.h"
#include "picture.h"

namespace aberfit::internal {
namespace {

// Weighted mean and standard deviation.
std::pair<double, double> moments(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weights) {
  const double total = weights.sum(), mean = (weights * values).sum() / total;
  return {mean, std::sqrt((weights * (values - mean).square()).sum() / total)};
}

// Coordinate of line i of the surface grid.
double grid_line(const PlotInput& input, int i) {
  return aperture_radius(input.aperture) * (2.0 * i / (input.grid_size - 1) - 1.0);
}

// Whether points exactly on the rim, where rounding would decide, belong to a map: a cut should reach the
// rim, while in a map the four outermost points of a circle stick out as single pixels.
constexpr double kWithRim = 1 - 1e-9, kWithoutRim = 1 + 1e-9;

// The mirror's part of values on the grid, NaN elsewhere; row = y, column = x.
Eigen::ArrayXXd mirror_map(const PlotInput& input, const Eigen::ArrayXd& values, double rim) {
  const auto on_mirror = [&](double x, double y) {
    return aperture_contains(input.aperture, rim * x, rim * y, 0.0);
  };
  const int n = input.grid_size;
  Eigen::ArrayXXd map(n, n);
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column)
      map(row, column) = on_mirror(grid_line(input, column), grid_line(input, row))
                             ? values[Eigen::Index(row) * n + column]
                             : NAN;
  return map;
}

// The line through the vertex along x (or y); between two lines of an even grid their mean.
Eigen::ArrayXd cut(const Eigen::ArrayXXd& map, bool along_x) {
  const Eigen::Index upper = map.rows() / 2, lower = (map.rows() - 1) / 2;
  if (along_x) return 0.5 * (map.row(lower) + map.row(upper)).transpose();
  return 0.5 * (map.col(lower) + map.col(upper));
}

}  // namespace

/// Height map of the fitted surface error.
Picture surface_picture(const PlotInput& input, const SurfaceField& grid) {
  const std::string name = "surface";
  const Eigen::ArrayXXd map = mirror_map(input, grid.height, kWithoutRim);
  double low = HUGE_VAL, high = -HUGE_VAL, x_reach = 0, y_reach = 0;
  for (int row = 0; row < input.grid_size; ++row) {
    for (int column = 0; column < input.grid_size; ++column) {
      if (std::isnan(map(row, column))) continue;
      low = std::min(low, map(row, column));
      high = std::max(high, map(row, column));
      x_reach = std::max(x_reach, std::abs(grid_line(input, column)));
      y_reach = std::max(y_reach, std::abs(grid_line(input, row)));
    }
  }
  const double radius = aperture_radius(input.aperture),
               largest = std::max({std::abs(low), std::abs(high), 1e-15});
  const double rms = moments(input.fitted_field.height, input.pupil.weight).second;
  const AxisUnit lateral = length_unit(radius), height = length_unit(largest);
  const double step = 2 * radius / (input.grid_size - 1), frame = 0.02 * radius + step;

  Picture picture{name, script_head(name, 1200, 1050), {}};
  picture.add_matrix(name + ".dat",
                     {"Height of the fitted surface error [m], positive towards the incoming light; nan "
                      "outside the aperture",
                      fmt::format("{0} x {0} points, {1:.9g} m apart; rows from -y to +y, columns from -x to "
                                  "+x; the first point is at {2:.9g} m in x and y",
                                  input.grid_size, step, -radius)},
                     map);
  picture.script += fmt::format(
      "p = {:.9g}; o = {:.9g}  # spacing and first point [{}]\n"
      "s = {:.9g}  # axis units per metre of height\n"
      "set title {}\n"
      "unset key\nunset grid\n"
      "set xlabel 'x [{}]'\nset ylabel 'y [{}]'\nset cblabel {} offset 1.5,0\n"
      "set size ratio -1\nset tics out\n"
      "{}{}{}{}"
      "plot '{}.dat' matrix using ($1*p+o):($2*p+o):($3*s) with image{}\n",
      step * lateral.per_si, -radius * lateral.per_si, lateral.name, height.per_si,
      picture_title(input, "Fitted surface error"), lateral.name, lateral.name,
      gnuplot_text(fmt::format("height [{}], towards the light   (RMS {}, peak to valley {})", height.name,
                               display(rms, Dimension::kLength), display(high - low, Dimension::kLength))),
      symmetric_range("x", (x_reach + frame) * lateral.per_si),
      symmetric_range("y", (y_reach + frame) * lateral.per_si),
      symmetric_range("cb", largest * height.per_si), signed_palette(), name,
      rim_curves(&picture, input.result.clear, 0, 0, lateral.per_si));
  return picture;
}

/// Cuts along x and y through the vertex: height above, slope below.
Picture profile_picture(const PlotInput& input, const SurfaceField& grid) {
  const std::string name = "profile";
  const Eigen::ArrayXXd height = mirror_map(input, grid.height, kWithRim);
  const Eigen::ArrayXXd slope_x = mirror_map(input, grid.slope_x, kWithRim),
                        slope_y = mirror_map(input, grid.slope_y, kWithRim);
  Eigen::ArrayXd position(input.grid_size);
  for (int i = 0; i < input.grid_size; ++i) position[i] = grid_line(input, i);
  const Eigen::ArrayXd height_x = cut(height, true), height_y = cut(height, false);
  const Eigen::ArrayXd along_x = cut(slope_x, true), along_y = cut(slope_y, false);
  const auto largest = [](const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
    return std::max({1e-15, largest_size(a), largest_size(b)});
  };
  const double radius = aperture_radius(input.aperture);
  const AxisUnit lateral = length_unit(radius), vertical = length_unit(largest(height_x, height_y)),
                 angular = angle_unit(largest(along_x, along_y));

  Picture picture{name, script_head(name, 1200, 900), {}};
  picture.add_columns(
      name + ".dat",
      {"Cuts through the vertex of the fitted surface error; nan outside the aperture",
       "columns: position_m height_along_x_m height_along_y_m slope_dh_dx_along_x slope_dh_dy_along_y"},
      {position, height_x, height_y, along_x, along_y});
  picture.script += fmt::format(
      "{}u = {:.9g}; s = {:.9g}; a = {:.9g}  # axis units per metre of position, metre of height, radian\n"
      "set lmargin 11\nset rmargin 3\n"
      "set xzeroaxis linecolor rgb '#666666' linewidth 1\n"
      "set multiplot title {} font 'DejaVu Sans,16'\n"
      "set size 1,0.49\nset origin 0,0.46\n"
      "set format x ''\nset ylabel 'height [{}]'\n"
      "plot '{}.dat' using ($1*u):($2*s) with lines linetype 2 title 'cut along x (y = 0)', \\\n"
      "  '' using ($1*u):($3*s) with lines linetype 3 title 'cut along y (x = 0)'\n"
      "set size 1,0.48\nset origin 0,0\n"
      "set format x '%g'\nset xlabel 'distance from the vertex [{}]'\nset ylabel 'slope along the cut [{}]'\n"
      "plot '{}.dat' using ($1*u):($4*a) with lines linetype 2 title 'dh/dx along x', \\\n"
      "  '' using ($1*u):($5*a) with lines linetype 3 title 'dh/dy along y'\n"
      "unset multiplot\n",
      symmetric_range("x", radius * lateral.per_si), lateral.per_si, vertical.per_si, angular.per_si,
      picture_title(input, "Cuts through the vertex"), vertical.name, name, lateral.name, angular.name, name);
  return picture;
}

namespace {

// Weighted moments of the slopes, and how far the axes show them.
struct SlopeSpread {
  double mean_x = 0, mean_y = 0, sigma_x = 0, sigma_y = 0, reach = 0;
};

SlopeSpread slope_spread(const SurfaceField& field, const Eigen::ArrayXd& weight) {
  constexpr double kReach = 4;  // standard deviations to either side
  const auto [mean_x, sigma_x] = moments(field.slope_x, weight);
  const auto [mean_y, sigma_y] = moments(field.slope_y, weight);
  const double sigma = std::max(std::sqrt(0.5 * (sigma_x * sigma_x + sigma_y * sigma_y)), 1e-15);
  const double reach =
      kReach * std::max({sigma_x, sigma_y, sigma}) + std::max(std::abs(mean_x), std::abs(mean_y));
  return {mean_x, mean_y, sigma_x, sigma_y, reach};
}

// Slopes of about kDots rays, x and y. Each ray keeps its own coin, so the choice depends neither on the
// pupil's order nor on chance.
std::pair<Eigen::ArrayXd, Eigen::ArrayXd> slope_dots(const SurfaceField& field) {
  constexpr double kDots = 5000;  // more would fill the middle solid
  const RandomStream coin(0, "plot-slopes");
  std::vector<double> dot_x, dot_y;
  for (Eigen::Index i = 0; i < field.size(); ++i) {
    if (coin.uniform(std::uint64_t(i)) * double(field.size()) > kDots) continue;
    dot_x.push_back(field.slope_x[i]);
    dot_y.push_back(field.slope_y[i]);
  }
  return {array_of(dot_x), array_of(dot_y)};
}

// Both panels: densities on the left, `dots` rays on the right.
std::string gradients_script(const PlotInput& input, const SlopeSpread& spread, Eigen::Index dots,
                             const std::string& name) {
  const AxisUnit unit = angle_unit(spread.reach);
  std::string specified;
  if (input.result.has_roughness)
    specified = fmt::format(
        "set label 1 {} at graph 0.02,0.96\n",
        gnuplot_text("specified: " + display(input.result.scene.rms_slope_per_axis, Dimension::kAngle) +
                     " RMS per axis"));
  return fmt::format(
      "a = {0:.9g}  # axis units per radian\n"
      "sx = {1:.9g}; sy = {2:.9g}; mx = {3:.9g}; my = {4:.9g}  # standard deviations and means [{5}]\n"
      "gauss(t, s) = exp(-0.5*t*t/(s*s)) / (s*sqrt(2*pi))\n"
      "set multiplot title {6} font 'DejaVu Sans,16'\n"
      "set samples 401\nset xrange [{7:.9g}:{8:.9g}]\n"
      "set lmargin at screen 0.07\nset rmargin at screen 0.52\nset bmargin at screen 0.11\nset tmargin at "
      "screen 0.82\n"
      "set xlabel 'slope of the surface [{5}]'\nset ylabel 'density [1/{5}]'\nset yrange [0:*]\nset offsets "
      "0,0,graph 0.1,0\n"
      "set key at graph 0.5,1.02 center bottom\n"
      "{9}"
      "plot '{10}.dat' using ($1*a):($2/a) with histeps linecolor rgb '{11}' linewidth 2 dashtype 1 title "
      "{12}, \\\n"
      "  '' using ($1*a):($3/a) with histeps linecolor rgb '{13}' linewidth 2 dashtype 1 title {14}, \\\n"
      "  gauss(x - mx, sx) with lines linecolor rgb '{11}' linewidth 1.5 dashtype 2 title 'Gaussian of the "
      "same width, x', \\\n"
      "  gauss(x - my, sy) with lines linecolor rgb '{13}' linewidth 1.5 dashtype 2 title 'Gaussian of the "
      "same width, y'\n"
      "unset label\nunset offsets\n"
      "set lmargin at screen 0.60\nset rmargin at screen 0.98\n"
      "set size ratio -1\nset samples 181\n"
      "set yrange [{7:.9g}:{8:.9g}]\n"
      "set xlabel 'dh/dx [{5}]'\nset ylabel 'dh/dy [{5}]'\nset key at graph 0.5,1.02 center bottom\n"
      "plot 'gradients_scatter.dat' using ($1*a):($2*a) with points pointtype 7 pointsize 0.3 linecolor rgb "
      "'{11}' title {15}, \\\n"
      "  for [k=1:3] [0:2*pi] '+' using (mx+k*sx*cos($1)):(my+k*sy*sin($1)) with lines linecolor rgb 'black' "
      "linewidth 1.2 dashtype k title sprintf('%d sigma', k)\n"
      "unset multiplot\n",
      unit.per_si, std::max(spread.sigma_x, 1e-15) * unit.per_si,
      std::max(spread.sigma_y, 1e-15) * unit.per_si, spread.mean_x * unit.per_si, spread.mean_y * unit.per_si,
      unit.name, picture_title(input, "Slopes of the fitted surface"), -spread.reach * unit.per_si,
      spread.reach * unit.per_si, specified, name, kTargetColour,
      gnuplot_text("dh/dx, RMS " + display(spread.sigma_x, Dimension::kAngle)), kFittedColour,
      gnuplot_text("dh/dy, RMS " + display(spread.sigma_y, Dimension::kAngle)),
      gnuplot_text(fmt::format("{} of {} points", dots, input.fitted_field.size())));
}

}  // namespace

/// Distribution of the surface slopes: densities against Gaussians of the same width, and the slopes
/// themselves.
Picture gradients_picture(const PlotInput& input) {
  const std::string name = "gradients";
  constexpr int kBins = 81;
  const SurfaceField& field = input.fitted_field;
  const Eigen::ArrayXd& weight = input.pupil.weight;
  const SlopeSpread spread = slope_spread(field, weight);
  const double reach = spread.reach;
  Eigen::ArrayXd centre(kBins);
  for (int i = 0; i < kBins; ++i) centre[i] = reach * ((2.0 * i + 1) / kBins - 1);
  const auto [dot_x, dot_y] = slope_dots(field);

  Picture picture{name, script_head(name, 1500, 840), {}};
  picture.add_columns(name + ".dat",
                      {"Density of the fitted surface's slopes over the aperture [1/rad], weighted by light",
                       "columns: slope_rad density_dh_dx density_dh_dy"},
                      {centre, weighted_density(field.slope_x, weight, -reach, reach, kBins),
                       weighted_density(field.slope_y, weight, -reach, reach, kBins)});
  picture.add_columns("gradients_scatter.dat",
                      {fmt::format("Slopes at {} of {} points of the pupil", dot_x.size(), field.size()),
                       "columns: slope_dh_dx slope_dh_dy [rad]"},
                      {dot_x, dot_y});
  picture.script += gradients_script(input, spread, dot_x.size(), name);
  return picture;
}

}  // namespace aberfit::internal
