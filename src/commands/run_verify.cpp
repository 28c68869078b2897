#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/units.h"
#include "aberfit/method/tost.h"
#include "aberfit/focus/counted_ring_width.h"
#include "aberfit/method/judge.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/report/result.h"
#include "aberfit/study/published.h"
#include "aberfit/study/read_study.h"
#include "aberfit/theory/ray_perturbation.h"
#include "aberfit/trace/central_difference.h"
#include "verify_branches.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

constexpr double kIdealRing = 10e-6;  // the ring the paper lays around the ideal focus

// The surface of the aberration branch: from a file, or the study's seeded draw.
Eigen::VectorXd surface_coefficients(const Study& study, const Scene& scene, const RunOptions& options,
                                     TermSet* terms) {
  if (!options.coefficients_file.empty()) {
    *terms = TermSet{};
    terms->radius = scene.radius;
    return read_coefficients_csv(options.coefficients_file, terms);
  }
  double captured = 0;
  *terms = make_terms(study, scene, &captured);
  return make_study_prior(study, scene, *terms).colour(draw_white(terms->size(), study.fit.seed));
}

SurfaceField surface_field(const Study& study, const PupilSample& pupil, const TermSet& terms,
                           const Eigen::VectorXd& coefficients, int threads) {
  if (study.trace.central_difference_step)
    return central_difference_field(study.mirror, pupil, terms, coefficients,
                                    *study.trace.central_difference_step, threads);
  SurfaceField field;
  SurfaceOperator(terms, pupil, {threads, {}, {}}).apply(coefficients, &field);
  return field;
}

// EE at focus, ring widths, angles and spot: what both branches can be asked for.
std::vector<Statistic> branch_statistics(const Scene& scene) {
  std::vector<Statistic> statistics;
  for (const double fraction : {0.2, 0.5, 0.8, 0.9, 0.95})
    statistics.push_back(EncircledEnergyRadius{fraction, 0});
  for (const double units : {-2.0, 2.0})
    statistics.push_back(EncircledEnergyRadius{0.9, 1e-6 * std::round(1e6 * units * scene.plane_unit())});
  statistics.push_back(RingFwhm{});
  statistics.push_back(RingFwhm{0.5, {}});
  statistics.push_back(ScatterRms{});
  statistics.push_back(ScatterMean{});
  statistics.push_back(SpotFwhm{0.1 * scene.focal_sigma});
  statistics.push_back(RmsRadius{});
  return statistics;
}

void add_scene_quantities(const SceneNumbers& scene, Quantities* quantities) {
  Quantities& q = *quantities;
  q["scene.rms_height_m"] = scene.rms_height;
  q["scene.rms_slope_per_axis"] = scene.rms_slope_per_axis;
  q["scene.rms_slope_total"] = scene.rms_slope_per_axis * std::sqrt(2.0);
  q["scene.correlation_length_m"] = scene.correlation_length;
  q["scene.n_eff"] = scene.n_eff;
  q["scene.g"] = scene.g;
  q["scene.kappa"] = scene.kappa;
  q["scene.tis"] = scene.tis;
  q["scene.paper_ratio_r"] = scene.paper_ratio_r;
}

void add_ideal_quantities(const RayBundle& nominal, Quantities* quantities) {
  const Eigen::ArrayXd no_height = Eigen::ArrayXd::Zero(nominal.size());
  (*quantities)["ideal.ring_fwhm_m"] =
      evaluate_exact({nominal, nominal, no_height, Centre::kNominal}, {RingFwhm{0.9, kIdealRing}}, 1)[0];
  (*quantities)["ideal.ring_fwhm_counted_m"] = counted_ring_width(nominal, kIdealRing, 1e-4, 2e-2);
  (*quantities)["ideal.ee90_radius_m"] =
      evaluate_exact({nominal, nominal, no_height, Centre::kNominal}, {EncircledEnergyRadius{}}, 1)[0];
}

