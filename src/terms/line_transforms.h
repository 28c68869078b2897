#pragma once
#include <complex>

namespace aberfit::internal {

/// Transforms of lines of `length` values in both directions, unnormalised, from one array to another; both
/// on 64-byte boundaries. Planned once (by estimate); calls from many threads at once are safe.
class LineTransforms {
 public:
  explicit LineTransforms(int length);
  ~LineTransforms();
  LineTransforms(const LineTransforms&) = delete;
  LineTransforms& operator=(const LineTransforms&) = delete;

  /// to[f] = sum_j from[j] e^(-2 pi i f j / length); `from` is left as it was.
  void forward(const std::complex<double>* from, std::complex<double>* to) const;
  /// The same with e^(+2 pi i f j / length).
  void backward(const std::complex<double>* from, std::complex<double>* to) const;
  /// forward of real values, for f = 0 .. length / 2.
  void from_real(const double* from, std::complex<double>* to) const;
  /// backward of a spectrum with from[length - f] = conj(from[f]), of which f = 0 .. length / 2 are given and
  /// destroyed; imaginary parts at f = 0 and at length / 2 (of an even length) count as zero.
  void to_real(std::complex<double>* from, double* to) const;

 private:
  void *forward_, *backward_, *from_real_, *to_real_;
};

}  // namespace aberfit::internal
