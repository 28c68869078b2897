#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "aberfit/roughness/line_kernel.h"

namespace aberfit::internal {

enum class Precision { kDouble, kSingle };

inline std::size_t bytes_of_number(Precision precision) {
  return precision == Precision::kDouble ? sizeof(double) : sizeof(float);
}

/// Uninitialised numbers, aligned to a cache line.
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size, Precision precision = Precision::kDouble);
  ~AlignedArray();
  AlignedArray(AlignedArray&&) = delete;
  /// Real must match the precision: double or float.
  template <typename Real = double>
  Real* data() {
    return static_cast<Real*>(data_);
  }
  template <typename Real = double>
  const Real* data() const {
    return static_cast<const Real*>(data_);
  }

 private:
  void* data_;
};

/// Memory layout of a field of rows x columns cells for the line kernels. Eight columns lie side by side,
/// real parts before imaginary parts. Rows have gaps between them. A stride of a power of two would map all
/// rows to the same few cache lines.
struct FieldLayout {
  int rows = 0, columns = 0;
  int blocks() const { return (columns + kLines - 1) / kLines; }
  std::size_t stride() const { return std::size_t(blocks()) * 2 * kLines + kLines; }   ///< stride of rows
  std::size_t real_stride() const { return std::size_t(blocks()) * kLines + kLines; }  ///< for real rows
  std::size_t size() const { return std::size_t(rows) * stride(); }
  /// Index of the real part; the imaginary part is kLines later.
  std::size_t at(std::size_t row, std::size_t column) const {
    return row * stride() + column / kLines * (2 * kLines) + column % kLines;
  }
};

/// Transforms between a pupil of rows x columns cells and a focal plane of m_rows x m_columns = 2 n_y x 2 n_x
/// samples. Even and odd samples along an axis are separate transforms of length n. So zeros around the pupil
/// cost no time and lines stay in the first-level cache. Cells and lags are in double precision. Focal
/// fields, kernels and intermediate data may be in single precision: half the memory, about half the time,
/// and errors of about 2e-7 of the largest output.
class PupilTransform {
 public:
  /// padding: focal samples over pupil cells, at least 1. From 2 on correlations are exact. With less
  /// padding, the lags m and m_columns - m merge, and lags of m_columns/2 or more do not exist.
  PupilTransform(int rows, int columns, double padding, Precision precision = Precision::kDouble);

  /// Precision of focal fields and kernels.
  Precision precision() const {
    return std::holds_alternative<Plans<double>>(plans_) ? Precision::kDouble : Precision::kSingle;
  }
  const FieldLayout& pupil() const { return pupil_; }
  int rows() const { return pupil_.rows; }
  int columns() const { return pupil_.columns; }
  int m_rows() const { return 2 * n_y_; }
  int m_columns() const { return 2 * n_x_; }
  /// Number of lags of correlations and kernels, from lag 0.
  int lag_rows() const { return std::min(rows(), n_y_); }
  int lag_columns() const { return std::min(columns(), n_x_); }
  /// Numbers in a focal field. Groups of rows lie beside their mirror images about Y = 0.
  std::size_t focal_size() const { return groups_.size() * 2 * group_size(); }
  /// Numbers in a kernel, which is even along both axes: a quarter of the samples.
  std::size_t kernel_size() const { return groups_.size() * kernel_group_size(); }
  /// Layout of an even array over the lags, lag_rows x lag_columns.
  std::size_t quarter_stride() const { return pupil_.real_stride(); }
  std::size_t quarter_size() const { return std::size_t(rows()) * quarter_stride(); }

  /// Working memory of one thread.
  struct Buffers {
    explicit Buffers(const PupilTransform& transform);
    AlignedArray pupil;    ///< in the layout pupil()
    AlignedArray back;     ///< result of the back transform, in the same layout
    AlignedArray quarter;  ///< quarter_stride()
    AlignedArray kernel;   ///< kernel_size(), if not stored; in precision(), like the arrays below
    AlignedArray half, real_half, work, weights;
  };

