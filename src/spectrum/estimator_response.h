#pragma once
#include <Eigen/Core>

#include "periodogram.h"
#include "processing.h"

namespace aberfit::internal {

/// Expectation of the binned periodogram as a linear function of the spectrum.
struct EstimatorResponse {
  Eigen::ArrayXd node_frequency;  ///< log-spaced [cycles/m]; the spectrum is linear in between
  Eigen::MatrixXd matrix;         ///< bins x nodes
  Eigen::ArrayXd transfer;        ///< per node: power of a wave that arrives in its own main lobe
  LowOrdinates low;
};

/// Plane waves are sent through the processing (it is linear, so |transform|^2 of a wave is exact): all of
/// them on a lattice of half a resolution and finer for low frequencies, where detrending acts; for high
/// frequencies a selection, which yields the share that stays in the main lobe and where the rest goes, both
/// smooth functions of frequency, while the main lobe itself is that of the window. Waves up to the Nyquist
/// frequencies of the axes; a spectrum beyond them (aliasing) and below 1/16 ordinate (removed by detrending)
/// is not modelled.
EstimatorResponse estimator_response(const SurfaceProcessing& processing, const OrdinateBins& bins,
                                     WindowKind window, int threads);

}  // namespace aberfit::internal
