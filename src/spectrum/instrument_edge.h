#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// End of the instrument's transfer function: the PSD is regular up to `frequency` and falls steeply beyond.
struct InstrumentEdge {
  double frequency = 0;  ///< lower edge of the first bin with too little height [cycles/m]
  double exponent_below = 0,
         exponent_beyond = 0;  ///< psd ~ f^-exponent in the decade below, and over the cliff
};

/// Returns the lowest cliff of an estimate: within a third of a decade, the bins fall more steeply than any
/// polished surface, and beyond chance below an eighth of the extrapolated decade. The edge is where they are
/// first a third below that line. Empty if there is none, or fewer than six bins below it.
std::optional<InstrumentEdge> instrument_edge(const PsdEstimate& estimate);

}  // namespace aberfit::internal
