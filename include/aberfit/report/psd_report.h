#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/measured/clear_aperture.h"
#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/result.h"
#include "aberfit/spectrum/height_differences.h"
#include "aberfit/spectrum/psd_estimate.h"
#include "aberfit/spectrum/psd_model_fit.h"
#include "aberfit/spectrum/surface_psd.h"

namespace aberfit {

/// A measurement, its PSD and the fitted model.
struct PsdReport {
  std::string title;               ///< for people
  std::vector<std::string> files;  ///< one per measurement
  std::vector<Measurement> data;
  std::vector<ClearRegion> clear;  ///< one per measurement
  PsdEstimate estimate;
  PsdModelFit fit;
  SurfacePsd surface;  ///< PSD that is printed, written and drawn
  DrawingLine line;
  DrawingLine as_measured;  ///< line with the bins' RMS height and slope; `exponent` NaN: model has them
  std::vector<HeightDifferences> differences;  ///< structure functions, one per measurement
  std::vector<BandContent> bands;              ///< requested bands
  Warnings warnings;
  Provenance provenance;

  /// RMS values of the model or of the bins, in the band of the fit.
  BandRms in_band(bool of_model) const;
};

/// The line of a drawing as a `roughness` block for a study. Its numbers read back to the same bits.
nlohmann::ordered_json line_block(const DrawingLine& line);

/// Bins as CSV: frequency [1/m], PSD [m^3 or m^4], interval, degrees of freedom, the model's expectation. The
/// first two columns are a table for `psd.model: "table"`.
std::string psd_csv(const PsdReport& report);

/// RMS height [m] and slope [rad] by band as CSV: requested bands, then every octave.
std::string bands_csv(const PsdReport& report);

/// Draws pictures psd (bins with intervals, model, lines), structure_function, data, data_2 ... (the
/// detrended profiles or maps), as a fit does (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const PsdReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
