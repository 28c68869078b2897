#include "diffraction_transform.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>

#include "aberfit/roughness/fourier_transform.h"

namespace aberfit {
namespace {

fftw_complex* as_fftw(std::complex<double>* values) { return reinterpret_cast<fftw_complex*>(values); }
fftw_plan as_plan(void* plan) { return static_cast<fftw_plan>(plan); }

// `count` in-place transforms of length n.
fftw_plan plan_many(int n, int count, std::complex<double>* data, std::size_t step, std::size_t distance,
                    int sign) {
  return fftw_plan_many_dft(1, &n, count, as_fftw(data), nullptr, int(step), int(distance), as_fftw(data),
                            nullptr, int(step), int(distance), sign, FFTW_ESTIMATE);
}

// Rows a power of two apart would all fall on the same few lines of the cache when columns are transformed.
constexpr std::size_t kSkew = 4;

int padded(int n, double padding) {
  return fast_transform_size(std::max(2 * n - 1, int(std::ceil(padding * n - 1e-9))));
}

}  // namespace

int fast_transform_size(int n) {
  for (int m = std::max(2, n + n % 2);; m += 2) {
    int rest = m;
    for (const int prime : {2, 3, 5, 7})
      while (rest % prime == 0) rest /= prime;
    if (rest == 1) return m;
  }
}

template <typename T>
FftwArray<T>::FftwArray(std::size_t size) : data_(static_cast<T*>(fftw_malloc(size * sizeof(T)))) {
  if (!data_) throw std::bad_alloc();
}
template <typename T>
FftwArray<T>::~FftwArray() {
  fftw_free(data_);
}
template class FftwArray<double>;
template class FftwArray<std::complex<double>>;

PupilTransform::Buffers::Buffers(const PupilTransform& t)
    : focal(std::size_t(t.m_rows_) * t.stride_),
      scratch(std::size_t(t.m_rows_) * t.stride_),
      real(std::size_t(t.m_rows_) * t.real_stride()) {}

PupilTransform::PupilTransform(int rows, int columns, double padding)
    : rows_(rows),
      columns_(columns),
      m_rows_(padded(rows, padding)),
      m_columns_(padded(columns, padding)),
      stride_(std::size_t(m_columns_) + kSkew),
      half_stride_(std::size_t(m_columns_) / 2 + 1 + kSkew) {
  Buffers buffers(*this);
  std::complex<double>* focal = buffers.focal.data();
  std::complex<double>* half = buffers.scratch.data();
  double* real = buffers.real.data();
  const int m = m_columns_, half_stride = int(half_stride_);
  const std::lock_guard lock(fftw_planner());
  forward_columns_ = plan_many(m_rows_, columns_, focal, stride_, 1, FFTW_FORWARD);
  forward_rows_ = plan_many(m, m_rows_, focal, 1, stride_, FFTW_FORWARD);
  power_rows_ = fftw_plan_many_dft_r2c(1, &m, m_rows_, real, nullptr, 1, m, as_fftw(half), nullptr, 1,
                                       half_stride, FFTW_ESTIMATE);
  power_columns_ = plan_many(m_rows_, columns_, half, half_stride_, 1, FFTW_FORWARD);
  kernel_columns_ = plan_many(m_rows_, columns_, half, half_stride_, 1, FFTW_BACKWARD);
  kernel_rows_ = fftw_plan_many_dft_c2r(1, &m, m_rows_, as_fftw(half), nullptr, 1, half_stride, real, nullptr,
                                        1, m, FFTW_ESTIMATE);
  backward_rows_ = plan_many(m, m_rows_, focal, 1, stride_, FFTW_BACKWARD);
  backward_columns_ = plan_many(m_rows_, columns_, focal, stride_, 1, FFTW_BACKWARD);
}

PupilTransform::~PupilTransform() {
  const std::lock_guard lock(fftw_planner());
  for (void* plan : {forward_columns_, forward_rows_, power_rows_, power_columns_, kernel_columns_,
                     kernel_rows_, backward_rows_, backward_columns_})
    fftw_destroy_plan(as_plan(plan));
}

void PupilTransform::to_focus(Buffers* b) const {
  fftw_complex* focal = as_fftw(b->focal.data());
  fftw_execute_dft(as_plan(forward_columns_), focal, focal);
  fftw_execute_dft(as_plan(forward_rows_), focal, focal);
}

void PupilTransform::correlation(Buffers* b) const {
  for (int row = 0; row < m_rows_; ++row) {
    const std::complex<double>* field = b->focal.data() + std::size_t(row) * stride_;
    double* power = b->real.data() + std::size_t(row) * real_stride();
    for (int i = 0; i < m_columns_; ++i)
      power[i] = field[i].real() * field[i].real() + field[i].imag() * field[i].imag();
  }
  fftw_complex* half = as_fftw(b->scratch.data());
  fftw_execute_dft_r2c(as_plan(power_rows_), b->real.data(), half);
  fftw_execute_dft(as_plan(power_columns_), half, half);
}

void PupilTransform::kernel(Buffers* b) const {
  fftw_complex* half = as_fftw(b->scratch.data());
  fftw_execute_dft(as_plan(kernel_columns_), half, half);
  fftw_execute_dft_c2r(as_plan(kernel_rows_), half, b->real.data());
}

void PupilTransform::back_to_pupil(Buffers* b) const {
  for (int row = 0; row < m_rows_; ++row) {
    const std::complex<double>* field = b->focal.data() + std::size_t(row) * stride_;
    const double* weight = b->real.data() + std::size_t(row) * real_stride();
    std::complex<double>* out = b->scratch.data() + std::size_t(row) * stride_;
    for (int i = 0; i < m_columns_; ++i) out[i] = weight[i] * field[i];
  }
  fftw_complex* out = as_fftw(b->scratch.data());
  fftw_execute_dft(as_plan(backward_rows_), out, out);
  fftw_execute_dft(as_plan(backward_columns_), out, out);
}

}  // namespace aberfit
