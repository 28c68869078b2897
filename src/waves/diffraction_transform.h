#pragma once
#include <Eigen/Core>
#include <complex>
#include <cstddef>

namespace aberfit::internal {

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
/// Lines go through the cache one by one, from where they lie to where they belong: one plan for all of a
/// length. Planned once, by estimate, so that the same bits come out every time.
class PupilTransform {
 public:
  /// padding: focal samples over pupil cells, at least 2.
  PupilTransform(int rows, int columns, double padding);
  ~PupilTransform();
  PupilTransform(const PupilTransform&) = delete;
  PupilTransform& operator=(const PupilTransform&) = delete;

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int m_rows() const { return m_rows_; }  ///< even, as m_columns
  int m_columns() const { return m_columns_; }
  std::size_t stride() const { return stride_; }  ///< of rows of focal fields, complex numbers
  std::size_t focal_size() const { return std::size_t(m_rows_) * stride_; }
  std::size_t pupil_stride() const { return pupil_stride_; }  ///< of rows of `pupil`
  /// Rows 0 .. m_rows/2 of what is even along both axes, columns 0 .. m_columns/2 of each.
  int quarter_rows() const { return m_rows_ / 2 + 1; }
  int quarter_columns() const { return m_columns_ / 2 + 1; }
  std::size_t quarter_stride() const { return quarter_stride_; }
  std::size_t quarter_size() const { return std::size_t(quarter_rows()) * quarter_stride_; }

  /// What one thread works in.
  struct Buffers {
    explicit Buffers(const PupilTransform& transform);
    FftwArray<std::complex<double>> pupil;    ///< rows x columns, pupil_stride()
    FftwArray<double> quarter;                ///< quarter_stride()
    Eigen::ArrayXd power_x, power_y;          ///< sums of |F|^2 over columns' and rows' samples
    FftwArray<std::complex<double>> half;     ///< m_rows x columns, likewise
    FftwArray<std::complex<double>> in, out;  ///< lines
  };

  /// F(X) = sum_k E_k exp(-2 pi i k.X/m) from E in `pupil`.
  void to_focus(std::complex<double>* focal, Buffers* buffers) const;
  /// sum_X |F(X)|^2 cos(2 pi m_x X/m) cos(2 pi m_y Y/m) into `quarter`, m < columns and rows: m_rows
  /// m_columns times Re(C_(mx,my) + C_(mx,-my))/2, C_m = sum_k E_(k+m) conj(E_k). Sets power_x and power_y.
  void correlation(const std::complex<double>* focal, Buffers* buffers) const;
  /// m_rows m_columns C_(m,0) and C_(0,m) from power_x and power_y.
  Eigen::ArrayXcd correlation_along_x(const Buffers& buffers) const;
  Eigen::ArrayXcd correlation_along_y(const Buffers& buffers) const;
  /// K(X) = sum_m g(m) exp(+2 pi i m.X/m) in place in `quarter`, g even along both axes; on entry zero for m
  /// beyond columns and rows.
  void kernel(Buffers* buffers) const;
  /// Re sum_m g(m) exp(+2 pi i m X/m), m = 0 .. g.size()-1, for each X.
  Eigen::ArrayXd kernel_along_x(const Eigen::ArrayXcd& g) const;
  Eigen::ArrayXd kernel_along_y(const Eigen::ArrayXcd& g) const;
  /// V_k = sum_X K(X) F(X) exp(+2 pi i k.X/m) into `pupil`, K from `quarter` ...
  void back_to_pupil(const std::complex<double>* focal, Buffers* buffers) const;
  /// ... or K(X, Y) = along_x(X) + along_y(Y).
  void back_to_pupil(const std::complex<double>* focal, const Eigen::ArrayXd& along_x,
                     const Eigen::ArrayXd& along_y, Buffers* buffers) const;

 private:
  void even_transform(int rows_in, int columns_out, Buffers* buffers) const;
  template <typename Weights>
  void back(const std::complex<double>* focal, const Weights& set_weights, Buffers* buffers) const;

  int rows_, columns_, m_rows_, m_columns_;
  std::size_t stride_, pupil_stride_, quarter_stride_, line_stride_;
  void *forward_x_, *forward_y_, *backward_x_, *backward_y_;
};

/// Smallest even 2^a 3^b 5^c 7^d >= n.
int fast_transform_size(int n);

}  // namespace aberfit::internal
