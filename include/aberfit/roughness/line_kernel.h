#pragma once
#include <vector>

#include "aberfit/core/instruction_set.h"

namespace aberfit {

/// Number of lines that are transformed together, one in each lane. Element i of a bundle of complex lines is
/// eight real and eight imaginary parts; in a bundle of real lines it is eight numbers.
inline constexpr int kLines = 8;

/// The data of a transform of length n that a kernel needs. Real: double or float.
template <typename Real>
struct LineSteps {
  int n = 0;
  int passes = 0;
  const int* radix = nullptr;
  const Real* twiddle = nullptr;
  const int* order = nullptr;  ///< order of the blocks before the last pass
};

/// Discrete Fourier transform of length n = 2^a 3^b 5^c 7^d by decimation in frequency, in place; the last
/// pass sorts. The factors depend only on n and nothing is timed, so every run gives the same bits.
template <typename Real>
class LinePlan {
 public:
  explicit LinePlan(int n);
  LineSteps<Real> steps() const {
    return {n_, int(radix_.size()), radix_.data(), twiddle_.data(), order_.data()};
  }

 private:
  int n_;
  std::vector<int> radix_, order_;
  std::vector<Real> twiddle_;  // for each pass, radix - 1 per butterfly
};

/// exp(-2 pi i part k/(parts n)), k < n. These phases shift the samples of a transform of length n to
/// position `part` of `parts` between them.
template <typename Real>
std::vector<Real> line_phases(int n, int part, int parts);

/// Eight rows of a field; null for a missing row. Block c of the columns of row l is at row[l] + 16 c
/// (complex) or row[l] + 8 c (real).
template <typename Real>
using RowsOut = Real* const*;
template <typename Real>
using RowsIn = const Real* const*;

/// Parts of two-dimensional transforms of arrays that are zero beyond `count` elements, for one instruction
/// set. Complex lines of one or two parts may have up to 2 n elements. The n samples of a part then contain
/// only the sums over k and k + n (two parts: k + 2 n). Real lines have up to n. `work`: 16 (3 n + 24)
/// numbers, and 16 n more for lines longer than n. Outputs over n elements are X = 0 .. n-1. `half` is
/// line_phases(n, 1, 2); `phase` is that of the part. Samples of even fields at 2X and 2X + 1 are two parts,
/// of which X = 0 .. n/2 and 0 .. (n-1)/2 are kept. Cells and lags are in double precision; intermediate data
/// are Real.
template <typename Real>
struct LineKernels {
  /// to[X] = sum_k from[k] phase[k] exp(-2 pi i k X/n), with strides in numbers. `to` may be `from` if both
  /// have one type. beyond: phase[k + n] over phase[k].
  void (*columns_out)(LineSteps<Real> steps, const Real* phase, Real beyond, const double* from, long stride,
                      int count, Real* to, long to_stride, Real* work);
  /// The same along rows, for all parts: focal[part n + X].
  void (*rows_out)(LineSteps<Real> steps, int parts, const Real* phases, RowsIn<Real> rows, int count,
                   Real* focal, Real* work);
  /// Rows of conj(sum over parts and X of weight F exp(+2 pi i k (parts X + part)/(parts n))). `weight` holds
  /// one array per part with `kept` elements each; fewer than n means even.
  void (*rows_back)(LineSteps<Real> steps, int parts, const Real* phases, const Real* focal,
                    const Real* const* weight, const int* kept, RowsOut<Real> rows, int count, Real* work);
  /// Conjugate of the sum over parts along columns, from the result of rows_back.
  void (*columns_back)(LineSteps<Real> steps, int parts, const Real* phases, const Real* from,
                       long part_stride, long stride, double* to, long to_stride, int count, Real* work);
  /// Writes the sum over both parts of |F|^2 cos(pi m (2 X + part)/n) to real rows; adds `mirrored` unless
  /// null.
  void (*power_rows)(LineSteps<Real> steps, const Real* half, const Real* focal, const Real* mirrored,
                     RowsOut<Real> rows, int count, Real* work);
  /// The same sum along columns of real numbers, of which the first `even` and `odd` exist.
  void (*power_columns)(LineSteps<Real> steps, const Real* half, const Real* from_even, int even,
                        const Real* from_odd, int odd, long stride, double* to, long to_stride, int count,
                        Real* work);
  /// g[0] + 2 sum_(m>0) g[m] cos(pi m (2 X + part)/n): the first `even` of part 0 and `odd` of part 1.
  void (*even_columns)(LineSteps<Real> steps, const Real* half, const double* from, long stride, int count,
                       Real* to_even, int even, Real* to_odd, int odd, long to_stride, Real* work);
  /// The same along rows, into bundles of lines.
  void (*even_rows)(LineSteps<Real> steps, const Real* half, RowsIn<Real> rows, int count, Real* to_even,
                    int even, Real* to_odd, int odd, Real* work);
  /// Real rows sum_k from[k] exp(-2 pi i k X/n), X < count, from k = 0 .. n/2 of Hermitian data; 16 at once.
  void (*real_rows)(LineSteps<Real> steps, RowsIn<Real> first_rows, RowsIn<Real> second_rows,
                    RowsOut<Real> to_first, RowsOut<Real> to_second, int count, Real* work);
};
template <typename Real>
const LineKernels<Real>& line_kernels(InstructionSet set);

}  // namespace aberfit
