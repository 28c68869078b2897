#include "fftw.h"

#include <fftw3.h>

#include <mutex>
#include <vector>

namespace aberfit {
namespace {

// FFTW's planner, unlike its execution, must not run twice at a time.
std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

fftw_complex* as_fftw(std::complex<double>* values) { return reinterpret_cast<fftw_complex*>(values); }

}  // namespace

FourierTransform::FourierTransform(int rows, int cols) {
  std::vector<std::complex<double>> scratch(std::size_t(rows) * std::size_t(cols));
  const std::lock_guard lock(planner());
  plan_ = fftw_plan_dft_2d(rows, cols, as_fftw(scratch.data()), as_fftw(scratch.data()), FFTW_FORWARD,
                           FFTW_ESTIMATE | FFTW_UNALIGNED);
}

FourierTransform::~FourierTransform() {
  const std::lock_guard lock(planner());
  fftw_destroy_plan(static_cast<fftw_plan>(plan_));
}

void FourierTransform::operator()(std::complex<double>* values) const {
  fftw_execute_dft(static_cast<fftw_plan>(plan_), as_fftw(values), as_fftw(values));
}

}  // namespace aberfit
