#include "fit_files.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/exports.h"
#include "aberfit/report/pictures.h"
#include "aberfit/report/scatter_table.h"
#include "aberfit/study/read_study.h"
#include "answers.h"
#include "array_files.h"
#include "output_directory.h"
#include "result_files.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr int kMapSize =
    257;  // points per side of the surface map; odd, so that the cuts pass through the vertex

SurfaceOperator map_operator(const TermSet& terms, double radius, int threads) {
  Eigen::ArrayXd x(kMapSize * kMapSize), y(kMapSize * kMapSize);
  for (int j = 0; j < kMapSize; ++j) {
    for (int i = 0; i < kMapSize; ++i) {
      x[j * kMapSize + i] = radius * (2.0 * i / (kMapSize - 1) - 1);
      y[j * kMapSize + i] = radius * (2.0 * j / (kMapSize - 1) - 1);
    }
  }
  return SurfaceOperator(terms, std::move(x), std::move(y), threads);
}

std::vector<DrawnPicture> draw(const Study& study, const Groundwork& ground, const RunOptions& options,
                               const LightPath& focus, ResultDocument* result) {
  const int threads = result->provenance.threads;
  const Eigen::VectorXd& coefficients = result->fitted.fit.coefficients;
  SurfaceField field;
  focus.surface.apply(coefficients, &field);
  LightPath smooth = focus;
  smooth.scatter = nullptr;
  const auto ideal = surface_light(smooth, Eigen::VectorXd::Zero(coefficients.size()), threads);
  const auto target = target_light(study, ground, focus.pupil, threads);
  const auto fitted = surface_light(focus, coefficients, threads);
  const SurfaceOperator map = map_operator(result->fitted.terms, ground.radius, threads);
  return draw_pictures(
      {*result, study.mirror, study.aperture, study.wavelength, ground.psd ? &*ground.psd : nullptr,
       focus.pupil, *ideal, target.get(), *fitted, field, map, kMapSize, ground.core_sigma},
      options.output_directory, wanted_pictures(options, &study), &result->warnings);
}

// Gives the focus of the fitted terms and of theory to `look`. Throws ComputationError for terms that rays
// cannot describe.
void look_at(const FinishedFit& fit, const Workbench& bench,
             const std::function<void(const ArrayInput&)>& look) {
  const ResultDocument& result = fit.result;
  if (result.map.fit && !result.has_roughness && result.scene.model == "waves" &&
      bench.model == FocusModel::kRays)
    throw ComputationError(
        "rays do not describe the PSF of these terms, so no arrays are written. The picture map_light shows "
        "it by waves; with a `roughness` block there are arrays");
  const int threads = result.provenance.threads;
  const auto theory = target_light(*fit.study, fit.ground, bench.pupil, threads);
  const auto surface = surface_light(bench.focus(*fit.study), result.fitted.fit.coefficients, threads);
  look(array_input(*fit.study, fit.ground, theory.get(), surface.get(),
                   planes_of(statistics_of(result.fitted.targets))));
}

void write_fit_arrays(FinishedFit* fit, const Workbench& bench, ArrayFormat format,
                      const std::string& folder) {
  try {
    look_at(*fit, bench,
            [&](const ArrayInput& input) { write_arrays(input, format, folder, &fit->result.warnings); });
  } catch (const ComputationError& error) {
    fit->result.warnings.push_back({"arrays-left-out", error.what()});
  }
}

// A finished fit must not be lost because a format cannot hold it.
void write_exports(const Study& study, const std::string& folder, ResultDocument* result) {
  const ExportInput input{result->fitted.terms, result->fitted.fit.coefficients, study.aperture,
                          study.wavelength,     study.output.export_grid,        study.title};
  if (result->map.fit && result->fitted.fit.status != FitStatus::kConverged &&
      !study.output.exports.empty()) {
    result->warnings.push_back(
        {"export-left-out", "the points of the map do not determine the terms, so nothing is exported"});
    return;
  }
  for (const ExportFormat format : study.output.exports) {
    try {
      const auto [name, content] = export_file(format, input);
      write_file(folder + name, content);
    } catch (const std::invalid_argument& error) {
      const std::string name = export_names()[std::size_t(format)] + ": ", what = error.what();
      result->warnings.push_back({"export-left-out", what.starts_with(name) ? what : name + what});
    }
  }
}

}  // namespace

nlohmann::ordered_json resolved(const Study& study, const FitOutcome& outcome) {
  return outcome.map.fit ? resolved_study(study) : resolved_study(study, outcome.choices.values);
}

namespace internal {

ResultClaim claim_of_fit(const Study& study, const RunOptions& options) {
  std::vector<std::string> files = array_claims(wanted_arrays(study, options));
  for (const char* file : {"coefficients.csv", "scatter.csv", "scatter_psd.csv"}) files.emplace_back(file);
  for (const ExportFormat format : study.output.exports)
    files.push_back("exports/" + export_file_name(format));
  std::vector<std::string> pictures = fit_picture_names();
  pictures.emplace_back("ee_targets");
  return claim_of("fit", options, std::move(files), wanted_pictures(options, &study), pictures);
}

void write_fit(const RunOptions& given, ResultFolder* place, FinishedFit* fit) {
  if (!place->wanted() || fit->failed()) return;
  const Study& study = *fit->study;
  ResultDocument* const result = &fit->result;
  RunOptions options = given;
  options.output_directory = place->path();
  const auto bench = fit->bench();
  // A user who interrupts does not want to wait for pictures.
  std::vector<DrawnPicture> drawn;
  if (wanted_pictures(options, &study).format != PictureFormat::kNone && !result->interrupted)
    drawn = draw(study, fit->ground, options, bench->focus(study), result);
  if (const ArrayFormat format = wanted_arrays(study, options); format != ArrayFormat::kNone)
    write_fit_arrays(fit, *bench, format, options.output_directory);
  const std::string folder = options.output_directory + "/";
  write_file(folder + "coefficients.csv",
             coefficients_csv(result->fitted.terms, result->fitted.fit.coefficients,
                              result->fitted.fit.coefficient_std));
  if (result->band.scatter) {
    const ScatterOfRest& scatter = *result->band.scatter;
    write_file(folder + "scatter.csv", scatter_csv({study.title, scatter.table, scatter.abg, scatter.rest,
                                                    result->fitted.terms.size() > 0}));
    if (scatter.rest)
      write_file(folder + "scatter_psd.csv", scatter_psd_csv(*scatter.rest, study.wavelength));
  }
  write_exports(study, folder + "exports/", result);
  const Page whole = page_of(*result, true);
  write_result(options.output_directory, options,
               {page_of(*result, false), to_json(*result, resolved(study, *result)), typed_study(study),
                std::move(drawn), &whole});
  place->show();
}

Answer answer_of(FinishedFit finished) {
  const auto fit = std::make_shared<const FinishedFit>(std::move(finished));
  const ResultDocument& result = fit->result;
  Answer answer{code_of_fit(result), page_of(result, false)};
  answer.document = [fit] { return to_json(fit->result, resolved(*fit->study, fit->result)); };
  if (fit->failed()) return answer;
  answer.focus = [fit](const auto& see) { look_at(*fit, *fit->bench(), see); };
  answer.save = [fit](const RunOptions& options) {
    ResultFolder folder(options.output_directory, claim_of_fit(*fit->study, options));
    FinishedFit written = *fit;
    write_fit(options, &folder, &written);
  };
  return answer;
}

}  // namespace internal
}  // namespace aberfit
