#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace aberfit::test {

/// Reads a grid sag file as another program would, from the description of the format alone. Lengths [m];
/// rows as in the file, first row at the highest y.
struct SagFile {
  struct Node {
    double z = 0, zx = 0, zy = 0, zxy = 0;
    bool valid = false;
  };
  int nx = 0, ny = 0;
  double step_x = 0, step_y = 0, x_middle = 0, y_middle = 0;
  std::vector<Node> nodes;  ///< ny rows of nx

  double x(int column) const { return x_middle + (column - 0.5 * (nx - 1)) * step_x; }
  double y(int row) const { return y_middle + (0.5 * (ny - 1) - row) * step_y; }
  const Node& node(int row, int column) const {
    return nodes[std::size_t(row) * std::size_t(nx) + std::size_t(column)];
  }
};

inline SagFile parse_sag_file(const std::string& text) {
  constexpr std::array<double, 4> kUnits = {1e-3, 1e-2, 25.4e-3, 1.0};
  std::istringstream lines(text);
  SagFile file;
  bool header = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line == "\r" || line[0] == '!') continue;
    std::istringstream words(line);
    if (!header) {
      int unit = -1;
      words >> file.nx >> file.ny >> file.step_x >> file.step_y >> unit >> file.x_middle >> file.y_middle;
      if (!words || unit != 0) throw std::runtime_error("header: " + line);
      header = true;
      continue;
    }
    SagFile::Node node;
    int nodata = 0;
    words >> node.z >> node.zx >> node.zy >> node.zxy;
    if (!words) throw std::runtime_error("node: " + line);
    words >> nodata;  // may be absent: then it stays 0
    node.valid = nodata == 0;
    file.nodes.push_back(node);
  }
  if (file.nodes.size() != std::size_t(file.nx) * std::size_t(file.ny))
    throw std::runtime_error("node count");
  // Heights and lengths in the unit, slopes without one, the cross derivative per unit.
  const double unit = kUnits[0];
  file.step_x *= unit, file.step_y *= unit, file.x_middle *= unit, file.y_middle *= unit;
  for (SagFile::Node& node : file.nodes) node.z *= unit, node.zxy /= unit;
  return file;
}

struct SagPoint {
  double z = 0, zx = 0, zy = 0;
  bool valid = false;
};

enum class Interpolation { kBicubic, kBilinear };

/// The four weights of cubic Hermite interpolation at t in [0, 1] over an interval of width h (value and
/// slope at the left node, then at the right one), and their derivatives with respect to the coordinate.
struct HermiteWeights {
  std::array<double, 4> value, slope;
  HermiteWeights(double t, double h)
      : value{(1 + 2 * t) * (1 - t) * (1 - t), h * t * (1 - t) * (1 - t), t * t * (3 - 2 * t),
              h * t * t * (t - 1)},
        slope{6 * t * (t - 1) / h, (1 - t) * (1 - 3 * t), 6 * t * (1 - t) / h, t * (3 * t - 2)} {}
};

inline SagPoint evaluate(const SagFile& file, double x, double y, Interpolation how) {
  const double u = (x - file.x(0)) / file.step_x, v = (file.y(0) - y) / file.step_y;
  if (!(u >= -1e-9 && v >= -1e-9 && u <= file.nx - 1 + 1e-9 && v <= file.ny - 1 + 1e-9)) return {};
  const int column = std::clamp(int(u), 0, file.nx - 2), row = std::clamp(int(v), 0, file.ny - 2);
  const double s = u - column, t = 1 - (v - row);  // t runs upwards, from the lower row of the file's cell
  const SagFile::Node* corner[2][2] = {{&file.node(row + 1, column), &file.node(row, column)},
                                       {&file.node(row + 1, column + 1), &file.node(row, column + 1)}};
  SagPoint point;
  point.valid = true;
  const HermiteWeights a(s, file.step_x), b(t, file.step_y);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const SagFile::Node& n = *corner[i][j];
      point.valid = point.valid && n.valid;
      if (how == Interpolation::kBilinear) {
        const double wx = i == 0 ? 1 - s : s, wy = j == 0 ? 1 - t : t;
        point.z += n.z * wx * wy;
        point.zx += n.z * (i == 0 ? -1 : 1) / file.step_x * wy;
        point.zy += n.z * wx * (j == 0 ? -1 : 1) / file.step_y;
        continue;
      }
      const auto sum = [&](const std::array<double, 4>& p, const std::array<double, 4>& q) {
        const std::size_t k = std::size_t(2 * i), l = std::size_t(2 * j);
        return n.z * p[k] * q[l] + n.zx * p[k + 1] * q[l] + n.zy * p[k] * q[l + 1] +
               n.zxy * p[k + 1] * q[l + 1];
      };
      point.z += sum(a.value, b.value);
      point.zx += sum(a.slope, b.value);
      point.zy += sum(a.value, b.slope);
    }
  return point;
}

}  // namespace aberfit::test
