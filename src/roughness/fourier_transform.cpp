#include "aberfit/roughness/fourier_transform.h"

#include "fftw.h"

namespace aberfit {

void fourier_transform(int rows, int columns, std::complex<double>* values) {
  const FourierTransform transform(rows, columns);  // planning by estimate costs little beside the transform
  transform(values);
}

}  // namespace aberfit
