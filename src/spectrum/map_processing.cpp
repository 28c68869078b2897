#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/smooth_number.h"
#include "detrend_basis.h"
#include "processing.h"
#include "window.h"

namespace aberfit::internal {
namespace {

constexpr Eigen::Index kFewestPoints = 4;  // along either side

// Largest hole, as a fraction of the rectangle. A bridge over a larger hole says nothing about the surface.
constexpr double kLargestHole = 0.05;

using Marks = Eigen::Array<char, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Places = std::vector<std::pair<Eigen::Index, Eigen::Index>>;

// Marks and returns the invalid points connected to (row, column) by invalid points along rows and columns.
Places mark_joined(const HeightMap& map, Eigen::Index row, Eigen::Index column, Marks* marks) {
  Places joined;
  const auto visit = [&](Eigen::Index r, Eigen::Index c) {
    if (r < 0 || c < 0 || r >= map.rows() || c >= map.columns() || (*marks)(r, c) ||
        std::isfinite(map.height(r, c)))
      return;
    (*marks)(r, c) = 1;
    joined.emplace_back(r, c);
  };
  visit(row, column);
  for (std::size_t i = 0; i < joined.size(); ++i) {
    const auto [r, c] = joined[i];
    visit(r - 1, c), visit(r + 1, c), visit(r, c - 1), visit(r, c + 1);
  }
  return joined;
}

// Returns the largest rectangle without a marked point, by the histogram of free heights above each row.
PixelRectangle largest_rectangle(const Marks& outside) {
  const Eigen::Index rows = outside.rows(), columns = outside.cols();
  PixelRectangle best;
  std::vector<Eigen::Index> height(std::size_t(columns) + 1, 0), stack;
  for (Eigen::Index r = 0; r < rows; ++r) {
    for (Eigen::Index c = 0; c < columns; ++c)
      height[std::size_t(c)] = outside(r, c) ? 0 : height[std::size_t(c)] + 1;
    stack.clear();
    for (Eigen::Index c = 0; c <= columns; ++c) {
      while (!stack.empty() && height[std::size_t(stack.back())] >= height[std::size_t(c)]) {
        const Eigen::Index tall = height[std::size_t(stack.back())];
        stack.pop_back();
        const Eigen::Index from = stack.empty() ? 0 : stack.back() + 1;
        if (tall * (c - from) > best.rows * best.columns) best = {r + 1 - tall, from, tall, c - from};
      }
      stack.push_back(c);
    }
  }
  return best;
}

}  // namespace

PixelRectangle largest_inner_rectangle(const HeightMap& map) {
  const Eigen::Index rows = map.rows(), columns = map.columns();
  Marks outside = Marks::Zero(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r)
    mark_joined(map, r, 0, &outside), mark_joined(map, r, columns - 1, &outside);
  for (Eigen::Index c = 0; c < columns; ++c)
    mark_joined(map, 0, c, &outside), mark_joined(map, rows - 1, c, &outside);
  Marks seen = outside;
  std::vector<Places> holes;
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < columns; ++c)
      if (Places hole = mark_joined(map, r, c, &seen); !hole.empty()) holes.push_back(std::move(hole));
  for (;;) {
    const PixelRectangle best = largest_rectangle(outside);
    const double most = kLargestHole * double(best.rows * best.columns);
    bool avoided = false;
    for (Places& hole : holes) {
      double inside = 0;
      for (const auto& [r, c] : hole)
        inside +=
            r >= best.row && r < best.row + best.rows && c >= best.column && c < best.column + best.columns;
      if (inside <= most) continue;
      for (const auto& [r, c] : hole) outside(r, c) = 1;
      hole.clear();
      avoided = true;
    }
    if (!avoided) return best;
  }
}

