#pragma once
#include <string>
#include <vector>

// The formats that a study can choose for what it writes. The room `report` writes them.
namespace aberfit {

/// Formats of pictures. kAuto: SVG for curves, PNG for maps and clouds of points.
enum class PictureFormat { kAuto, kPng, kSvg, kPdf, kNone };
/// Their names in a study and on the command line, in the order of the enumeration.
const std::vector<std::string>& picture_format_names();

/// Formats of the arrays behind the pictures (report/arrays.h).
enum class ArrayFormat {
  kNone,
  kNpz,   ///< arrays.npz, for numpy.load
  kCsv,   ///< one table each
  kFits,  ///< psf.fits and otf.fits; curves are not written
};
/// "none", "npz", "csv", "fits", in the order of the enumeration.
const std::vector<std::string>& array_format_names();

/// Formats of the term surface for other programs (report/exports.h).
enum class ExportFormat {
  kZemaxGridSag,  ///< grid_sag.DAT
  kZernikeNoll,   ///< zernike_standard.txt: Zemax Zernike Standard listing
  kCodeVInt,      ///< surface.int
  kCodeVZfr,      ///< zernike_fringe.int
  kFitsOpd,       ///< opd.fits, for POPPY
  kCsv,           ///< surface.csv: x, y, h
};
/// "zemax-grid-sag", "zernike-noll", "codev-int", "codev-zfr", "fits-opd", "csv", in the order of the
/// enumeration.
const std::vector<std::string>& export_names();

}  // namespace aberfit
