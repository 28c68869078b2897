#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// The terms that carry the roughness of a task: Zernikes from tilt to growth times order_to_carry of the
/// band that the terms stand for, or, where that order is above law::kLargestOrder, plane waves: the whole
/// frequency grid of the aperture's box, or of a band with more than law::kMostWaves of them log-uniform
/// rings. The ground has a roughness, and terms.
TermsSpec terms_by_law(const Task& task, const Groundwork& ground, double growth = 1);

/// The fit that the task asks for. Where it names terms, of those, from as many starts as it says until one
/// is equivalent. Where it leaves them open, of the law's, and where those turn out too few - different, or
/// short of a tolerance - of 1.15 times the order, twice at most; the nearest is kept. Where it asks for the
/// fewest, of the lowest order to within a tenth, by halving the logarithm between the law's order and 2; if
/// the law's set is not equivalent, that. Where the split leaves nothing to terms, of none (all_scatter.h).
Attempt fit_as_asked(const FitCase& of);

}  // namespace aberfit
