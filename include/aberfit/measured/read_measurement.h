#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "aberfit/core/errors.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/measured/profile.h"

namespace aberfit {

enum class MeasuredFormat {
  kAuto,          ///< recognised by content, then by name; see detect_format
  kDabam,         ///< DABAM profile: <name>.txt (JSON) and <name>.dat
  kProfileText,   ///< columns: x, value, further scan lines
  kMapText,       ///< a matrix of numbers, first line = top row, or columns x, y, z
  kZygo,          ///< MetroPro .dat, binary
  kCodeVInt,      ///< CODE V interferogram
  kFits,          ///< FITS image
  kZemaxGridSag,  ///< OpticStudio grid sag .DAT
  kDatx,          ///< Zygo Mx .datx, HDF5
  kOpd,           ///< Wyko / Veeco Vision .opd, binary
  kSdf,           ///< surface data file of ISO 25178-71, text or binary
  kX3p,           ///< ISO 25178-72, a zip archive
  kZygoText,      ///< MetroPro text: "Zygo XYZ Data File", "Zygo ASCII Data File"
  kWykoText,      ///< Wyko / Veeco / Bruker Vision text: "Wyko ASCII Data File Format"
  kDftfringe,     ///< wavefront of DFTFringe, .wft
  kFourD,         ///< 4D Technology .h5, HDF5
  kNpy,           ///< NumPy .npy
};

/// Readers throw this for a file that is ambiguous without further information. fact: the option that
/// supplies the information, "quantity", "of", "x_unit", "value_unit", "pitch", "wavelength", "hdu" or
/// "plane". example: a possible value, if only the reader knows one (hdu).
class MissingFact : public InputError {
 public:
  MissingFact(const char* fact, const std::string& file, const std::string& pointer, const std::string& found,
              const std::string& allowed, const std::string& example = "")
      : InputError(file, pointer, found, allowed), fact_(fact), example_(example) {}
  const std::string& fact() const { return fact_; }
  const std::string& example() const { return example_; }

 private:
  std::string fact_, example_;
};

/// A measured file and the facts that the file itself may not state. An absent option is taken from the file.
/// If the file does not state it either, reading fails with an InputError that names the option.
struct MeasuredSource {
  std::string path;
  MeasuredFormat format = MeasuredFormat::kAuto;
  int column = 1;                           ///< profiles: number of the scan line, from 1
  std::optional<ProfileQuantity> quantity;  ///< profile text: required unless a header names it
  std::optional<bool> wavefront;       ///< true: heights of a reflected wavefront, twice those of the surface
  std::optional<double> x_factor;      ///< text: factor from positions to [m]
  std::optional<double> value_factor;  ///< text, maps without a unit: factor from values to [m] or [rad]
  bool value_in_waves = false;         ///< alternative to value_factor: heights are in waves of `wavelength`
  std::optional<double> pitch;  ///< maps: pixel scale [m]; profiles with rounded positions: their step [m]
  std::optional<int> columns;   ///< text maps: samples per row, which may extend over several lines
  bool bottom_first = false;    ///< text maps: the first row of the file has the lowest y
  std::optional<double> wavelength;  ///< [m], for values in waves or radians
  std::optional<std::string> hdu;    ///< FITS: name (EXTNAME) or number of the image, 0 the primary
  std::optional<int> plane;          ///< FITS, NumPy: plane of a cube, from 1
  /// Values that mark a missing sample, as they stand in the file. They are in the unit of the file for text,
  /// FITS, NumPy and 4D, and in metres of the surface for instrument formats, which store counts. A sample
  /// matches if it is equal to within half a unit of the last place of a single-precision number.
  std::vector<double> invalid;
};

/// Returns true for "wave" and "waves" in any case, which mean heights in units of a wavelength.
bool is_waves(std::string_view unit);

using Measurement = std::variant<Profile, HeightMap>;

/// Reads a file of any supported format. Throws InputError (file, place, found, allowed) if the file is
/// missing, damaged, truncated, ambiguous or of an unknown format.
Measurement read_measurement(const MeasuredSource& source);

/// Returns the options that the file needs. Empty if the file can be read, or cannot be read for another
/// reason. "pitch" is included for a map without pitch, although such a map can be read.
std::vector<std::string> missing_facts(const MeasuredSource& source);

/// Returns the format of a file, kAuto if none fits. Reads at most a few kilobytes; for HDF5 only the names
/// at the top level. Throws InputError if the file cannot be opened.
MeasuredFormat detect_format(const std::string& path);
/// Returns "auto", "dabam", "profile" and so on, in the order of MeasuredFormat.
const std::vector<std::string>& measured_format_names();
/// Returns the names without "auto" for messages: "dabam, profile, ...".
std::string measured_format_list();
std::string to_string(MeasuredFormat format);

// The readers of the single formats, one per source file. They throw the same errors as read_measurement.
std::vector<Profile> read_dabam(const std::string& path);  ///< returns every scan line; `path` is the .txt,
                                                           ///< the .dat or the name without suffix
std::vector<Profile> read_profile_text(const MeasuredSource& source);
HeightMap read_map_text(const MeasuredSource& source);
HeightMap read_zygo(const MeasuredSource& source);
HeightMap read_codev_int(const MeasuredSource& source);
HeightMap read_fits(const MeasuredSource& source);
HeightMap read_zemax_grid_sag(const MeasuredSource& source);
HeightMap read_datx(const MeasuredSource& source);
HeightMap read_opd(const MeasuredSource& source);
HeightMap read_sdf(const MeasuredSource& source);
HeightMap read_x3p(const MeasuredSource& source);
HeightMap read_zygo_text(const MeasuredSource& source);
HeightMap read_wyko_text(const MeasuredSource& source);
HeightMap read_dftfringe(const MeasuredSource& source);
HeightMap read_4d(const MeasuredSource& source);
HeightMap read_npy(const MeasuredSource& source);

}  // namespace aberfit
