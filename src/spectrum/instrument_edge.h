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

/// Returns the lowest cliff of an estimate. At a cliff the bins fall, within a third of a decade, more
/// steeply than those of any polished surface. They fall, beyond chance, below an eighth of the line through
/// the decade before. The edge is where they are first a third below that line. Empty if there is no cliff,
/// or if fewer than six bins lie below it.
std::optional<InstrumentEdge> instrument_edge(const PsdEstimate& estimate);

}  // namespace aberfit::internal
