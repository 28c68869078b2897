#pragma once
#include <complex>

namespace aberfit::internal {

/// Fourier transforms of lines of `length` values in both directions, unnormalised, between two arrays on
/// 64-byte boundaries. They are planned once (by estimate); many threads may call them at once.
class LineTransforms {
 public:
  explicit LineTransforms(int length);
  ~LineTransforms();
  LineTransforms(const LineTransforms&) = delete;
  LineTransforms& operator=(const LineTransforms&) = delete;

  /// to[f] = sum_j from[j] e^(-2 pi i f j / length); `from` does not change.
  void forward(const std::complex<double>* from, std::complex<double>* to) const;
  /// The same with e^(+2 pi i f j / length).
  void backward(const std::complex<double>* from, std::complex<double>* to) const;
  /// forward of real values, for f = 0 .. length / 2.
  void from_real(const double* from, std::complex<double>* to) const;
  /// backward for a spectrum with from[length - f] = conj(from[f]). It needs f = 0 .. length / 2 and destroys
  /// them. Imaginary parts at f = 0 and at length / 2 (for even length) count as zero.
  void to_real(std::complex<double>* from, double* to) const;

 private:
  void *forward_, *backward_, *from_real_, *to_real_;
};

}  // namespace aberfit::internal
