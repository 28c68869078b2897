#include "diffraction_transform.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>
#include <vector>

#include "aberfit/roughness/fourier_transform.h"

namespace aberfit::internal {
namespace {

using Complex = std::complex<double>;

fftw_complex* as_fftw(const Complex* values) {
  return reinterpret_cast<fftw_complex*>(const_cast<Complex*>(values));
}

fftw_plan plan_line(int n, Complex* in, Complex* out, int sign) {
  return fftw_plan_dft_1d(n, as_fftw(in), as_fftw(out), sign, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
}
void transform_line(void* plan, const Complex* in, Complex* out) {
  fftw_execute_dft(static_cast<fftw_plan>(plan), as_fftw(in), as_fftw(out));
}

// Columns that are taken along together: a line of the cache holds as many complex numbers.
constexpr int kLines = 4;

// Rows a power of two apart would all fall on the same few lines of the cache when columns are transformed.
constexpr std::size_t kSkew = 4;

// Columns first .. first + 3 of `rows` rows to lines, and back. Rows have gaps behind them, so that there is
// always room for all four.
void take_columns(const Complex* from, std::size_t stride, int rows, std::size_t line_stride,
                  Complex* lines) {
  for (int row = 0; row < rows; ++row, from += stride)
    for (int line = 0; line < kLines; ++line) lines[std::size_t(line) * line_stride + row] = from[line];
}
void give_columns(const Complex* lines, std::size_t line_stride, int rows, std::size_t stride, Complex* to) {
  for (int row = 0; row < rows; ++row, to += stride)
    for (int line = 0; line < kLines; ++line) to[line] = lines[std::size_t(line) * line_stride + row];
}

std::size_t rounded_up(int n, std::size_t unit) { return (std::size_t(n) + unit - 1) / unit * unit; }

int padded(int n, double padding) {
  return fast_transform_size(std::max(2 * n - 1, int(std::ceil(padding * n - 1e-9))));
}

// row[m - i] = row[i] for 0 < i < m/2.
template <typename T>
void mirror(T* row, int m) {
  for (int i = 1; i < m / 2; ++i) row[m - i] = row[i];
}

Eigen::ArrayXcd first_of_spectrum(void* forward, const Eigen::ArrayXd& values, int wanted) {
  const Eigen::ArrayXcd in = values.cast<Complex>();
  Eigen::ArrayXcd out(in.size());
  transform_line(forward, in.data(), out.data());
  return out.head(wanted).conjugate();
}

Eigen::ArrayXd real_part_of_sum(void* backward, const Eigen::ArrayXcd& g, int m) {
  Eigen::ArrayXcd in = Eigen::ArrayXcd::Zero(m), out(m);
  in.head(g.size()) = g;
  transform_line(backward, in.data(), out.data());
  return out.real();
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
template class FftwArray<Complex>;

PupilTransform::Buffers::Buffers(const PupilTransform& t)
    : pupil(std::size_t(t.rows_) * t.pupil_stride_),
      quarter(t.quarter_size()),
      power_x(t.m_columns_),
      power_y(t.m_rows_),
      half(std::size_t(t.m_rows_) * t.pupil_stride_),
      in(kLines * t.line_stride_),
      out(kLines * t.line_stride_) {
  std::fill_n(quarter.data(), t.quarter_size(), 0.0);  // gaps are transformed, too, and must stay zero
}

PupilTransform::PupilTransform(int rows, int columns, double padding)
    : rows_(rows),
      columns_(columns),
      m_rows_(padded(rows, padding)),
      m_columns_(padded(columns, padding)),
      stride_(std::size_t(m_columns_) + kSkew),
      pupil_stride_(rounded_up(columns, kLines) + kSkew),
      quarter_stride_(rounded_up(quarter_columns(), 2 * kLines)),
      line_stride_(rounded_up(std::max(m_rows_, m_columns_), kLines) + kSkew) {
  Buffers buffers(*this);
  Complex *in = buffers.in.data(), *out = buffers.out.data();
  const std::lock_guard lock(fftw_planner());
  forward_x_ = plan_line(m_columns_, in, out, FFTW_FORWARD);
  forward_y_ = plan_line(m_rows_, in, out, FFTW_FORWARD);
  backward_x_ = plan_line(m_columns_, in, out, FFTW_BACKWARD);
  backward_y_ = plan_line(m_rows_, in, out, FFTW_BACKWARD);
}

PupilTransform::~PupilTransform() {
  const std::lock_guard lock(fftw_planner());
  for (void* plan : {forward_x_, forward_y_, backward_x_, backward_y_})
    fftw_destroy_plan(static_cast<fftw_plan>(plan));
}

void PupilTransform::to_focus(Complex* focal, Buffers* b) const {
  Complex *in = b->in.data(), *out = b->out.data();
  for (int line = 0; line < kLines; ++line)
    std::fill(in + std::size_t(line) * line_stride_ + rows_, in + std::size_t(line) * line_stride_ + m_rows_,
              0.0);
  for (int first = 0; first < columns_; first += kLines) {
    const int lines = std::min(kLines, columns_ - first);
    take_columns(b->pupil.data() + first, pupil_stride_, rows_, line_stride_, in);
    for (int line = 0; line < lines; ++line)
      transform_line(forward_y_, in + std::size_t(line) * line_stride_,
                     out + std::size_t(line) * line_stride_);
    give_columns(out, line_stride_, m_rows_, stride_, focal + first);
  }
  std::fill(in + columns_, in + m_columns_, 0.0);
  for (int row = 0; row < m_rows_; ++row) {
    Complex* field = focal + std::size_t(row) * stride_;
    std::copy_n(field, columns_, in);
    transform_line(forward_x_, in, field);
  }
}

void PupilTransform::correlation(const Complex* focal, Buffers* b) const {
  b->power_x.setZero();
  Eigen::ArrayXd power(m_columns_), opposite(m_columns_);
  const auto add_power = [&](int row, Eigen::ArrayXd* to) {
    const double* field = reinterpret_cast<const double*>(focal + std::size_t(row) * stride_);
    double* p = to->data();
    for (int i = 0; i < m_columns_; ++i)
      p[i] = field[2 * i] * field[2 * i] + field[2 * i + 1] * field[2 * i + 1];
    b->power_y[row] = to->sum();
    b->power_x += *to;
  };
  for (int row = 0; row < quarter_rows(); ++row) {
    add_power(row, &power);
    if (row > 0 && row < m_rows_ / 2) {
      add_power(m_rows_ - row, &opposite);
      power += opposite;
    } else {
      power *= 2;
    }
    double* to = b->quarter.data() + std::size_t(row) * quarter_stride_;
    to[0] = 0.5 * power[0];
    for (int i = 1; i < quarter_columns(); ++i) to[i] = 0.25 * (power[i] + power[m_columns_ - i]);
  }
  even_transform(quarter_rows(), columns_, b);
}

Eigen::ArrayXcd PupilTransform::correlation_along_x(const Buffers& b) const {
  return first_of_spectrum(forward_x_, b.power_x, columns_);
}
Eigen::ArrayXcd PupilTransform::correlation_along_y(const Buffers& b) const {
  return first_of_spectrum(forward_y_, b.power_y, rows_);
}

void PupilTransform::kernel(Buffers* b) const { even_transform(rows_, quarter_columns(), b); }

Eigen::ArrayXd PupilTransform::kernel_along_x(const Eigen::ArrayXcd& g) const {
  return real_part_of_sum(backward_x_, g, m_columns_);
}
Eigen::ArrayXd PupilTransform::kernel_along_y(const Eigen::ArrayXcd& g) const {
  return real_part_of_sum(backward_y_, g, m_rows_);
}

// What is real and even has a real spectrum, so that two lines go through one complex transform: as its real
// and its imaginary part. Rows from rows_in on are zero.
void PupilTransform::even_transform(int rows_in, int columns_out, Buffers* b) const {
  Complex *in = b->in.data(), *out = b->out.data();
  double* quarter = b->quarter.data();
  for (int row = 0; row < rows_in; row += 2) {
    double* one = quarter + std::size_t(row) * quarter_stride_;
    double* two = row + 1 < rows_in ? one + quarter_stride_ : nullptr;
    for (int i = 0; i < quarter_columns(); ++i) in[i] = Complex(one[i], two ? two[i] : 0.0);
    mirror(in, m_columns_);
    transform_line(forward_x_, in, out);
    for (int i = 0; i < quarter_columns(); ++i) one[i] = out[i].real();
    if (!two) continue;
    for (int i = 0; i < quarter_columns(); ++i) two[i] = out[i].imag();
  }
  for (int first = 0; first < columns_out; first += 2 * kLines) {
    const int wanted = std::min(2 * kLines, columns_out - first), lines = (wanted + 1) / 2;
    for (int row = 0; row < quarter_rows(); ++row) {
      const double* from = quarter + std::size_t(row) * quarter_stride_ + first;
      for (int line = 0; line < lines; ++line)
        in[std::size_t(line) * line_stride_ + row] = Complex(from[2 * line], from[2 * line + 1]);
    }
    for (int line = 0; line < lines; ++line) {
      Complex* at = in + std::size_t(line) * line_stride_;
      mirror(at, m_rows_);
      transform_line(forward_y_, at, out + std::size_t(line) * line_stride_);
    }
    for (int row = 0; row < quarter_rows(); ++row) {
      double* to = quarter + std::size_t(row) * quarter_stride_ + first;
      for (int line = 0; line < wanted / 2; ++line) {
        const Complex value = out[std::size_t(line) * line_stride_ + row];
        to[2 * line] = value.real();
        to[2 * line + 1] = value.imag();
      }
      if (wanted % 2) to[wanted - 1] = out[std::size_t(lines - 1) * line_stride_ + row].real();
    }
  }
}

// set_weights(row, w): K of each sample of a row, twice: of its real and of its imaginary part. Called for
// row and m_rows - row one after the other.
template <typename Weights>
void PupilTransform::back(const Complex* focal, const Weights& set_weights, Buffers* b) const {
  Complex *in = b->in.data(), *out = b->out.data();
  std::vector<double> weights(2 * std::size_t(m_columns_));
  const auto go = [&](int row) {
    set_weights(row, weights.data());
    const double* field = reinterpret_cast<const double*>(focal + std::size_t(row) * stride_);
    double* product = reinterpret_cast<double*>(in);
    for (int i = 0; i < 2 * m_columns_; ++i) product[i] = weights[std::size_t(i)] * field[i];
    transform_line(backward_x_, in, out);
    std::copy_n(out, columns_, b->half.data() + std::size_t(row) * pupil_stride_);
  };
  for (int row = 0; row < quarter_rows(); ++row) {
    go(row);
    if (row > 0 && row < m_rows_ / 2) go(m_rows_ - row);
  }
  for (int first = 0; first < columns_; first += kLines) {
    const int lines = std::min(kLines, columns_ - first);
    take_columns(b->half.data() + first, pupil_stride_, m_rows_, line_stride_, in);
    for (int line = 0; line < lines; ++line)
      transform_line(backward_y_, in + std::size_t(line) * line_stride_,
                     out + std::size_t(line) * line_stride_);
    give_columns(out, line_stride_, rows_, pupil_stride_, b->pupil.data() + first);
  }
}

void PupilTransform::back_to_pupil(const Complex* focal, Buffers* b) const {
  const auto weights = [&](int row, double* w) {
    if (row > m_rows_ / 2) return;  // those of m_rows - row are there
    const double* even = b->quarter.data() + std::size_t(row) * quarter_stride_;
    w[0] = w[1] = even[0];
    double* opposite = w + 2 * m_columns_;
    for (int i = 1; i < quarter_columns(); ++i)
      w[2 * i] = w[2 * i + 1] = opposite[-2 * i] = opposite[1 - 2 * i] = even[i];
  };
  back(focal, weights, b);
}

void PupilTransform::back_to_pupil(const Complex* focal, const Eigen::ArrayXd& along_x,
                                   const Eigen::ArrayXd& along_y, Buffers* b) const {
  const auto weights = [&](int row, double* w) {
    for (int i = 0; i < m_columns_; ++i) w[2 * i] = w[2 * i + 1] = along_x[i] + along_y[row];
  };
  back(focal, weights, b);
}

}  // namespace aberfit::internal
