#include "aberfit/roughness/fourier_transform.h"

#include <fftw3.h>

#include <vector>

namespace aberfit {
namespace {

fftw_complex* as_fftw(std::complex<double>* values) { return reinterpret_cast<fftw_complex*>(values); }

}  // namespace

std::mutex& fftw_planner() {
  static std::mutex mutex;
  return mutex;
}

FourierTransform::FourierTransform(int rows, int cols) {
  std::vector<std::complex<double>> scratch(std::size_t(rows) * std::size_t(cols));
  const std::lock_guard lock(fftw_planner());
  plan_ = fftw_plan_dft_2d(rows, cols, as_fftw(scratch.data()), as_fftw(scratch.data()), FFTW_FORWARD,
                           FFTW_ESTIMATE | FFTW_UNALIGNED);
}

FourierTransform::~FourierTransform() {
  const std::lock_guard lock(fftw_planner());
  fftw_destroy_plan(static_cast<fftw_plan>(plan_));
}

void FourierTransform::operator()(std::complex<double>* values) const {
  fftw_execute_dft(static_cast<fftw_plan>(plan_), as_fftw(values), as_fftw(values));
}

void fourier_transform(int rows, int columns, std::complex<double>* values) {
  const FourierTransform transform(rows, columns);  // planning by estimate costs little beside the transform
  transform(values);
}

}  // namespace aberfit
