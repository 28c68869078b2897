#pragma once
#include <optional>

#include "aberfit/core/warning.h"
#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// Warning for points `pitch` [m] apart, in rows and columns, with fewer than two per cycle of these terms. A
/// wave of the surface then aliases to a longer one. Phase steps between cells may be small all the same (no
/// `psf-aliased`), and all rays may meet the wave at one phase.
std::optional<Warning> undersampled(const TermSet& terms, double pitch);

}  // namespace aberfit::internal
