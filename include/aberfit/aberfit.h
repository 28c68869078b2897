#pragma once

/// Includes all public headers, room by room in the order in which they build on each other, so that every
/// type in a signature is complete. It serves a first program, a notebook or a binding, and compiles as fast
/// as commands/run.h alone. A program that needs a single subject includes only that header, in half the
/// time. JSON is only declared: a program that calls `to_json` includes <nlohmann/json.hpp>. No file of the
/// library includes this one.

// core: units, errors, warnings, random streams, threads, instruction sets.
#include "aberfit/core/constants.h"
#include "aberfit/core/content_hash.h"
#include "aberfit/core/embedded_texts.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/instruction_set.h"
#include "aberfit/core/linear_algebra.h"
#include "aberfit/core/memory.h"
#include "aberfit/core/output_formats.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/parallel.h"
#include "aberfit/core/quadrature.h"
#include "aberfit/core/random.h"
#include "aberfit/core/root.h"
#include "aberfit/core/smooth_number.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/core/warning.h"

// scene: mirror, aperture, pupil points, Zernike modes.
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/scene/light.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/scene/quadrature_pupil.h"
#include "aberfit/scene/segments.h"
#include "aberfit/scene/zernike.h"

// measured: profiles and maps from files.
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/measured/focal_data.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/measured/masking.h"
#include "aberfit/measured/padding.h"
#include "aberfit/measured/profile.h"
#include "aberfit/measured/read_measurement.h"
#include "aberfit/measured/write_fits.h"
#include "aberfit/measured/write_map.h"

// roughness: PSD models, their integrals, random surfaces.
#include "aberfit/roughness/bessel.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/roughness/k_correlation.h"
#include "aberfit/roughness/line_kernel.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/roughness/psd_derivative.h"
#include "aberfit/roughness/psd_in_band.h"
#include "aberfit/roughness/psd_integrals.h"
#include "aberfit/roughness/psd_table.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/roughness/spectrum_cells.h"

// spectrum: from a measurement to its PSD and to a model of it.
#include "aberfit/spectrum/detrend.h"
#include "aberfit/spectrum/height_differences.h"
#include "aberfit/spectrum/ordinate_bins.h"
#include "aberfit/spectrum/outliers.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/spectrum/surface_psd.h"

// terms: term sets, their heights and slopes, their prior.
#include "aberfit/terms/derivatives.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/operator_cost.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/terms/surface_spectrum.h"
#include "aberfit/terms/term_set.h"

// trace: rays through the mirror.
#include "aberfit/trace/central_difference.h"
#include "aberfit/trace/nominal_surface.h"
#include "aberfit/trace/ray_bundle.h"

// focus: statistics of rays.
#include "aberfit/focus/circles_of_square.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/focus/statistic.h"

// waves: light by diffraction.
#include "aberfit/waves/diffraction_peak.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/lag_table.h"
#include "aberfit/waves/transfer_image.h"

// theory: Harvey-Shack, geometric and generalised; regimes; the split of a band.
#include "aberfit/theory/aberrated_light.h"
#include "aberfit/theory/abg_fit.h"
#include "aberfit/theory/aperture_otf.h"
#include "aberfit/theory/band_split.h"
#include "aberfit/theory/gaussian_in_disc.h"
#include "aberfit/theory/generalised_harvey_shack.h"
#include "aberfit/theory/geometric_harvey_shack.h"
#include "aberfit/theory/halo_kernel.h"
#include "aberfit/theory/height_on_aperture.h"
#include "aberfit/theory/light_property.h"
#include "aberfit/theory/model_choice.h"
#include "aberfit/theory/psd_jacobian.h"
#include "aberfit/theory/ray_perturbation.h"
#include "aberfit/theory/realisation_spread.h"
#include "aberfit/theory/regime.h"
#include "aberfit/theory/round_pixels.h"
#include "aberfit/theory/scatter_function.h"
#include "aberfit/theory/scattered_rays.h"
#include "aberfit/theory/scattering_band.h"
#include "aberfit/theory/theory_error.h"
#include "aberfit/theory/vocabulary.h"

