#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/report/result.h"
#include "aberfit/spectrum/height_differences.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/spectrum/surface_psd.h"

namespace aberfit {

/// A measurement, its PSD and the model that was fitted to it.
struct PsdReport {
  std::string title;               ///< for people
  std::vector<std::string> files;  ///< one per measurement
  std::vector<Measurement> data;
  std::vector<ClearRegion> clear;  ///< of each
  PsdEstimate estimate;
  PsdModelFit fit;
  SurfacePsd surface;  ///< what is printed, written and drawn
  DrawingLine line;
  DrawingLine
      as_measured;  ///< with the RMS height and slope of the bins; `exponent` NaN where the model has them
  std::vector<HeightDifferences> differences;  ///< structure functions, one per measurement
  std::vector<BandContent> bands;              ///< those that were asked for
  Warnings warnings;
  Provenance provenance;

  /// Of the model or of the bins, in the band of the fit.
  BandRms in_band(bool of_model) const;
};

/// result.json of `aberfit psd`: request, measurement, estimate (bins with intervals, degrees of freedom and
/// the model's expectation), lines, model with parameters and candidates, roughness block, warnings. SI
/// numbers, unit in the key; what does not exist is null. request: every option, as a `psd` block of model
/// `measured`; roughness: the fitted model as a `roughness` block of a study.
nlohmann::ordered_json to_json(const PsdReport& report, const nlohmann::ordered_json& request,
                               const nlohmann::ordered_json& roughness);

/// The line of a drawing as a `roughness` block of a study, to paste; its numbers read back to the same bits.
nlohmann::ordered_json line_block(const DrawingLine& line);

/// Bins as CSV: frequency [1/m], PSD [m^3 or m^4], interval, degrees of freedom, the model's expectation; the
/// first two columns make a table for `psd.model: "table"`.
std::string psd_csv(const PsdReport& report);

/// RMS height [m] and slope [rad] by band as CSV: those asked for, then every octave.
std::string bands_csv(const PsdReport& report);

/// The table people read on the terminal, at most 100 columns, and the roughness block.
std::string summary_table(const PsdReport& report, const nlohmann::ordered_json& roughness);

/// Pictures below `directory`/plots: psd (bins with intervals, model, lines), structure_function, data (the
/// detrended profile or map). As write_plots.
std::vector<std::string> write_psd_plots(const PsdReport& report, const std::string& directory,
                                         Warnings* warnings);

}  // namespace aberfit
