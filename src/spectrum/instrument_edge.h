#pragma once
#include <optional>

#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit::internal {

/// Where the instrument's transfer ends: bins that go on as they should up to `frequency`, and fall off a
/// cliff beyond it.
struct InstrumentEdge {
  double frequency = 0;  ///< lower edge of the first bin that misses height [cycles/m]
  double exponent_below = 0,
         exponent_beyond = 0;  ///< psd ~ f^-exponent in the decade below, and over the cliff
};

/// The lowest cliff of an estimate: a third of a decade over which the bins fall steeper than any polish, and
/// to less than an eighth of what the decade below promises, beyond chance. The edge is where they first miss
/// a third of it. Empty: none; fewer than six bins below it do not tell.
std::optional<InstrumentEdge> instrument_edge(const PsdEstimate& estimate);

}  // namespace aberfit::internal
