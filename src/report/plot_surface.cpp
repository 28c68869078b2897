#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/random.h"
#include "fit_pictures.h"
#include "focus_curves.h"

namespace aberfit::internal {
namespace {

// Weighted mean and standard deviation.
std::pair<double, double> moments(const Eigen::ArrayXd& values, const Eigen::ArrayXd& weights) {
  const double total = weights.sum(), mean = (weights * values).sum() / total;
  return {mean, std::sqrt((weights * (values - mean).square()).sum() / total)};
}

// Coordinate of line i of the surface grid.
double grid_line(const FitPictures& fit, int i) {
  return aperture_radius(fit.aperture) * (2.0 * i / (fit.grid_size - 1) - 1.0);
}

// Scales coordinates so that rounding does not decide if a point on the rim belongs to the mirror. A cut
// reaches the rim; in a map the four outermost points of a circle would stick out as single pixels.
constexpr double kWithRim = 1 - 1e-9, kWithoutRim = 1 + 1e-9;

// Values of the grid on the mirror, NaN elsewhere; row = y, column = x.
Eigen::ArrayXXd mirror_map(const FitPictures& fit, const Eigen::ArrayXd& values, double rim) {
  const auto on_mirror = [&](double x, double y) {
    return aperture_contains(fit.aperture, rim * x, rim * y, 0.0);
  };
  const int n = fit.grid_size;
  Eigen::ArrayXXd map(n, n);
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column)
      map(row, column) = on_mirror(grid_line(fit, column), grid_line(fit, row))
                             ? values[Eigen::Index(row) * n + column]
                             : NAN;
  return map;
}

// The line through the vertex along x (or y). In an even grid it is the mean of the two middle lines.
Eigen::ArrayXd cut(const Eigen::ArrayXXd& map, bool along_x) {
  const Eigen::Index upper = map.rows() / 2, lower = (map.rows() - 1) / 2;
  if (along_x) return 0.5 * (map.row(lower) + map.row(upper)).transpose();
  return 0.5 * (map.col(lower) + map.col(upper));
}

}  // namespace

Picture surface_picture(const FitPictures& fit, const SurfaceField& grid) {
  const Eigen::ArrayXXd map = mirror_map(fit, grid.height, kWithoutRim);
  double low = HUGE_VAL, high = -HUGE_VAL, x_reach = 0, y_reach = 0;
  for (int row = 0; row < fit.grid_size; ++row) {
    for (int column = 0; column < fit.grid_size; ++column) {
      if (std::isnan(map(row, column))) continue;
      low = std::min(low, map(row, column));
      high = std::max(high, map(row, column));
      x_reach = std::max(x_reach, std::abs(grid_line(fit, column)));
      y_reach = std::max(y_reach, std::abs(grid_line(fit, row)));
    }
  }
  const double radius = aperture_radius(fit.aperture),
               largest = std::max({std::abs(low), std::abs(high), 1e-15});
  const double step = 2 * radius / (fit.grid_size - 1), frame = 0.02 * radius + step;
  Picture picture("surface", fit.result.title);
  picture.add_matrix("surface.dat",
                     {"Height of the fitted surface error [m], positive towards the incoming light; nan "
                      "outside the aperture",
                      fmt::format("{0} x {0} points, {1:.9g} m apart; rows from -y to +y, columns from -x to "
                                  "+x; the first point is at {2:.9g} m in x and y",
                                  fit.grid_size, step, -radius)},
                     map);
  picture.set_pixels(-radius, step, -radius, step);
  picture.set("x", length_unit(radius));
  picture.set("x_reach", x_reach + frame);
  picture.set("y_reach", y_reach + frame);
  picture.set("h", length_unit(largest));
  picture.set("largest", largest);
  picture.set("rms", display(moments(fit.fitted_field.height, fit.pupil.weight).second, Dimension::kLength));
  picture.set("peak_to_valley", display(high - low, Dimension::kLength));
  picture.add_rim(fit.result.clear, 0, 0);
  return picture;
}

