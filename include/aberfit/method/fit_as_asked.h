#pragma once
#include "aberfit/method/attempt.h"

namespace aberfit {

/// The terms that carry the roughness of a task: Zernikes from tilt to `growth` times order_to_carry of the
/// terms' band. Where that order is above law::kLargestOrder, plane waves replace them. They form the whole
/// frequency grid of the aperture's box. A band with more than law::kMostWaves grid frequencies has
/// log-uniform rings instead. The ground has a roughness, and a part of it needs terms.
TermsSpec terms_by_law(const Task& task, const Groundwork& ground, double growth = 1);

/// Makes the fit that the task describes. Named terms: one set, from the task's number of starts, until one
/// is equivalent. Automatic terms: the set of terms_by_law. If it is different or misses a tolerance, the
/// order grows by law::kGrowth, at most law::kMostGrowths times; the nearest fit is kept. Fewest terms: the
/// lowest order to within law::kFewestWithin, by bisection in the logarithm between 2 and the order of the
/// law. If the set of the law is not equivalent, that set. Nothing left to terms by the split: see
/// all_scatter.h.
Attempt fit_as_asked(const FitCase& of);

}  // namespace aberfit