MapProcessing::MapProcessing(const HeightMap& geometry, const PsdEstimatorOptions& options) {
  for (const auto& [pitch, name] :
       {std::pair{geometry.pitch_x, "pitch_x"}, std::pair{geometry.pitch_y, "pitch_y"}})
    if (!(pitch > 0) || !std::isfinite(pitch))
      throw std::invalid_argument(std::string(name) +
                                  " of the map is unknown (0): give the distance of its points in metres");
  PixelRectangle inner = largest_inner_rectangle(geometry);
  // A prime length would make the transform several times slower; cutting costs about 1 % of the data.
  const Eigen::Index rows = smooth_up_to(inner.rows), columns = smooth_up_to(inner.columns);
  row_ = inner.row + (inner.rows - rows) / 2;
  column_ = inner.column + (inner.columns - columns) / 2;
  grid = {int(rows), int(columns), 1 / (double(columns) * geometry.pitch_x),
          1 / (double(rows) * geometry.pitch_y)};
  if (rows < kFewestPoints || columns < kFewestPoints)
    throw std::invalid_argument(
        "a map needs a rectangle of at least 4 x 4 points inside its outline for a PSD");
  std::vector<int> hole_of(std::size_t(grid.size()), -1);
  for (int i = 0; i < grid.size(); ++i)
    if (!std::isfinite(geometry.height(row_ + i / grid.cols, column_ + i % grid.cols)))
      hole_of[std::size_t(i)] = int(holes_.size()), holes_.push_back(i);
  if (grid.size() - int(holes_.size()) < 16)
    throw std::invalid_argument("a map needs at least 16 valid points for a PSD");
  // Harmonic bridge: a hole point is the mean of its four neighbours, weighted by 1/pitch^2.
  const double weight_x = 1, weight_y = std::pow(geometry.pitch_x / geometry.pitch_y, 2);
  std::vector<Eigen::Triplet<double>> entries;
  for (int h = 0; h < int(holes_.size()); ++h) {
    const int r = holes_[std::size_t(h)] / grid.cols, c = holes_[std::size_t(h)] % grid.cols;
    double diagonal = 0;
    const auto neighbour = [&](int rr, int cc, double weight) {
      if (rr < 0 || cc < 0 || rr >= grid.rows || cc >= grid.cols) return;
      const int at = rr * grid.cols + cc;
      diagonal += weight;
      if (hole_of[std::size_t(at)] >= 0)
        entries.emplace_back(h, hole_of[std::size_t(at)], -weight);
      else
        links_.push_back({h, at, weight});
    };
    neighbour(r - 1, c, weight_y), neighbour(r + 1, c, weight_y);
    neighbour(r, c - 1, weight_x), neighbour(r, c + 1, weight_x);
    entries.emplace_back(h, h, diagonal);
  }
  if (!holes_.empty()) {
    Eigen::SparseMatrix<double> matrix(Eigen::Index(holes_.size()), Eigen::Index(holes_.size()));
    matrix.setFromTriplets(entries.begin(), entries.end());
    laplacian_.compute(matrix);
  }
  const int degree = polynomial_degree(options.detrend, false);
  if (degree >= 0) {
    const auto steps = [](int n) { return Eigen::ArrayXd::LinSpaced(n, 0, n - 1); };
    across_ = legendre_basis(steps(grid.cols), 0, grid.cols - 1, degree);
    down_ = legendre_basis(steps(grid.rows), 0, grid.rows - 1, degree);
    products_ = products_up_to(degree);
    const Eigen::MatrixXd gx = across_.transpose() * across_, gy = down_.transpose() * down_;
    const Eigen::Index n = Eigen::Index(products_.size());
    Eigen::MatrixXd gram(n, n);
    for (Eigen::Index a = 0; a < n; ++a)
      for (Eigen::Index b = 0; b < n; ++b) {
        const auto [ax, ay] = products_[std::size_t(a)];
        const auto [bx, by] = products_[std::size_t(b)];
        gram(a, b) = gx(ax, bx) * gy(ay, by);
        for (const int h : holes_)
          gram(a, b) -= across_(h % grid.cols, ax) * down_(h / grid.cols, ay) * across_(h % grid.cols, bx) *
                        down_(h / grid.cols, by);
      }
    inverse_gram_ = solve_symmetric(gram, Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)));
  }
  prepare(options.window);
  along_x_ = std::make_unique<FourierTransform>(1, grid.cols);
  along_y_ = std::make_unique<FourierTransform>(1, grid.rows);
  across_transform_ = window_x.matrix().asDiagonal() * across_;
  down_transform_ = window_y.matrix().asDiagonal() * down_;
  for (Eigen::Index i = 0; i < across_.cols(); ++i) {
    (*along_x_)(across_transform_.col(i).data());
    (*along_y_)(down_transform_.col(i).data());
  }
}