double quantity(const Study& study, const PublishedNumber& row, std::size_t at,
                const Quantities& quantities) {
  if (!row.formula.empty()) return evaluate_formula(row.formula, row.inputs, study);
  if (row.quantity.empty()) return std::nan("");
  const auto found = quantities.find(row.quantity);
  if (found == quantities.end()) {
    std::string known;
    for (const auto& [name, value] : quantities) known += (known.empty() ? "" : ", ") + name;
    throw InputError(study.path, fmt::format("/verify/published/{}/quantity", at), "\"" + row.quantity + "\"",
                     known);
  }
  return found->second;
}

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

// Text wrapped at `width` columns, continuation lines indented by `indent`.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::string out, line;
  std::size_t begin = 0;
  while (begin < text.size()) {
    std::size_t end = text.find(' ', begin);
    if (end == std::string::npos) end = text.size();
    const std::string word = text.substr(begin, end - begin);
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      out += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return out + line;
}

// Rays by analytic normals, whatever the study's: the scatter between draws is no matter of normals.
Realisation verify_realisation(const Study& study, const Scene& scene, const PupilSample& pupil,
                               const TermSet& terms, int threads) {
  const SurfaceOperator surface(terms, pupil, {threads, {}, {}});
  return realisation_of(study, scene,
                        {study.mirror, pupil, surface, FocusModel::kRays, study.wavelength, &study.aperture,
                         study.trace.centre},
                        make_study_prior(study, scene, terms), threads);
}

// Both branches are rays. Where these are the wrong model, agreement of the two decides nothing.
Verdict verify_verdict(const Scene& scene, const std::vector<EquivalenceMetric>& metrics) {
  const Verdict verdict = overall(metrics);
  const bool rays_decide = scene.use.choice->model == FocusModel::kRays;
  return rays_decide || verdict != Verdict::kEquivalent ? verdict : Verdict::kUndecided;
}

}  // namespace

