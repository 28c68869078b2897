#pragma once
#include "aberfit/commands/run.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/report/result.h"
#include "aberfit/report/result_folder.h"
#include "answers.h"

namespace aberfit::internal {

/// The files that `write_fit` may write.
ResultClaim claim_of_fit(const Study& study, const RunOptions& options);

/// A fit with what its focus is computed from.
struct FinishedFit {
  SharedStudy study;
  ResultDocument result;
  Groundwork ground;
  /// Makes the pupil of the focus and its operators, or returns those of the fit.
  std::function<std::shared_ptr<const Workbench>()> bench;

  bool failed() const { return result.fitted.fit.status == FitStatus::kFailed; }
};

/// Writes the results of a fit that has not failed, and puts them in place: result.json, coefficients.csv,
/// summary.txt and, when wanted, arrays and pictures. A missing gnuplot becomes a warning of the result.
void write_fit(const RunOptions& options, ResultFolder* folder, FinishedFit* fit);

/// The fit as the answer of its command.
Answer answer_of(FinishedFit fit);

}  // namespace aberfit::internal