void MapProcessing::bridge(ComplexGrid* samples) const {
  if (holes_.empty()) return;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(Eigen::Index(holes_.size()), 2);
  for (const Link& link : links_) {
    const std::complex<double> value = samples->data()[link.from];
    right(link.hole, 0) += link.weight * value.real();
    right(link.hole, 1) += link.weight * value.imag();
  }
  const Eigen::MatrixXd filled = laplacian_.solve(right);
  for (std::size_t h = 0; h < holes_.size(); ++h)
    samples->data()[holes_[h]] = {filled(Eigen::Index(h), 0), filled(Eigen::Index(h), 1)};
}

MapProcessing::Separable MapProcessing::separable(double u, double v) const {
  Separable wave{Eigen::VectorXcd(grid.cols), Eigen::VectorXcd(grid.rows), {}};
  for (int i = 0; i < grid.cols; ++i) wave.x[i] = std::polar(1.0, 2 * kPi * u * i / grid.cols);
  for (int j = 0; j < grid.rows; ++j) wave.y[j] = std::polar(1.0, 2 * kPi * v * j / grid.rows);
  const Eigen::Index n = Eigen::Index(products_.size());
  if (n == 0) return wave;
  // Moments of the separable wave over the full rectangle, minus those of the holes.
  const Eigen::VectorXcd mx = across_.transpose() * wave.x, my = down_.transpose() * wave.y;
  Eigen::VectorXcd moment(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const auto [i, j] = products_[std::size_t(a)];
    moment[a] = mx[i] * my[j];
    for (const int h : holes_)
      moment[a] -=
          wave.x[h % grid.cols] * wave.y[h / grid.cols] * across_(h % grid.cols, i) * down_(h / grid.cols, j);
  }
  const Eigen::VectorXcd coefficient = inverse_gram_ * moment;
  wave.shape = Eigen::MatrixXcd::Zero(across_.cols(), across_.cols());
  for (Eigen::Index a = 0; a < n; ++a)
    wave.shape(products_[std::size_t(a)].first, products_[std::size_t(a)].second) = coefficient[a];
  return wave;
}

ComplexGrid MapProcessing::wave(double u, double v) const {
  const Separable wave = separable(u, v);
  ComplexGrid samples(grid.rows, grid.cols);
  Eigen::MatrixXcd along;
  if (wave.shape.size() > 0) along = wave.shape * down_.transpose();
  for (int j = 0; j < grid.rows; ++j) {
    samples.row(j) = (wave.y[j] * wave.x).transpose().array();
    for (Eigen::Index i = 0; i < along.rows(); ++i)
      samples.row(j) -= along(i, j) * across_.col(i).transpose().array().cast<std::complex<double>>();
  }
  bridge(&samples);
  apply_window(&samples);
  return samples;
}

ComplexGrid MapProcessing::wave_transform(double u, double v) const {
  if (!holes_.empty()) return SurfaceProcessing::wave_transform(u, v);
  // Without holes everything is separable, and two short transforms are enough.
  const Separable wave = separable(u, v);
  Eigen::VectorXcd x = wave.x.cwiseProduct(window_x.matrix()), y = wave.y.cwiseProduct(window_y.matrix());
  (*along_x_)(x.data());
  (*along_y_)(y.data());
  ComplexGrid result(grid.rows, grid.cols);
  Eigen::MatrixXcd along;
  if (wave.shape.size() > 0) along = wave.shape * down_transform_.transpose();
  for (int j = 0; j < grid.rows; ++j) {
    result.row(j) = (y[j] * x).transpose().array();
    for (Eigen::Index i = 0; i < along.rows(); ++i)
      result.row(j) -= along(i, j) * across_transform_.col(i).transpose().array();
  }
  return result;
}

HeightMap MapProcessing::region(const HeightMap& map) const {
  HeightMap part = map;
  part.height = map.height.block(row_, column_, grid.rows, grid.cols);
  part.x0 = map.x(column_), part.y0 = map.y(row_);
  return part;
}

ComplexGrid MapProcessing::windowed(const HeightMap& region) const {
  ComplexGrid samples = region.height.cast<std::complex<double>>();
  bridge(&samples);
  apply_window(&samples);
  return samples;
}

}  // namespace aberfit::internal