ordered_json run_verify(const Study& study, const RunOptions& options, std::string* table) {
  if (!study.roughness)
    throw InputError(study.path, "/roughness", "nothing",
                     "a roughness block: verify compares with its Harvey-Shack prediction");
  const int threads = options.threads > 0 ? options.threads : available_threads();
  const Scene scene = make_scene(study);
  const PupilSample pupil = make_pupil(study.aperture, study.trace.pupil);
  const RayBundle nominal = trace_nominal(study.mirror, pupil);
  const std::vector<Statistic> statistics = branch_statistics(scene);

  // Theory in closed form; Harvey-Shack by perturbed rays; aberration terms by a traced surface.
  Eigen::VectorXd theory(Eigen::Index(statistics.size()));
  for (std::size_t k = 0; k < statistics.size(); ++k)
    theory[Eigen::Index(k)] = (*scene.theory)(statistics[k]);
  Branch harvey_shack, terms_branch;
  const Eigen::ArrayXd no_height = Eigen::ArrayXd::Zero(pupil.size());
  harvey_shack.rays = trace_perturbed(study.mirror, pupil, scene.numbers.rms_slope_per_axis,
                                      study.target.convention, study.trace.pupil.seed);
  harvey_shack.statistics =
      evaluate_exact({harvey_shack.rays, nominal, no_height, study.trace.centre}, statistics, threads);
  TermSet terms;
  const Eigen::VectorXd coefficients = surface_coefficients(study, scene, options, &terms);
  terms_branch.field = surface_field(study, pupil, terms, coefficients, threads);
  terms_branch.rays = trace(study.mirror, pupil, terms_branch.field);
  terms_branch.statistics = evaluate_exact(
      {terms_branch.rays, nominal, terms_branch.field.height, study.trace.centre}, statistics, threads);

  // A draw is one realisation: its scatter enters the test. A surface from a file is judged on its own
  // statistics.
  // The scatter is the larger of what the law says and, near the margin, what draws show.
  const bool is_draw = options.coefficients_file.empty();
  const Realisation realisation = is_draw ? verify_realisation(study, scene, pupil, terms, threads)
                                          : Realisation{scene.numbers.realisation_spread, std::nan(""), 0};
  const double spread = is_draw ? realisation.spread() : 0.0;
  const double sampling =
      0.51e-2 * std::sqrt(15000.0 / double(pupil.size()));  // PHYSICS 2, ee90 of random rays
  std::vector<EquivalenceMetric> metrics;
  Quantities quantities;
  add_scene_quantities(scene.numbers, &quantities);
  add_ideal_quantities(nominal, &quantities);
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const auto at = Eigen::Index(k);
    const std::string name = statistic_name(statistics[k]);
    quantities["theory." + name] = theory[at];
    quantities["harvey_shack." + name] = harvey_shack.statistics[at];
    quantities["aberration_terms." + name] = terms_branch.statistics[at];
    metrics.push_back(tost(name, false, harvey_shack.statistics[at], sampling * harvey_shack.statistics[at],
                           terms_branch.statistics[at],
                           std::hypot(sampling, spread) * terms_branch.statistics[at],
                           study.equivalence.margin, study.equivalence.confidence));
  }
  add_paper_quantities("harvey_shack", study, scene, pupil, nominal, harvey_shack, &quantities);
  add_paper_quantities("aberration_terms", study, scene, pupil, nominal, terms_branch, &quantities);
  if (study.verify.published_phase) add_published_phase(study, pupil, nominal, threads, &quantities);
  if (study.verify.independent_terms) add_independent_terms(study, threads, &quantities);

  ordered_json result = {{"aberfit", 1}, {"kind", "verify"}, {"study", resolved_study(study)}};
  result["convention"] = study.target.convention == Convention::kPaper ? "paper" : "physical";
  const Verdict verdict = verify_verdict(scene, metrics);
  result["verdict"] = to_string(verdict);
  ResultDocument facts;
  facts.has_roughness = true;
  facts.scene = scene.numbers;
  describe_models(scene, to_string(Theory::kRays), &facts);
  facts.model = to_string(FocusModel::kRays);
  facts.realisation = realisation;
  result["scene"] = scene_json(facts);
  std::string text = fmt::format(
      "{}\n\nBoth branches, {} rays, convention {}; realisation scatter {:.1f} % (draws of this "
      "roughness)\n\n",
      study.title, pupil.size(), result["convention"].get<std::string>(), 100 * spread);
  text += fmt::format("  {:<28} {:>13} {:>13} {:>13} {:>9}  {}\n", "statistic [SI]", "theory", "Harvey-Shack",
                      "terms", "diff", "verdict");
  for (std::size_t k = 0; k < metrics.size(); ++k) {
    const EquivalenceMetric& m = metrics[k];
    text +=
        fmt::format("  {:<28} {:>13.6g} {:>13.6g} {:>13.6g} {:>8.2f}%  {}\n", m.name, theory[Eigen::Index(k)],
                    m.target, m.model, 100 * m.relative_difference, to_string(m.verdict));
    result["statistics"][m.name] = {{"theory", number(theory[Eigen::Index(k)])},
                                    {"harvey_shack", number(m.target)},
                                    {"aberration_terms", number(m.model)},
                                    {"relative_difference", number(m.relative_difference)},
                                    {"interval", {number(m.interval[0]), number(m.interval[1])}},
                                    {"verdict", to_string(m.verdict)}};
  }
  text += fmt::format("\n  verdict: {} at a margin of {:.3g} %\n", to_string(verdict),
                      100 * study.equivalence.margin);

  if (!study.verify.published.empty()) {
    text += fmt::format("\nPublished numbers\n\n  {:<44} {:>14} {:>16}  {}\n", "published", "printed", "ours",
                        "reading");
    result["published"] = ordered_json::array();
  }
  for (std::size_t k = 0; k < study.verify.published.size(); ++k) {
    const PublishedNumber& row = study.verify.published[k];
    const double ours = quantity(study, row, k, quantities) / row.scale;
    const std::string printed = fmt::format("{:.6g} {}", row.value, row.unit);
    const std::string shown = std::isfinite(ours) ? fmt::format("{:.5g} {}", ours, row.unit) : "-";
    text +=
        fmt::format("  {:<44} {:>14} {:>16}  {}\n", row.label, printed, shown, wrapped(row.reading, 64, 80));
    result["published"].push_back({{"label", row.label},
                                   {"unit", row.unit},
                                   {"printed", row.value},
                                   {"ours", number(ours)},
                                   {"from", row.formula.empty() ? row.quantity : row.formula},
                                   {"reading", row.reading}});
  }
  for (const auto& [name, value] : quantities) result["quantities"][name] = number(value);
  Warnings warnings;
  if (scene.use.choice->model != FocusModel::kRays)
    warnings.push_back({"rays-not-valid", scene.use.reason + " Both branches here are rays: their agreement "
                                                             "is no verdict on the focus."});
  if (study.trace.central_difference_step)
    warnings.push_back(
        {"central-difference", "normals by central differences: a hidden low-pass filter (PHYSICS 8)"});
  result["warnings"] = ordered_json::array();
  for (const Warning& warning : warnings) {
    result["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
    text += fmt::format("\n  {}: {}\n", warning.code, wrapped(warning.message, 88, 4));
  }
  if (table) *table = text;
  if (!options.output_directory.empty()) {
    write_file(options.output_directory + "/summary.txt", text);
    write_file(options.output_directory + "/result.json", result.dump(2) + "\n");
  }
  return result;
}

