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

/// The line of a drawing as a `roughness` block of a study, to paste; its numbers read back to the same bits.
nlohmann::ordered_json line_block(const DrawingLine& line);

/// Bins as CSV: frequency [1/m], PSD [m^3 or m^4], interval, degrees of freedom, the model's expectation; the
/// first two columns make a table for `psd.model: "table"`.
std::string psd_csv(const PsdReport& report);

/// RMS height [m] and slope [rad] by band as CSV: those asked for, then every octave.
std::string bands_csv(const PsdReport& report);

/// Pictures psd (bins with intervals, model, lines), structure_function, data, data_2 ... (the detrended
/// profiles or maps), as those of a fit (report/pictures.h).
std::vector<DrawnPicture> draw_pictures(const PsdReport& report, const std::string& directory,
                                        const PictureOptions& options, Warnings* warnings);

}  // namespace aberfit
