#pragma once
#include <Eigen/Core>

#include "periodogram.h"
#include "processing.h"

namespace aberfit::internal {

/// Expectation of the binned periodogram as a linear function of the spectrum.
struct EstimatorResponse {
  Eigen::ArrayXd node_frequency;  ///< log-spaced [cycles/m]; the spectrum is linear in between
  Eigen::MatrixXd matrix;         ///< bins x nodes
  Eigen::ArrayXd transfer;        ///< per node: fraction of the power of a wave in its own main lobe
  LowOrdinates low;
};

/// Propagates plane waves through the processing, which is linear, so that |transform|^2 of a wave is exact.
/// For low frequencies, where detrending acts, all waves on a grid of half a resolution or finer are used.
/// For high frequencies, selected waves give the fraction in the main lobe and the distribution of the rest,
/// both smooth in frequency; the main lobe is that of the window. A spectrum beyond the Nyquist frequencies
/// of the axes (aliasing) or below 1/16 ordinate (removed by detrending) is not modelled.
EstimatorResponse estimator_response(const SurfaceProcessing& processing, const OrdinateBins& bins,
                                     WindowKind window, int threads);

}  // namespace aberfit::internal
