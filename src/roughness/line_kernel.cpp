#include "aberfit/roughness/line_kernel.h"

#include <cassert>
#include <cmath>
#include <numbers>

#define ABERFIT_KERNEL_BODY "../roughness/line_kernel.inc"
#include "aberfit/core/each_instruction_set.inc"

namespace aberfit {
using namespace internal;

namespace {

// exp(-2 pi i k/n), almost exact to the last bit, because the angle never exceeds an eighth of a turn.
void put_phase(long long k, long long n, double* to) {
  k %= n;
  const long long eighth = (8 * k + n / 2) / n;  // nearest multiple of n/8
  const double angle = 2 * std::numbers::pi * double(8 * k - eighth * n) / (8.0 * double(n));
  const double c = std::cos(angle), s = std::sin(angle), root = std::numbers::sqrt2 / 2;
  const double turn[8][2] = {{1, 0},  {root, root},   {0, 1},  {-root, root},
                             {-1, 0}, {-root, -root}, {0, -1}, {root, -root}};
  const double* t = turn[eighth % 8];
  to[0] = t[0] * c - t[1] * s;
  to[1] = -(t[0] * s + t[1] * c);
}

}  // namespace

template <typename Real>
LinePlan<Real>::LinePlan(int n) : n_(n) {
  int rest = n, twos = 0;
  for (const int prime : {7, 5, 3})
    for (; rest % prime == 0; rest /= prime) radix_.push_back(prime);
  for (; rest % 2 == 0; rest /= 2) ++twos;
  assert(rest == 1);
  // Factors of 8 come last, because the last pass has no twiddle factors. 16 is 4 4, not 2 8.
  if (twos % 3 == 1 && twos > 1) {
    radix_.insert(radix_.end(), {4, 4});
    twos -= 4;
  } else if (twos % 3 > 0) {
    radix_.push_back(twos % 3 == 1 ? 2 : 4);
    twos -= twos % 3;
  }
  for (; twos > 0; twos -= 3) radix_.push_back(8);
  if (radix_.empty()) radix_.push_back(1);
  int length = n;
  for (const int radix : radix_) {
    for (int p = 0; p < length / radix; ++p)
      for (int j = 1; j < radix; ++j) {
        double w[2];
        put_phase(static_cast<long long>(p) * j, length, w);
        twiddle_.insert(twiddle_.end(), {Real(w[0]), Real(w[1])});
      }
    length /= radix;
  }
  // The digits of a block's position, most significant first pass, are those of its sample in reverse order.
  order_ = {0};
  int samples = 1;
  for (std::size_t i = 0; i + 1 < radix_.size(); ++i) {
    std::vector<int> next;
    for (const int place : order_)
      for (int j = 0; j < radix_[i]; ++j) next.push_back(place + samples * j);
    order_ = std::move(next);
    samples *= radix_[i];
  }
}

template <typename Real>
std::vector<Real> line_phases(int n, int part, int parts) {
  std::vector<Real> phases;
  for (int k = 0; k < n; ++k) {
    double w[2];
    put_phase(static_cast<long long>(part) * k, static_cast<long long>(parts) * n, w);
    phases.insert(phases.end(), {Real(w[0]), Real(w[1])});
  }
  return phases;
}

template <>
const LineKernels<double>& line_kernels(InstructionSet set) {
  return ABERFIT_KERNEL(set, in_double::kKernels);
}
template <>
const LineKernels<float>& line_kernels(InstructionSet set) {
  return ABERFIT_KERNEL(set, in_single::kKernels);
}

template class LinePlan<double>;
template class LinePlan<float>;
template std::vector<double> line_phases(int n, int part, int parts);
template std::vector<float> line_phases(int n, int part, int parts);

}  // namespace aberfit
