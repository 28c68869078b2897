#pragma once
#include <complex>
#include <memory>
#include <mutex>

namespace aberfit {

/// Forward complex Fourier transform of a rows x cols array (row after row), in place, unnormalised. It is
/// planned once, gives the same bits every time, and may be called from many threads. Sides of at least 64
/// without prime factors above 7 use the library's own kernels (line_kernel.h). They are faster than FFTW's
/// estimated plans, the only FFTW plans that do not depend on measured times.
class FourierTransform {
 public:
  FourierTransform(int rows, int cols);
  ~FourierTransform();
  FourierTransform(const FourierTransform&) = delete;
  FourierTransform& operator=(const FourierTransform&) = delete;
  void operator()(std::complex<double>* values) const;

 private:
  struct Side;
  struct Lines;
  void* plan_ = nullptr;  // plan of FFTW, unless `lines_` is set
  std::unique_ptr<const Lines> lines_;
};

/// Forward Fourier transform sum_jk values(j, k) exp(-2 pi i (j r/rows + k c/columns)) of a rows x columns
/// array (row after row), in place, unnormalised. rows = 1 for one dimension. Any size; many threads may call
/// it; the bits are always the same.
void fourier_transform(int rows, int columns, std::complex<double>* values);

/// Lock for creating or destroying a plan of FFTW, for the whole library. FFTW's planner, unlike its
/// execution, must not run twice at once.
std::mutex& fftw_planner();

}  // namespace aberfit
