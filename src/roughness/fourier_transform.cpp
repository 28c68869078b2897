#include "aberfit/roughness/fourier_transform.h"

#include <fftw3.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "aberfit/core/instruction_set.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/roughness/line_kernel.h"

namespace aberfit {
namespace {

fftw_complex* as_fftw(std::complex<double>* values) { return reinterpret_cast<fftw_complex*>(values); }

}  // namespace

std::mutex& fftw_planner() {
  static std::mutex mutex;
  return mutex;
}

namespace {
constexpr int kBundle = 2 * kLines, kLeastSide = 64;
}  // namespace

// Transforms eight lines of one length together.
struct FourierTransform::Side {
  explicit Side(int n) : plan(n), phases(line_phases<double>(n, 0, 1)) {}
  void run(double* bundle, double* work) const {
    const LineSteps<double> steps = plan.steps();
    line_kernels<double>(best_instruction_set())
        .columns_out(steps, phases.data(), 1, bundle, kBundle, steps.n, bundle, kBundle, work);
  }
  LinePlan<double> plan;
  std::vector<double> phases;  // empty
};

struct FourierTransform::Lines {
  Lines(int r, int c) : rows(r), columns(c), along_columns(r), along_rows(c) {}

  // Transforms lines that are `line_step` apart, with elements that are `step` apart.
  static void run(const Side& side, int n, int lines, std::ptrdiff_t line_step, std::ptrdiff_t step,
                  std::complex<double>* values, double* bundle, double* work) {
    for (int first = 0; first < lines; first += kLines) {
      const int count = std::min(kLines, lines - first);
      std::complex<double>* at = values + first * line_step;
      if (count < kLines) std::fill_n(bundle, std::ptrdiff_t(n) * kBundle, 0.0);
      for_each_element(n, count, line_step, step, [&](std::ptrdiff_t i, int l, std::ptrdiff_t place) {
        bundle[i * kBundle + l] = at[place].real();
        bundle[i * kBundle + kLines + l] = at[place].imag();
      });
      side.run(bundle, work);
      for_each_element(n, count, line_step, step, [&](std::ptrdiff_t i, int l, std::ptrdiff_t place) {
        at[place] = {bundle[i * kBundle + l], bundle[i * kBundle + kLines + l]};
      });
    }
  }

  // The inner loop runs over neighbours in memory.
  template <typename Visit>
  static void for_each_element(int n, int count, std::ptrdiff_t line_step, std::ptrdiff_t step,
                               const Visit& visit) {
    if (line_step == 1) {
      for (std::ptrdiff_t i = 0; i < n; ++i)
        for (int l = 0; l < count; ++l) visit(i, l, i * step + l);
    } else {
      for (std::ptrdiff_t first = 0; first < n; first += kLines) {
        const std::ptrdiff_t end = std::min<std::ptrdiff_t>(n, first + kLines);
        for (int l = 0; l < count; ++l)
          for (std::ptrdiff_t i = first; i < end; ++i) visit(i, l, i * step + l * line_step);
      }
    }
  }

  int rows, columns;
  Side along_columns, along_rows;
};

FourierTransform::FourierTransform(int rows, int cols) {
  if (std::min(rows, cols) >= kLeastSide && is_smooth(rows) && is_smooth(cols)) {
    lines_ = std::make_unique<const Lines>(rows, cols);
    return;
  }
  std::vector<std::complex<double>> scratch(std::size_t(rows) * std::size_t(cols));
  const std::lock_guard lock(fftw_planner());
  plan_ = fftw_plan_dft_2d(rows, cols, as_fftw(scratch.data()), as_fftw(scratch.data()), FFTW_FORWARD,
                           FFTW_ESTIMATE | FFTW_UNALIGNED);
}

FourierTransform::~FourierTransform() {
  if (!plan_) return;
  const std::lock_guard lock(fftw_planner());
  fftw_destroy_plan(static_cast<fftw_plan>(plan_));
}

void FourierTransform::operator()(std::complex<double>* values) const {
  if (!lines_) {
    fftw_execute_dft(static_cast<fftw_plan>(plan_), as_fftw(values), as_fftw(values));
    return;
  }
  const int rows = lines_->rows, columns = lines_->columns;
  const std::ptrdiff_t longest = std::max(rows, columns);
  Eigen::ArrayXd bundle(longest * kBundle), work(kBundle * (3 * longest + 3 * kLines));
  Lines::run(lines_->along_columns, rows, columns, 1, columns, values, bundle.data(), work.data());
  Lines::run(lines_->along_rows, columns, rows, columns, 1, values, bundle.data(), work.data());
}

void fourier_transform(int rows, int columns, std::complex<double>* values) {
  // An estimated plan costs little compared with the transform.
  const FourierTransform transform(rows, columns);
  transform(values);
}

}  // namespace aberfit
