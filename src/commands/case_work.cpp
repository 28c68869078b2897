#include "case_work.h"

#include <algorithm>
#include <memory>
#include <mutex>

#include "aberfit/commands/run.h"
#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/method/theory_values.h"

namespace aberfit::internal {
namespace {

RunOptions one_thread(const std::function<bool()>& interrupted) {
  RunOptions options;
  options.threads = 1;
  options.pictures = PictureFormat::kNone;
  options.interrupted = interrupted;
  return options;
}

std::vector<std::string> codes_of(const Warnings& warnings) {
  std::vector<std::string> codes;
  for (const Warning& warning : warnings)
    if (std::find(codes.begin(), codes.end(), warning.code) == codes.end()) codes.push_back(warning.code);
  return codes;
}

// If two statistics have one name, the later gets "#2", as in results.
void add_value(const std::string& name, double value, CaseOutcome* outcome) {
  const auto is_taken = [&](const std::string& taken) {
    return std::any_of(outcome->values.begin(), outcome->values.end(),
                       [&](const auto& known) { return known.first == taken; });
  };
  std::string unique = name;
  for (int k = 2; is_taken(unique); ++k) unique = name + "#" + std::to_string(k);
  outcome->values.emplace_back(unique, value);
}

void add_scene(const SceneNumbers& numbers, CaseOutcome* outcome) {
  add_value("scene_rms_height_m", numbers.rms_height, outcome);
  add_value("scene_rms_slope_per_axis", numbers.rms_slope_per_axis, outcome);
  add_value("scene_g", numbers.g, outcome);
  add_value("scene_kappa", numbers.kappa, outcome);
  add_value("scene_tis", numbers.tis, outcome);
  add_value("scene_n_eff", numbers.n_eff, outcome);
  add_value("scene_paper_ratio_r", numbers.paper_ratio_r, outcome);
}

// Keeps the pupil of the last case for cases with the same pupil. If every case has its own, threads make
// them in parallel.
class PupilOfCases {
 public:
  GhsPupil operator()(const Task& task) {
    if (const std::shared_ptr<const GhsPupil> known = last(); known && is_of(*known, task)) return *known;
    auto made = std::make_shared<const GhsPupil>(pupil_of_task(task));
    const std::lock_guard lock(mutex_);
    last_ = made;
    return *made;
  }

 private:
  static bool is_of(const GhsPupil& pupil, const Task& task) {
    return pupil.mirror() == task.mirror && pupil.aperture() == task.aperture &&
           pupil.light() == task.wavelength;
  }
  std::shared_ptr<const GhsPupil> last() {
    const std::lock_guard lock(mutex_);
    return last_;
  }

  std::mutex mutex_;
  std::shared_ptr<const GhsPupil> last_;
};

CaseOutcome check_case(const Study& study, PupilOfCases* pupils) {
  if (study.map) throw InputError(study.path, "/target/map", "a map", "statistics, for run \"check\"");
  const TheoryValues values = theory_values(study, std::ref(*pupils));
  CaseOutcome outcome;
  for (const auto& [statistic, value] : values.statistics)
    add_value(statistic_name(statistic), value, &outcome);
  add_scene(values.numbers, &outcome);
  outcome.warnings = codes_of(values.warnings);
  return outcome;
}

CaseOutcome trace_case(const Study& study, const std::function<bool()>& interrupted) {
  const TraceReport report = run_trace(study, one_thread(interrupted));
  CaseOutcome outcome;
  for (const TracedStatistic& one : report.statistics) {
    add_value(statistic_name(one.statistic), one.value, &outcome);
    add_value("target_" + statistic_name(one.statistic), one.target, &outcome);
  }
  add_value("terms", double(report.terms), &outcome);
  outcome.warnings = codes_of(report.warnings);
  return outcome;
}

// The statistics of the fitted surface, on fresh rays if the verdict used them, and their targets.
CaseOutcome fit_case(const Study& study, const std::function<bool()>& interrupted) {
  const RunOptions options = one_thread(interrupted);
  const ResultDocument result = study.map ? run_map_fit(study, options) : run_fit(study, options);
  if (result.interrupted) throw Interrupted("stopped during a fit");
  if (result.fitted.fit.status == FitStatus::kFailed) throw ComputationError("the fit failed");
  CaseOutcome outcome;
  const Eigen::VectorXd& achieved =
      result.fitted.validated.size() > 0 ? result.fitted.validated : result.fitted.values;
  for (std::size_t k = 0; k < result.fitted.targets.size(); ++k) {
    const std::string name = statistic_name(result.fitted.targets[k].statistic);
    const bool there = Eigen::Index(k) < achieved.size();
    add_value(name, there ? achieved[Eigen::Index(k)] : kNaN, &outcome);
    add_value("target_" + name, result.fitted.targets[k].value, &outcome);
  }
  add_value("terms", double(result.fitted.terms.size()), &outcome);
  if (result.has_roughness) add_scene(result.scene.numbers, &outcome);
  add_value("scene_fitted_rms_height_m", result.fitted.surface.rms_height, &outcome);
  outcome.verdict = to_string(result.judgement.verdict);
  outcome.warnings = codes_of(result.warnings);
  return outcome;
}

std::string unit_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::kLength:
      return "_m";
    case Dimension::kSpatialFrequency:
      return "_per_m";
    case Dimension::kPsd2d:
      return "_m4";
    default:
      return "";
  }
}

// The solution nearest to the study's own value, with the value of every budget there.
CaseOutcome solve_case(const Study& study, const std::function<bool()>& interrupted) {
  const Specification spec = run_solve(study, one_thread(interrupted));
  CaseOutcome outcome;
  const bool solved = !spec.solutions.empty();
  const SolveUnknown& unknown = spec.unknowns.front();
  add_value("solved_" + unknown.pointer.substr(unknown.pointer.rfind('/') + 1) + unit_of(unknown.dimension),
            solved ? spec.solutions.front().at[0] : kNaN, &outcome);
  for (std::size_t k = 0; k < spec.budgets.size(); ++k)
    add_value(budget_name(spec.budgets[k]), solved ? spec.solutions.front().budgets[k].value : kNaN,
              &outcome);
  outcome.verdict = to_string(spec.status);
  outcome.warnings = codes_of(spec.warnings);
  return outcome;
}

}  // namespace

CaseWork case_work(CaseLevel level, const std::function<bool()>& interrupted) {
  switch (level) {
    case CaseLevel::kCheck:
      return [pupils = std::make_shared<PupilOfCases>()](const Study& study) {
        return check_case(study, pupils.get());
      };
    case CaseLevel::kTrace:
      return [interrupted](const Study& study) { return trace_case(study, interrupted); };
    case CaseLevel::kFit:
      return [interrupted](const Study& study) { return fit_case(study, interrupted); };
    case CaseLevel::kSolve:
      return [interrupted](const Study& study) { return solve_case(study, interrupted); };
  }
  return {};
}

}  // namespace aberfit::internal
