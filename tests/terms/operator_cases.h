#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "aberfit/core/random.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/terms/surface_operator.h"

/// Points, weights and comparisons for the tests of the operators.
namespace operator_cases {

constexpr double kRadius = 0.2;

inline Eigen::ArrayXd normals(Eigen::Index count, const char* name) {
  const aberfit::RandomStream stream(2, name);
  Eigen::ArrayXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) values[i] = stream.normal(std::uint64_t(i));
  return values;
}

inline aberfit::SurfaceField random_field(Eigen::Index count, const char* name) {
  const Eigen::ArrayXd all = normals(3 * count, name);
  return {all.head(count), all.segment(count, count), all.tail(count)};
}

/// Rings between 0.03 and 1 radius, rotated against each other.
inline aberfit::PupilSample rings(Eigen::Index count, Eigen::Index spokes) {
  aberfit::PolarRings structure{Eigen::ArrayXd(count), Eigen::ArrayXd(count), spokes};
  aberfit::PupilSample pupil;
  pupil.x.resize(count * spokes), pupil.y.resize(count * spokes);
  pupil.weight = Eigen::ArrayXd::Constant(count * spokes, 1.0 / double(count * spokes));
  for (Eigen::Index i = 0; i < count; ++i) {
    structure.rho[i] = kRadius * (0.03 + 0.97 * double(i + 1) / double(count));
    structure.turn[i] = std::sin(1.7 * double(i)) * 3.0;
    for (Eigen::Index j = 0; j < spokes; ++j) {
      const double angle = 2 * std::numbers::pi * double(j) / double(spokes) + structure.turn[i];
      pupil.x[i * spokes + j] = structure.rho[i] * std::cos(angle);
      pupil.y[i * spokes + j] = structure.rho[i] * std::sin(angle);
    }
  }
  pupil.structure = structure;
  return pupil;
}

/// A disc from a grid with unequal steps; its points are not in grid order.
inline aberfit::PupilSample scrambled_grid(int columns, int rows) {
  aberfit::CartesianGrid structure{Eigen::ArrayXd(columns), Eigen::ArrayXd(rows), {}, {}};
  for (int i = 0; i < columns; ++i)
    structure.x[i] = kRadius * ((2.0 * i + 1) / columns - 1 + 0.3 * std::sin(3.0 * i) / columns);
  for (int j = 0; j < rows; ++j)
    structure.y[j] = kRadius * ((2.0 * j + 1) / rows - 1 + 0.3 * std::cos(2.0 * j) / rows);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (std::hypot(structure.x[i], structure.y[j]) <= kRadius)
        structure.column.push_back(std::uint32_t(i)), structure.row.push_back(std::uint32_t(j));
  const auto points = Eigen::Index(structure.column.size());
  for (Eigen::Index k = 0; k + 7 < points; k += 3) {
    std::swap(structure.column[std::size_t(k)], structure.column[std::size_t(k + 7)]);
    std::swap(structure.row[std::size_t(k)], structure.row[std::size_t(k + 7)]);
  }
  aberfit::PupilSample pupil;
  pupil.x.resize(points), pupil.y.resize(points);
  pupil.weight = Eigen::ArrayXd::Constant(points, 1.0 / double(points));
  for (Eigen::Index k = 0; k < points; ++k) {
    pupil.x[k] = structure.x[Eigen::Index(structure.column[std::size_t(k)])];
    pupil.y[k] = structure.y[Eigen::Index(structure.row[std::size_t(k)])];
  }
  pupil.structure = structure;
  return pupil;
}

inline std::vector<aberfit::FourierMode> plane_waves(int count) {
  std::vector<aberfit::FourierMode> modes;
  for (int i = 0; i < count; ++i)
    modes.push_back({60.0 * i / count * std::cos(2.4 * i), 60.0 * i / count * std::sin(2.4 * i)});
  return modes;
}

inline double largest_gradient(const aberfit::SurfaceField& f) {
  return std::max(f.slope_x.abs().maxCoeff(), f.slope_y.abs().maxCoeff());
}

/// Largest relative difference of heights or slopes, relative to the largest height or the largest slope.
inline double relative_difference(const aberfit::SurfaceField& a, const aberfit::SurfaceField& b) {
  const double height = (a.height - b.height).abs().maxCoeff() / b.height.abs().maxCoeff();
  const double slope =
      std::max((a.slope_x - b.slope_x).abs().maxCoeff(), (a.slope_y - b.slope_y).abs().maxCoeff());
  return std::max(height, slope / largest_gradient(b));
}

inline double norm(const aberfit::SurfaceField& f) {
  return std::sqrt(f.height.square().sum() + f.slope_x.square().sum() + f.slope_y.square().sum());
}
inline double dot(const aberfit::SurfaceField& a, const aberfit::SurfaceField& b) {
  return (a.height * b.height + a.slope_x * b.slope_x + a.slope_y * b.slope_y).sum();
}

}  // namespace operator_cases
