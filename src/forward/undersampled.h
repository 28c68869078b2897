#pragma once
#include <optional>

#include "aberfit/core/warning.h"
#include "aberfit/terms/term_set.h"

namespace aberfit::internal {

/// What is wrong with points `pitch` [m] apart, in rows and columns, for these terms: fewer than two a cycle,
/// where a wave of the surface looks like a longer one. Phases between cells may be small all the same (no
/// `psf-aliased`), and rays may all meet the wave at one phase.
std::optional<Warning> undersampled(const TermSet& terms, double pitch);

}  // namespace aberfit::internal
