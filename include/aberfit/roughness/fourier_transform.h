#pragma once
#include <complex>
#include <memory>
#include <mutex>

namespace aberfit {

/// Forward complex transform of a rows x cols array (row after row), in place, unnormalised. Planned once;
/// the same bits come out every time; calls from many threads at once are safe. Fields of 64 x 64 and more
/// whose sides have no prime factor above 7 go by the library's own lines (line_kernel.h): with FFTW's plans
/// by estimate, the only ones that do not depend on what a clock said, the cut of a deep band took 7.6 s
/// for 5.3.
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
  void* plan_ = nullptr;  // of FFTW, or
  std::unique_ptr<const Lines> lines_;
};

/// Forward transform sum_jk values(j, k) exp(-2 pi i (j r/rows + k c/columns)) of a rows x columns array (row
/// after row), in place, unnormalised; rows = 1 for one dimension. Any size; safe to call from many threads
/// at once; the same bits every time.
void fourier_transform(int rows, int columns, std::complex<double>* values);

/// Held while a plan of FFTW is made or destroyed: its planner, unlike its execution, must not run twice at a
/// time. One for the whole library.
std::mutex& fftw_planner();

}  // namespace aberfit