Picture profile_picture(const FitPictures& fit, const SurfaceField& grid) {
  Eigen::ArrayXd position(fit.grid_size);
  for (int i = 0; i < fit.grid_size; ++i) position[i] = grid_line(fit, i);
  const auto along = [&](const Eigen::ArrayXd& values, bool x) {
    return cut(mirror_map(fit, values, kWithRim), x);
  };
  const PictureColumns columns = {position, along(grid.height, true), along(grid.height, false),
                                  along(grid.slope_x, true), along(grid.slope_y, false)};
  Picture picture("profile", fit.result.title);
  picture.add_columns(
      "profile.dat",
      {"Cuts through the vertex of the fitted surface error; nan outside the aperture",
       "columns: position_m height_along_x_m height_along_y_m slope_dh_dx_along_x slope_dh_dy_along_y"},
      columns);
  const double radius = aperture_radius(fit.aperture);
  const auto largest = [&](std::size_t k) {
    return std::max({1e-15, largest_size(columns[k]), largest_size(columns[k + 1])});
  };
  picture.set("radius", radius);
  picture.set("x", length_unit(radius));
  picture.set("h", length_unit(largest(1)));
  picture.set("s", angle_unit(largest(3)));
  return picture;
}

namespace {

// x and y slopes of about kDots rays. Each ray has its own random number from its index, so the choice is
// reproducible.
PictureColumns slope_dots(const SurfaceField& field) {
  constexpr double kDots = 5000;  // more would cover the middle
  const RandomStream coin(0, "plot-slopes");
  std::vector<double> dot_x, dot_y;
  for (Eigen::Index i = 0; i < field.size(); ++i) {
    if (coin.uniform(std::uint64_t(i)) * double(field.size()) > kDots) continue;
    dot_x.push_back(field.slope_x[i]);
    dot_y.push_back(field.slope_y[i]);
  }
  return {array_of(dot_x), array_of(dot_y)};
}

}  // namespace

Picture gradients_picture(const FitPictures& fit) {
  constexpr int kBins = 81;
  constexpr double kReach = 4;  // [standard deviations]
  const SurfaceField& field = fit.fitted_field;
  const Eigen::ArrayXd& weight = fit.pupil.weight;
  const auto [mean_x, sigma_x] = moments(field.slope_x, weight);
  const auto [mean_y, sigma_y] = moments(field.slope_y, weight);
  const double reach =
      kReach * std::max({sigma_x, sigma_y, 1e-15}) + std::max(std::abs(mean_x), std::abs(mean_y));
  Eigen::ArrayXd centre(kBins);
  for (int i = 0; i < kBins; ++i) centre[i] = reach * ((2.0 * i + 1) / kBins - 1);
  const PictureColumns dots = slope_dots(field);
  Picture picture("gradients", fit.result.title);
  picture.add_columns("gradients.dat",
                      {"Density of the fitted surface's slopes over the aperture [1/rad], weighted by energy",
                       "columns: slope_rad density_dh_dx density_dh_dy"},
                      {centre, weighted_density(field.slope_x, weight, -reach, reach, kBins),
                       weighted_density(field.slope_y, weight, -reach, reach, kBins)});
  const std::string points = fmt::format("{} of {} points", dots[0].size(), field.size());
  picture.add_columns("gradients_scatter.dat",
                      {"Slopes at " + points + " of the pupil", "columns: slope_dh_dx slope_dh_dy [rad]"},
                      dots);
  picture.set("s", angle_unit(reach));
  picture.set("reach", reach);
  picture.set("points", points);
  picture.set("mean_x", mean_x);
  picture.set("mean_y", mean_y);
  picture.set("sigma_x", std::max(sigma_x, 1e-15));
  picture.set("sigma_y", std::max(sigma_y, 1e-15));
  picture.set("rms_x", display(sigma_x, Dimension::kAngle));
  picture.set("rms_y", display(sigma_y, Dimension::kAngle));
  picture.set("specified",
              fit.result.has_roughness
                  ? "specified: " + display(fit.result.scene.numbers.rms_slope_per_axis, Dimension::kAngle) +
                        " RMS per axis"
                  : std::string());
  return picture;
}

}  // namespace aberfit::internal