  /// F(X) = sum_k E_k exp(-2 pi i k.X/m) from E in `pupil`.
  void to_focus(AlignedArray* focal, Buffers* buffers) const;
  /// Writes sum_X |F(X)|^2 cos(2 pi m_x X/m) cos(2 pi m_y Y/m) into `quarter`. It is m_rows m_columns times
  /// Re(C_(mx,my) + C_(mx,-my))/2, C_m = sum_k E_(k+m) conj(E_k).
  void correlation(const AlignedArray& focal, Buffers* buffers) const;
  /// K(X) = sum_m g(m) exp(+2 pi i m.X/m) from g in `quarter`, even along both axes.
  void kernel(AlignedArray* kernel, Buffers* buffers) const;
  /// V_k = sum_X K(X) F(X) exp(+2 pi i k.X/m) into `back` ...
  void back_to_pupil(const AlignedArray& focal, const AlignedArray& kernel, Buffers* buffers) const;
  /// ... or K(X, Y) = along_x(X) + along_y(Y).
  void back_to_pupil(const AlignedArray& focal, const Eigen::ArrayXd& along_x, const Eigen::ArrayXd& along_y,
                     Buffers* buffers) const;

  /// m_rows m_columns C_(m,0) and C_(0,m), m from 0 to lag_columns and lag_rows.
  void axis_correlations(const AlignedArray& focal, Eigen::ArrayXcd* along_x, Eigen::ArrayXcd* along_y) const;
  /// Re sum_m g(m) exp(+2 pi i m X/m), m = 0 .. g.size()-1, for each X.
  Eigen::ArrayXd kernel_along_x(const Eigen::ArrayXcd& g) const;
  Eigen::ArrayXd kernel_along_y(const Eigen::ArrayXcd& g) const;

 private:
  // Eight rows 2 row[l] + part, and the opposite rows; -1: none.
  struct Group {
    int part;
    std::array<int, kLines> row, mirror;
  };
  std::size_t group_size() const { return std::size_t(2 * n_x_) * 2 * kLines; }
  std::size_t kernel_group_size() const { return std::size_t(n_x_ + 1) * kLines; }
  int kept_y(int part) const { return part == 0 ? n_y_ / 2 + 1 : (n_y_ + 1) / 2; }
  int kept_x(int part) const { return part == 0 ? n_x_ / 2 + 1 : (n_x_ + 1) / 2; }
  template <typename Real>
  struct Plans {
    Plans(int n_x, int n_y);
    LinePlan<Real> x, y;
    std::vector<Real> phases_x, phases_y;  // for both parts
    const LineKernels<Real>& kernels;
  };
  template <typename Real>
  std::array<Real*, kLines> half_rows(int part, const std::array<int, kLines>& row, AlignedArray* half) const;
  template <typename Real>
  std::array<Real*, kLines> real_rows(const Group& group, AlignedArray* real_half) const;
  std::size_t work_size() const;
  int lag_blocks() const { return (lag_columns() + kLines - 1) / kLines; }
  template <typename Real>
  void columns_to_pupil(const Plans<Real>& plans, Buffers* buffers) const;

  FieldLayout pupil_;
  int n_x_, n_y_;
  std::vector<Group> groups_;
  std::variant<Plans<double>, Plans<float>> plans_;
};

/// |F(X)|^2 of m = parts n samples along both axes, F as above, for samples -before .. samples - before - 1
/// about X = 0, row after row. n must be at least rows and columns, and a fast size.
Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> focal_intensity(
    const FieldLayout& layout, const double* pupil, int n, int parts, Eigen::Index before,
    Eigen::Index samples);

/// Smallest even 2^a 3^b 5^c 7^d >= n.
int fast_transform_size(int n);

}  // namespace aberfit::internal