ordered_json run_trace(const Study& study, const RunOptions& options, std::string* table) {
  const int threads = options.threads > 0 ? options.threads : available_threads();
  const Scene scene = make_scene(study);
  const TargetSets targets = make_targets(study, scene, threads);
  TermSet terms;
  const Eigen::VectorXd coefficients = surface_coefficients(study, scene, options, &terms);
  const FocusModel model = scene.use.model;
  const bool by_rays = model == FocusModel::kRays;
  if (!by_rays && study.trace.central_difference_step)
    throw InputError(study.path, "/trace/normals",
                     "central differences with trace model \"" + to_string(model) + '"',
                     "\"analytic\" normals, or trace model \"rays\"");
  const PupilSample pupil =
      focus_pupil(study, model, model == FocusModel::kWaves ? wave_pitch(study, terms, targets.fitted) : 0);
  const RayBundle nominal = trace_nominal(study.mirror, pupil);
  const SurfaceField field = surface_field(study, pupil, terms, coefficients, threads);
  const RayBundle rays = trace(study.mirror, pupil, field);
  std::vector<Statistic> statistics;
  for (const Target& target : targets.fitted) statistics.push_back(target.statistic);
  Warnings warnings = scene.use.warnings;
  const Eigen::VectorXd values =
      by_rays
          ? evaluate_exact({rays, nominal, field.height, study.trace.centre}, statistics, threads, &warnings)
          : focus_statistics(
                {study.mirror, pupil, SurfaceOperator(terms, pupil, focus_operator(model, threads)), model,
                 study.wavelength, &study.aperture, study.trace.centre},
                coefficients, statistics, threads, &warnings);
  if (rays.lost > 0)
    warnings.push_back(
        {"lost-rays", fmt::format("{} of {} rays miss the focal region", rays.lost, rays.size())});

  ordered_json result = {{"aberfit", 1}, {"kind", "trace"}, {"study", resolved_study(study)}};
  result["theory"] = targets.theory;
  result["model"] = to_string(model);
  result["reason"] = scene.use.reason;
  result["rays"] = rays.size();
  result["lost_rays"] = rays.lost;
  result["terms"] = terms.size();
  std::string text =
      fmt::format("{}\n\nmodel {}, {} {} ({} lost), {} terms\n\n  {:<28} {:>14} {:>14} {:>9}\n", study.title,
                  to_string(model), rays.size(), model == FocusModel::kWaves ? "cells" : "rays", rays.lost,
                  terms.size(), "statistic [SI]", "surface", "target", "diff");
  for (std::size_t k = 0; k < statistics.size(); ++k) {
    const double value = values[Eigen::Index(k)], target = targets.fitted[k].value;
    const std::string name = statistic_name(statistics[k]);
    text += fmt::format("  {:<28} {:>14.6g} {:>14.6g} {:>8.2f}%\n", name, value, target,
                        100 * (value / target - 1));
    result["statistics"][name] = number(value);
    result["target"][name] = number(target);
  }
  result["warnings"] = ordered_json::array();
  for (const Warning& warning : warnings) {
    result["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
    text += fmt::format("\n  {}: {}\n", warning.code, wrapped(warning.message, 88, 4));
  }
  if (table) *table = text;
  return result;
}

}  // namespace aberfit
