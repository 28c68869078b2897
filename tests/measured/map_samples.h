#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/measured/height_map.h"

namespace aberfit::test {

/// A map without symmetry, which reveals a flip, transposition or swap of nx and ny: a tilted, wavy surface,
/// a bump near the corner (+x, +y) at (row rows - 2, column columns - 3), two holes. offset shifts all
/// heights [m].
inline HeightMap marker_map(Eigen::Index rows, Eigen::Index columns, double pitch, double offset = 0) {
  HeightMap map;
  map.height = Grid(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      map.height(r, c) =
          offset + 1e-9 * (0.37 * double(c) - 0.23 * double(r) + std::sin(1.7 * double(r + 2 * c)));
  map.height(rows - 2, columns - 3) += 50e-9;
  map.height(0, 1) = map.height(2, columns - 1) = std::numeric_limits<double>::quiet_NaN();
  map.pitch_x = map.pitch_y = pitch;
  centre_on_grid(&map);
  map.label = "marker";
  return map;
}

/// Expects the same shape, holes and positions, and heights within `tolerance`.
inline void expect_same_map(const HeightMap& found, const HeightMap& expected, double tolerance) {
  ASSERT_EQ(found.rows(), expected.rows());
  ASSERT_EQ(found.columns(), expected.columns());
  for (Eigen::Index r = 0; r < found.rows(); ++r)
    for (Eigen::Index c = 0; c < found.columns(); ++c) {
      const double a = found.height(r, c), b = expected.height(r, c);
      ASSERT_EQ(std::isfinite(a), std::isfinite(b)) << r << " " << c;
      if (std::isfinite(b)) {
        ASSERT_NEAR(a, b, tolerance) << r << " " << c;
      }
    }
}

/// Returns the InputError that `read` throws; fails the test if there is none.
inline InputError refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return InputError("", "", "", "");
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace aberfit::test
