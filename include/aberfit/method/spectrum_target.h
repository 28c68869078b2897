#pragma once
#include <memory>

#include "aberfit/method/groundwork.h"
#include "aberfit/terms/surface_spectrum.h"

namespace aberfit {

/// PSD bins of the term surface as targets of a fit. `spectrum` is null when the task has none.
struct SpectrumTarget {
  std::unique_ptr<SurfaceSpectrum> spectrum;
  Eigen::ArrayXd low, high;  ///< edges of the bins [cycles/m]
  Eigen::VectorXd
      value;  ///< expectation of each bin over realisations of the prior, by the same estimator [m^4]
  Eigen::VectorXd tolerance;  ///< of log PSD
};
SpectrumTarget make_spectrum_target(const Task& task, const Groundwork& ground, const TermSet& terms,
                                    const CoefficientPrior& prior, int threads);

}  // namespace aberfit
