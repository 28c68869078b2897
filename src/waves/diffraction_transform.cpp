#include "diffraction_transform.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "aberfit/core/memory.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/fourier_transform.h"

namespace aberfit::internal {
namespace {

constexpr std::size_t kCacheLine = 64;

// Transform length for half of the samples.
int half_length(int n, double padding) {
  return int(smooth_from(std::max(1, int(std::ceil(0.5 * padding * n - 1e-9)))));
}

template <typename Real>
std::vector<Real> phases_of_parts(int n, int parts) {
  std::vector<Real> all;
  for (int part = 0; part < parts; ++part) {
    const std::vector<Real> phases = line_phases<Real>(n, part, parts);
    all.insert(all.end(), phases.begin(), phases.end());
  }
  return all;
}

std::size_t line_work(int n) { return 2 * kLines * (4 * std::size_t(n) + 3 * kLines); }

Eigen::ArrayXcd first_of_spectrum(const Eigen::ArrayXd& values, Eigen::Index wanted) {
  Eigen::ArrayXcd spectrum = values.cast<std::complex<double>>();
  fourier_transform(1, int(spectrum.size()), spectrum.data());
  return spectrum.head(wanted).conjugate();
}

Eigen::ArrayXd real_part_of_sum(const Eigen::ArrayXcd& g, int m) {
  Eigen::ArrayXcd spectrum = Eigen::ArrayXcd::Zero(m);
  spectrum.head(g.size()) = g.conjugate();
  fourier_transform(1, m, spectrum.data());
  return spectrum.real();
}

}  // namespace

int fast_transform_size(int n) { return 2 * half_length((std::max(2, n) + 1) / 2, 2); }

AlignedArray::AlignedArray(std::size_t size, Precision precision)
    : data_(aligned_memory((size * bytes_of_number(precision) / kCacheLine + 2) * kCacheLine)) {}
AlignedArray::~AlignedArray() { std::free(data_); }

PupilTransform::Buffers::Buffers(const PupilTransform& t)
    : pupil(t.pupil_.size()),
      back(t.pupil_.size()),
      quarter(t.quarter_size()),
      kernel(t.kernel_size(), t.precision()),
      half(2 * std::size_t(t.n_y_) * t.pupil_.stride(), t.precision()),
      real_half(std::size_t(t.n_y_ + 1) * t.pupil_.real_stride(), t.precision()),
      work(t.work_size(), t.precision()),
      weights(std::size_t(2 * t.n_x_) * kLines, t.precision()) {
  std::fill_n(quarter.data(), t.quarter_size(), 0.0);  // gaps are transformed too
  std::fill_n(pupil.data(), t.pupil_.size(), 0.0);
}

template <typename Real>
PupilTransform::Plans<Real>::Plans(int n_x, int n_y)
    : x(n_x),
      y(n_y),
      phases_x(phases_of_parts<Real>(n_x, 2)),
      phases_y(phases_of_parts<Real>(n_y, 2)),
      kernels(line_kernels<Real>(best_instruction_set())) {}

PupilTransform::PupilTransform(int rows, int columns, double padding, Precision precision)
    : pupil_{rows, columns},
      n_x_(half_length(columns, padding)),
      n_y_(half_length(rows, padding)),
      plans_(std::in_place_type<Plans<double>>, n_x_, n_y_) {
  if (precision == Precision::kSingle) plans_.emplace<Plans<float>>(n_x_, n_y_);
  for (const int part : {0, 1})
    for (int first = 0; first < kept_y(part); first += kLines) {
      Group group{part, {}, {}};
      for (int line = 0; line < kLines; ++line) {
        const int row = first + line, opposite = n_y_ - part - row;
        const bool there = row < kept_y(part);
        group.row[std::size_t(line)] = there ? row : -1;
        group.mirror[std::size_t(line)] = there && opposite < n_y_ && opposite != row ? opposite : -1;
      }
      groups_.push_back(group);
    }
}

std::size_t PupilTransform::work_size() const { return line_work(std::max(n_x_, n_y_)); }

template <typename Real>
std::array<Real*, kLines> PupilTransform::half_rows(int part, const std::array<int, kLines>& row,
                                                    AlignedArray* half) const {
  std::array<Real*, kLines> rows;
  for (std::size_t line = 0; line < kLines; ++line)
    rows[line] = row[line] < 0
                     ? nullptr
                     : half->data<Real>() +
                           (std::size_t(part) * std::size_t(n_y_) + std::size_t(row[line])) * pupil_.stride();
  return rows;
}

// Rows of part 0 up to n_y/2, then those of part 1.
template <typename Real>
std::array<Real*, kLines> PupilTransform::real_rows(const Group& group, AlignedArray* real_half) const {
  std::array<Real*, kLines> rows;
  for (std::size_t line = 0; line < kLines; ++line)
    rows[line] = group.row[line] < 0
                     ? nullptr
                     : real_half->data<Real>() +
                           std::size_t(group.part * kept_y(0) + group.row[line]) * pupil_.real_stride();
  return rows;
}

void PupilTransform::to_focus(AlignedArray* to, Buffers* b) const {
  const auto run = [&]<typename Real>(const Plans<Real>& plans) {
    const long stride = long(pupil_.stride());
    for (int block = 0; block < pupil_.blocks(); ++block)
      for (const int part : {0, 1})
        plans.kernels.columns_out(plans.y.steps(), plans.phases_y.data() + 2 * part * n_y_,
                                  part == 0 ? 1 : -1, b->pupil.data() + block * 2 * kLines, stride, rows(),
                                  b->half.data<Real>() + part * n_y_ * stride + block * 2 * kLines, stride,
                                  b->work.data<Real>());
    Real* focal = to->data<Real>();
    for (const Group& group : groups_)
      for (const auto* row : {&group.row, &group.mirror}) {
        const auto lines = half_rows<Real>(group.part, *row, &b->half);
        plans.kernels.rows_out(plans.x.steps(), 2, plans.phases_x.data(), lines.data(), columns(), focal,
                               b->work.data<Real>());
        focal += group_size();
      }
  };
  std::visit(run, plans_);
}

void PupilTransform::correlation(const AlignedArray& of, Buffers* b) const {
  const auto run = [&]<typename Real>(const Plans<Real>& plans) {
    const Real* focal = of.data<Real>();
    for (const Group& group : groups_) {
      const auto lines = real_rows<Real>(group, &b->real_half);
      plans.kernels.power_rows(plans.x.steps(), plans.phases_x.data() + 2 * n_x_, focal, focal + group_size(),
                               lines.data(), lag_columns(), b->work.data<Real>());
      focal += 2 * group_size();
    }
    const long stride = long(pupil_.real_stride());
    for (int block = 0; block < lag_blocks(); ++block) {
      const Real* even = b->real_half.data<Real>() + block * kLines;
      plans.kernels.power_columns(
          plans.y.steps(), plans.phases_y.data() + 2 * n_y_, even, kept_y(0), even + kept_y(0) * stride,
          kept_y(1), stride, b->quarter.data() + block * kLines, stride, lag_rows(), b->work.data<Real>());
    }
  };
  std::visit(run, plans_);
}

void PupilTransform::kernel(AlignedArray* to, Buffers* b) const {
  const auto run = [&]<typename Real>(const Plans<Real>& plans) {
    const long stride = long(pupil_.real_stride());
    for (int block = 0; block < lag_blocks(); ++block) {
      Real* even = b->real_half.data<Real>() + block * kLines;
      plans.kernels.even_columns(plans.y.steps(), plans.phases_y.data() + 2 * n_y_,
                                 b->quarter.data() + block * kLines, stride, lag_rows(), even, kept_y(0),
                                 even + kept_y(0) * stride, kept_y(1), stride, b->work.data<Real>());
    }
    Real* kernel = to->data<Real>();
    for (const Group& group : groups_) {
      const auto lines = real_rows<Real>(group, &b->real_half);
      plans.kernels.even_rows(plans.x.steps(), plans.phases_x.data() + 2 * n_x_, lines.data(), lag_columns(),
                              kernel, kept_x(0), kernel + kept_x(0) * kLines, kept_x(1),
                              b->work.data<Real>());
      kernel += kernel_group_size();
    }
  };
  std::visit(run, plans_);
}

template <typename Real>
void PupilTransform::columns_to_pupil(const Plans<Real>& plans, Buffers* b) const {
  const long stride = long(pupil_.stride());
  for (int block = 0; block < pupil_.blocks(); ++block)
    plans.kernels.columns_back(plans.y.steps(), 2, plans.phases_y.data(),
                               b->half.data<Real>() + block * 2 * kLines, n_y_ * stride, stride,
                               b->back.data() + block * 2 * kLines, stride, rows(), b->work.data<Real>());
}

void PupilTransform::back_to_pupil(const AlignedArray& of, const AlignedArray& times, Buffers* b) const {
  const auto run = [&]<typename Real>(const Plans<Real>& plans) {
    const int kept[2] = {kept_x(0), kept_x(1)};
    const Real *focal = of.data<Real>(), *kernel = times.data<Real>();
    for (const Group& group : groups_) {
      const Real* const weight[2] = {kernel, kernel + kept[0] * kLines};
      for (const auto* row : {&group.row, &group.mirror}) {
        const auto lines = half_rows<Real>(group.part, *row, &b->half);
        plans.kernels.rows_back(plans.x.steps(), 2, plans.phases_x.data(), focal, weight, kept, lines.data(),
                                columns(), b->work.data<Real>());
        focal += group_size();
      }
      kernel += kernel_group_size();
    }
    columns_to_pupil(plans, b);
  };
  std::visit(run, plans_);
}

void PupilTransform::back_to_pupil(const AlignedArray& of, const Eigen::ArrayXd& along_x,
                                   const Eigen::ArrayXd& along_y, Buffers* b) const {
  const auto run = [&]<typename Real>(const Plans<Real>& plans) {
    const int kept[2] = {n_x_, n_x_};
    const Real* focal = of.data<Real>();
    Real* const weight[2] = {b->weights.data<Real>(), b->weights.data<Real>() + n_x_ * kLines};
    for (const Group& group : groups_)
      for (const auto* row : {&group.row, &group.mirror}) {
        for (int part = 0; part < 2; ++part)
          for (int x = 0; x < n_x_; ++x)
            for (std::size_t line = 0; line < kLines; ++line)
              weight[part][std::size_t(x) * kLines + line] = Real(
                  along_x[2 * x + part] + ((*row)[line] < 0 ? 0.0 : along_y[2 * (*row)[line] + group.part]));
        const auto lines = half_rows<Real>(group.part, *row, &b->half);
        plans.kernels.rows_back(plans.x.steps(), 2, plans.phases_x.data(), focal, weight, kept, lines.data(),
                                columns(), b->work.data<Real>());
        focal += group_size();
      }
    columns_to_pupil(plans, b);
  };
  std::visit(run, plans_);
}

void PupilTransform::axis_correlations(const AlignedArray& of, Eigen::ArrayXcd* along_x,
                                       Eigen::ArrayXcd* along_y) const {
  Eigen::ArrayXd over_y = Eigen::ArrayXd::Zero(m_columns()), over_x = Eigen::ArrayXd::Zero(m_rows());
  const auto run = [&]<typename Real>(const Plans<Real>&) {
    const Real* focal = of.data<Real>();
    for (const Group& group : groups_)
      for (const auto* row : {&group.row, &group.mirror}) {
        for (int part = 0; part < 2; ++part)
          for (int x = 0; x < n_x_; ++x, focal += 2 * kLines)
            for (std::size_t line = 0; line < kLines; ++line) {
              if ((*row)[line] < 0) continue;
              const double power = focal[line] * focal[line] + focal[line + kLines] * focal[line + kLines];
              over_y[2 * x + part] += power;
              over_x[2 * (*row)[line] + group.part] += power;
            }
      }
  };
  std::visit(run, plans_);
  *along_x = first_of_spectrum(over_y, lag_columns());
  *along_y = first_of_spectrum(over_x, lag_rows());
}

Eigen::ArrayXd PupilTransform::kernel_along_x(const Eigen::ArrayXcd& g) const {
  return real_part_of_sum(g, m_columns());
}
Eigen::ArrayXd PupilTransform::kernel_along_y(const Eigen::ArrayXcd& g) const {
  return real_part_of_sum(g, m_rows());
}

Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> focal_intensity(
    const FieldLayout& layout, const double* pupil, int n, int parts, Eigen::Index before,
    Eigen::Index samples) {
  const LineKernels<double>& kernels = line_kernels<double>(best_instruction_set());
  const LinePlan<double> plan(n);
  const std::vector<double> phases = phases_of_parts<double>(n, parts);
  const Eigen::Index m = Eigen::Index(n) * parts;
  const long stride = long(layout.stride());
  AlignedArray half(std::size_t(m) * layout.stride()), focal(std::size_t(m) * 2 * kLines), work(line_work(n));
  for (int block = 0; block < layout.blocks(); ++block)
    for (int part = 0; part < parts; ++part)
      kernels.columns_out(plan.steps(), phases.data() + 2 * std::size_t(part) * std::size_t(n), 1,
                          pupil + block * 2 * kLines, stride, layout.rows,
                          half.data() + part * n * stride + block * 2 * kLines, stride, work.data());
  Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> intensity(samples, samples);
  const auto wrapped = [&](Eigen::Index k) { return (k - before + m) % m; };
  std::vector<std::size_t> places(static_cast<std::size_t>(samples));
  for (Eigen::Index k = 0; k < samples; ++k)
    places[std::size_t(k)] = std::size_t(wrapped(k) % parts * n + wrapped(k) / parts) * 2 * kLines;
  for (Eigen::Index first = 0; first < samples; first += kLines) {
    const Eigen::Index lines = std::min<Eigen::Index>(kLines, samples - first);
    std::array<const double*, kLines> rows{};
    for (Eigen::Index line = 0; line < lines; ++line) {
      const Eigen::Index y = wrapped(first + line);
      rows[std::size_t(line)] = half.data() + (y % parts * n + y / parts) * stride;
    }
    kernels.rows_out(plan.steps(), parts, phases.data(), rows.data(), layout.columns, focal.data(),
                     work.data());
    for (Eigen::Index k = 0; k < samples; ++k) {
      const double* value = focal.data() + places[std::size_t(k)];
      for (Eigen::Index line = 0; line < lines; ++line)
        intensity(first + line, k) = value[line] * value[line] + value[line + kLines] * value[line + kLines];
    }
  }
  return intensity;
}

}  // namespace aberfit::internal
