#include "processing.h"

#include <algorithm>

#include "window.h"

namespace aberfit::internal {

void SurfaceProcessing::prepare(WindowKind window) {
  window_x = window_values(window, grid.cols);
  window_y = grid.profile() ? Eigen::ArrayXd(Eigen::ArrayXd::Ones(1)) : window_values(window, grid.rows);
  transform = std::make_unique<FourierTransform>(grid.rows, grid.cols);
}

void SurfaceProcessing::apply_window(ComplexGrid* samples) const {
  for (int j = 0; j < grid.rows; ++j) samples->row(j) *= window_y[j] * window_x.transpose();
}

Eigen::ArrayXd SurfaceProcessing::power(ComplexGrid windowed) const {
  transform_and_restore(&windowed);
  return windowed.reshaped<Eigen::RowMajor>().abs2();
}

ComplexGrid SurfaceProcessing::wave_transform(double u, double v) const {
  ComplexGrid samples = wave(u, v);
  transform_and_restore(&samples);
  return samples;
}

void SurfaceProcessing::transform_and_restore(ComplexGrid* windowed) const {
  (*transform)(windowed->data());
  if (restored.size() > 0) windowed->reshaped<Eigen::RowMajor>() *= restored;
}

double median_of(std::vector<double>* values) {
  const auto middle = values->begin() + std::ptrdiff_t(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace aberfit::internal
