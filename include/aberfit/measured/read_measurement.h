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
  kAuto,          ///< by content, then by name; see detect_format
  kDabam,         ///< DABAM profile: <name>.txt (JSON) and <name>.dat
  kProfileText,   ///< columns x, value, further scan lines
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

/// Thrown by readers for a file that leaves open what it means. fact: the option that says it, "quantity",
/// "of", "x_unit", "value_unit", "pitch", "wavelength", "hdu" or "plane". example: a value that would do,
/// where the reader alone knows one (hdu).
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

/// A measured file and everything about it that the file may not say itself. What is absent is taken from the
/// file; where the file does not say it either, reading fails with an InputError that names the option.
struct MeasuredSource {
  std::string path;
  MeasuredFormat format = MeasuredFormat::kAuto;
  int column = 1;                           ///< profiles: which scan line, from 1
  std::optional<ProfileQuantity> quantity;  ///< profile text: required unless a header names it
  std::optional<bool> wavefront;   ///< true: heights are those of a reflected wavefront, twice the surface's
  std::optional<double> x_factor;  ///< text: positions times this are [m]
  std::optional<double> value_factor;  ///< text, maps without a unit: values times this are [m] or [rad]
  bool value_in_waves = false;         ///< instead of value_factor: heights are in waves of `wavelength`
  std::optional<double> pitch;  ///< maps: pixel scale [m]; profiles whose positions are rounded: their step
  std::optional<int> columns;   ///< text maps: samples of a row, which may go over several lines
  bool bottom_first = false;    ///< text maps: the first row of the file has the lowest y
  std::optional<double> wavelength;  ///< [m], for values in waves or radians
  std::optional<std::string> hdu;    ///< FITS: name (EXTNAME) or number of the image, 0 the primary
  std::optional<int> plane;          ///< FITS, NumPy: which plane of a cube, from 1
  /// Values that mark a missing sample, as the file has them: in its own unit for text, FITS, NumPy and 4D,
  /// in metres of the surface for formats of instruments, whose numbers are counts. A sample has one where it
  /// is equal to within half a unit of the last place of a single-precision number.
  std::vector<double> invalid;
};

/// True for "wave" and "waves" in any case: heights in units of a wavelength.
bool is_waves(std::string_view unit);

using Measurement = std::variant<Profile, HeightMap>;

/// Reads any supported file. Throws InputError (file, place, found, allowed) for a file that is missing,
/// damaged, truncated, of an unknown format, or that leaves open what it means.
Measurement read_measurement(const MeasuredSource& source);

/// All that a file leaves open, as options; empty where it can be read, or cannot for another reason. A map
/// without pitch is read; "pitch" is among them nevertheless.
std::vector<std::string> missing_facts(const MeasuredSource& source);

/// What a file looks like; kAuto when nothing fits. Reads at most a few kilobytes, of HDF5 the names of what
/// is at its top. Throws InputError when it
/// cannot be opened.
MeasuredFormat detect_format(const std::string& path);
/// "auto", "dabam", "profile" and so on, in the order of MeasuredFormat.
const std::vector<std::string>& measured_format_names();
/// The same without "auto", for messages: "dabam, profile, ...".
std::string measured_format_list();
std::string to_string(MeasuredFormat format);

// The readers behind it, one file each; the same errors.
std::vector<Profile> read_dabam(
    const std::string& path);  ///< every scan line; path of the .txt, the .dat or without suffix
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
