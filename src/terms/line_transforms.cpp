#include "line_transforms.h"

#include <fftw3.h>

#include <memory>
#include <mutex>

#include "aberfit/roughness/fourier_transform.h"

namespace aberfit::internal {
namespace {

fftw_complex* as_fftw(std::complex<double>* values) { return reinterpret_cast<fftw_complex*>(values); }

}  // namespace

LineTransforms::LineTransforms(int length) {
  const auto release = [](fftw_complex* memory) { fftw_free(memory); };
  const std::unique_ptr<fftw_complex, decltype(release)> a(fftw_alloc_complex(std::size_t(length) + 1)),
      b(fftw_alloc_complex(std::size_t(length) + 1));
  double *real_a = *a.get(), *real_b = *b.get();
  const std::lock_guard lock(fftw_planner());
  forward_ = fftw_plan_dft_1d(length, a.get(), b.get(), FFTW_FORWARD, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  backward_ = fftw_plan_dft_1d(length, a.get(), b.get(), FFTW_BACKWARD, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  from_real_ = fftw_plan_dft_r2c_1d(length, real_a, b.get(), FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  to_real_ = fftw_plan_dft_c2r_1d(length, a.get(), real_b, FFTW_ESTIMATE);
}

LineTransforms::~LineTransforms() {
  const std::lock_guard lock(fftw_planner());
  for (void* plan : {forward_, backward_, from_real_, to_real_})
    fftw_destroy_plan(static_cast<fftw_plan>(plan));
}

// FFTW's interface takes no const input, but these plans preserve it.
void LineTransforms::forward(const std::complex<double>* from, std::complex<double>* to) const {
  fftw_execute_dft(static_cast<fftw_plan>(forward_), as_fftw(const_cast<std::complex<double>*>(from)),
                   as_fftw(to));
}

void LineTransforms::backward(const std::complex<double>* from, std::complex<double>* to) const {
  fftw_execute_dft(static_cast<fftw_plan>(backward_), as_fftw(const_cast<std::complex<double>*>(from)),
                   as_fftw(to));
}

void LineTransforms::from_real(const double* from, std::complex<double>* to) const {
  fftw_execute_dft_r2c(static_cast<fftw_plan>(from_real_), const_cast<double*>(from), as_fftw(to));
}

void LineTransforms::to_real(std::complex<double>* from, double* to) const {
  fftw_execute_dft_c2r(static_cast<fftw_plan>(to_real_), as_fftw(from), to);
}

}  // namespace aberfit::internal