// forward: coefficients to statistics with derivatives, by rays or by waves.
#include "aberfit/forward/focus_transfer.h"
#include "aberfit/forward/forward_model.h"
#include "aberfit/forward/height_block_side.h"
#include "aberfit/forward/statistics_with_error.h"
#include "aberfit/forward/term_moments.h"

// fit: the solve.
#include "aberfit/fit/calibrate.h"
#include "aberfit/fit/map_fit.h"
#include "aberfit/fit/parameter_fit.h"

// method: the procedure: targets, terms, fits, verdict.
#include "aberfit/method/all_scatter.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"
#include "aberfit/method/band_use.h"
#include "aberfit/method/character.h"
#include "aberfit/method/conclude.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/fit_as_asked.h"
#include "aberfit/method/fresh_verdict.h"
#include "aberfit/method/frontier.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/image_shift.h"
#include "aberfit/method/judge.h"
#include "aberfit/method/judged_set.h"
#include "aberfit/method/map_light.h"
#include "aberfit/method/map_terms.h"
#include "aberfit/method/measured_part.h"
#include "aberfit/method/mirror_spread.h"
#include "aberfit/method/outcome.h"
#include "aberfit/method/physics_choice.h"
#include "aberfit/method/plan.h"
#include "aberfit/method/pupil_choice.h"
#include "aberfit/method/ray_count.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/specified_light.h"
#include "aberfit/method/spectrum_target.h"
#include "aberfit/method/task.h"
#include "aberfit/method/theory_values.h"
#include "aberfit/method/tost.h"
#include "aberfit/method/trace_surface.h"
#include "aberfit/method/verify.h"

// chart: speed against accuracy; predicted cost.
#include "aberfit/chart/chart.h"
#include "aberfit/chart/check.h"

// specify: which roughness meets a budget.
#include "aberfit/specify/budget.h"
#include "aberfit/specify/budget_light.h"
#include "aberfit/specify/ceilings.h"
#include "aberfit/specify/contributors.h"
#include "aberfit/specify/psd_of_focus.h"
#include "aberfit/specify/solve.h"

// report: results as JSON, tables, pictures, files for other programs.
#include "aberfit/report/arrays.h"
#include "aberfit/report/ceilings_report.h"
#include "aberfit/report/chart.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/exports.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/report/html_report.h"
#include "aberfit/report/page.h"
#include "aberfit/report/pictures.h"
#include "aberfit/report/psd_of_focus_report.h"
#include "aberfit/report/psd_report.h"
#include "aberfit/report/result.h"
#include "aberfit/report/result_folder.h"
#include "aberfit/report/scatter_table.h"
#include "aberfit/report/solve_report.h"
#include "aberfit/report/sweep_report.h"
#include "aberfit/report/verify_report.h"

// study: the study file.
#include "aberfit/study/field_errors.h"
#include "aberfit/study/measured_psd.h"
#include "aberfit/study/parse_json.h"
#include "aberfit/study/psd_numbers.h"
#include "aberfit/study/read_study.h"
#include "aberfit/study/study.h"
#include "aberfit/study/study_cases.h"
#include "aberfit/study/unusual.h"

// cases: the studies that a `vary` block stands for, handed out, recorded, gathered.
#include "aberfit/cases/case_plan.h"
#include "aberfit/cases/case_record.h"
#include "aberfit/cases/gather.h"
#include "aberfit/cases/journal.h"
#include "aberfit/cases/run_cases.h"
#include "aberfit/cases/shard.h"
#include "aberfit/cases/team.h"

// commands: what the program does, as functions.
#include "aberfit/commands/answer.h"
#include "aberfit/commands/program.h"
#include "aberfit/commands/run.h"
#include "aberfit/commands/run_options.h"
#include "aberfit/commands/serve.h"
#include "aberfit/commands/terminal_text.h"
