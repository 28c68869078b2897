#pragma once
#include <Eigen/Core>
#include <complex>
#include <cstddef>

namespace aberfit {

/// Memory aligned as FFTW's vector code likes it. Not initialised.
template <typename T>
class FftwArray {
 public:
  explicit FftwArray(std::size_t size);
  ~FftwArray();
  FftwArray(FftwArray&&) = delete;
  T* data() { return data_; }
  const T* data() const { return data_; }

 private:
  T* data_;
};

/// Transforms between a pupil of rows x columns cells and a focal plane of m_rows x m_columns >= (2 rows - 1)
/// x (2 columns - 1) samples, leaving out the rows or columns that are known to be zero or are not wanted.
/// Planned once, by estimate, so that the same bits come out every time.
class PupilTransform {
 public:
  /// padding: focal samples over pupil cells, at least 2.
  PupilTransform(int rows, int columns, double padding);
  ~PupilTransform();
  PupilTransform(const PupilTransform&) = delete;
  PupilTransform& operator=(const PupilTransform&) = delete;

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int m_rows() const { return m_rows_; }
  int m_columns() const { return m_columns_; }
  std::size_t stride() const { return stride_; }            ///< of rows of focal fields, complex numbers
  std::size_t half_stride() const { return half_stride_; }  ///< of rows of half spectra, complex numbers
  std::size_t real_stride() const { return std::size_t(m_columns_); }

  /// What one plane works in.
  struct Buffers {
    explicit Buffers(const PupilTransform& transform);
    FftwArray<std::complex<double>> focal;  ///< F, stride()
    FftwArray<std::complex<double>>
        scratch;             ///< another field with stride(), or a half spectrum with half_stride()
    FftwArray<double> real;  ///< |F|^2 or a kernel in the focal plane, real_stride()
  };

  /// F(X) = sum_k E_k exp(-2 pi i k.X/m). On entry: E in the first rows x columns of `focal`, zero elsewhere.
  void to_focus(Buffers* buffers) const;
  /// H(m) = sum_X |F(X)|^2 exp(-2 pi i m.X/m) into `scratch`, m_x = 0 .. columns-1 (rows m_y modulo m_rows):
  /// m_rows m_columns times the complex conjugate of C_m = sum_k E_(k+m) conj(E_k).
  void correlation(Buffers* buffers) const;
  /// K(X) = sum_m g(m) exp(+2 pi i m.X/m) into `real`. On entry: g(m) in `scratch`, m_x = 0 .. columns-1 and
  /// zero for the other m_x; g(-m) = conj(g(m)).
  void kernel(Buffers* buffers) const;
  /// V_k = sum_X K(X) F(X) exp(+2 pi i k.X/m) into the first rows x columns of `scratch` (with stride()).
  void back_to_pupil(Buffers* buffers) const;

 private:
  int rows_, columns_, m_rows_, m_columns_;
  std::size_t stride_, half_stride_;
  void *forward_columns_, *forward_rows_;
  void *power_rows_, *power_columns_;
  void *kernel_columns_, *kernel_rows_;
  void *backward_rows_, *backward_columns_;
};

/// Smallest even 2^a 3^b 5^c 7^d >= n.
int fast_transform_size(int n);

}  // namespace aberfit
