#include "solve_focus.h"

#include <nlohmann/json.hpp>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/psd_of_focus_report.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/study/field_errors.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "output_directory.h"
#include "result_files.h"

namespace aberfit {
using namespace internal;

namespace {

// The length in the plane of the focus; an angle on the sky is multiplied by the focal length.
double in_the_plane(const std::optional<std::variant<std::string, double>>& extent, double focal_length) {
  if (!extent) return 0;
  if (const auto* length = std::get_if<double>(&*extent)) return *length;
  return focal_length * parse_quantity(std::get<std::string>(*extent), Dimension::kAngle);
}

}  // namespace

ResultClaim internal::claim_of_focus(const Study& study, const RunOptions& options) {
  return claim_of("solve", options, {"focus.csv"}, wanted_pictures(options, &study), {"focus"});
}

void internal::write_focus(const Study& study, const RunOptions& options, ResultFolder* folder,
                           PsdOfFocus* result) {
  if (!folder->wanted()) return;
  const std::string to = folder->path();
  auto drawn = draw_pictures(*result, to, wanted_pictures(options, &study), &result->warnings);
  write_file(to + "/focus.csv", focus_csv(*result));
  write_result(to, options,
               {page_of(*result), to_json(*result, resolved_study(study), provenance_of(study, options)),
                typed_study(study), std::move(drawn)});
  folder->show();
}

PsdOfFocus run_psd_of_focus(const Study& given, const RunOptions& options) {
  const Study study = completed(given);
  if (!study.solve || !study.solve->focus)
    throw InputError(study.path, "/solve/focus", kMissing,
                     "the command needs an object such as {\"file\": \"ee.csv\"}: a measured focus");
  const std::vector<SolveUnknown> unknowns = solve_unknowns(study);
  ResultFolder folder(options.output_directory, claim_of_focus(study, options));
  const RunContext context = context_of(options);
  MeasuredFocus focus = study.solve->focus->measured;
  focus.pixel = in_the_plane(study.solve->focus->pixel, study.mirror.focal_length);
  focus.reach = in_the_plane(study.solve->focus->reach, study.mirror.focal_length);
  const StudyFamily own(study, study.solve->unknowns);
  const Contributors others = study.solve->with ? contributors(*study.solve->with) : Contributors{};
  Contributors mirrors = others;  // an exposure averages over air and jitter
  mirrors.atmosphere.reset();
  mirrors.jitter = 0;
  PsdOfFocus result = with_fields_of(study, [&] {
    if (others.empty()) return fit_psd_to_focus(own, unknowns, focus, context);
    return fit_psd_to_focus(with_contributors(own, others, {}),
                            mirrors.empty() ? TaskAt(own) : with_contributors(own, mirrors, {}), unknowns,
                            focus, context);
  });
  result.title = study.title;
  result.warnings.insert(result.warnings.begin(), study.data_warnings.begin(), study.data_warnings.end());
  write_focus(study, options, &folder, &result);
  return result;
}

}  // namespace aberfit
