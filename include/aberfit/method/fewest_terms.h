#pragma once
#include <functional>

#include "aberfit/method/attempt.h"

namespace aberfit {

/// Makes the terms of a trial; plan_terms unless a test wants to watch.
using MakeTerms = std::function<TermPlan(const TermsSpec&)>;

/// Whether a fit that does not pass missed by so little (of its tolerances or of the margin) that it may be
/// the rays' or the solver's doing, not the terms': it goes on from there once.
bool deserves_second_look(const Attempt& attempt);

/// `"terms": "auto"`: the fit of the fewest terms that meet every tolerance and are equivalent, with the
/// frontier of all that were tried; where none passes, of the set that comes nearest. The terms and the prior
/// of a set are made once for a trial, its short fit and its whole one together.
Attempt fit_fewest_terms(const FitCase& of, const MakeTerms& make_terms = {});

/// The fit that the task asks for: of the fewest terms, of those it names, or, where the split leaves nothing
/// to terms, of none (all_scatter.h).
Attempt fit_as_asked(const FitCase& of);

}  // namespace aberfit
