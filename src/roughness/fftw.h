#pragma once
#include <complex>
#include <memory>

namespace aberfit {

/// Forward complex transform of a rows x cols array (row after row), in place, unnormalised. Planned once (by
/// estimate, so that the same bits come out every time); calls from many threads at once are safe.
class FourierTransform {
 public:
  FourierTransform(int rows, int cols);
  ~FourierTransform();
  FourierTransform(const FourierTransform&) = delete;
  FourierTransform& operator=(const FourierTransform&) = delete;
  void operator()(std::complex<double>* values) const;

 private:
  void* plan_;
};

}  // namespace aberfit
