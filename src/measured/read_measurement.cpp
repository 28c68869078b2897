#include "aberfit/measured/read_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/text.h"
#include "foreign_formats.h"
#include "unknown_text_file.h"

namespace aberfit {
using namespace internal;

namespace {

Measurement chosen(std::vector<Profile> profiles, const MeasuredSource& source) {
  if (source.column < 1 || std::size_t(source.column) > profiles.size())
    throw InputError(source.path, "option 'column'", fmt::format("{}", source.column),
                     profiles.size() == 1 ? "1, the only scan line"
                                          : fmt::format("a scan line from 1 to {}", profiles.size()));
  return std::move(profiles[std::size_t(source.column) - 1]);
}

// DABAM metadata give every factor of the surface, so an option would be ignored silently.
Measurement dabam_measurement(const MeasuredSource& source) {
  const char* given = source.wavefront.value_or(false)               ? "of"
                      : source.x_factor                              ? "x_unit"
                      : source.value_factor || source.value_in_waves ? "value_unit"
                      : source.pitch                                 ? "pitch"
                                                                     : nullptr;
  if (given)
    throw InputError(source.path, fmt::format("option '{}'", given),
                     "a DABAM profile, whose metadata state this",
                     "no such option; or the .dat file read as format 'profile'");
  std::vector<Profile> profiles = read_dabam(source.path);
  const bool slopes = profiles.front().quantity == ProfileQuantity::kSlope;
  if (source.quantity && *source.quantity != profiles.front().quantity)
    throw InputError(source.path, "option 'quantity'",
                     slopes ? "a profile of slopes" : "a profile of heights",
                     "the quantity that FILE_FORMAT names, or no such option");
  return chosen(std::move(profiles), source);
}

void require_between(const std::string& path, const char* what, double value, double least, double most,
                     const char* unit) {
  if (!(value >= least && value <= most))
    throw InputError(path, what, fmt::format("{:.6g} {}", value, unit),
                     fmt::format("{:g} to {:g} {} (a unit may be wrong)", least, most, unit));
}

// No mirror exceeds these limits [m], slope [rad]. A value outside means a wrong unit or a damaged file.
constexpr double kFarthest = 1e6, kFinest = 1e-12, kCoarsest = 1e3, kHighest = 1e3, kSteepest = 10;

void require_sane(const std::string& path, const Profile& profile) {
  for (const double x : profile.x) require_between(path, "position", x, -kFarthest, kFarthest, "m");
  require_between(path, "median pitch", median_pitch(profile), kFinest, kCoarsest, "m");
  const bool slope = profile.quantity == ProfileQuantity::kSlope;
  const double most = slope ? kSteepest : kHighest;
  for (const double value : profile.value)
    if (!std::isnan(value))
      require_between(path, slope ? "slope" : "height", value, -most, most, slope ? "rad" : "m");
}

// If a file does not declare its mark of missing points, that mark is often a number that no height can have.
void require_sane_height(const std::string& path, const HeightMap& map, double height) {
  if (height >= -kHighest && height <= kHighest) return;
  const Eigen::Index same = (map.height == height).count();
  const std::string allowed = fmt::format("{:g} to {:g} m (a unit may be wrong)", -kHighest, kHighest);
  throw InputError(path, "height", fmt::format("{:.6g} m", height),
                   same < 2 ? allowed
                            : fmt::format("{}. Or these {} points, all {:.9g} in the file, are not measured; "
                                          "then option 'invalid' with this value makes them holes",
                                          allowed, same, height / map.file_unit));
}

void require_sane(const std::string& path, const HeightMap& map) {
  // 0 means that the file does not state the pitch.
  for (const double pitch : {map.pitch_x, map.pitch_y})
    if (pitch != 0) require_between(path, "pitch", pitch, kFinest, kCoarsest, "m");
  for (const double x : {map.x(0), map.x(map.columns() - 1), map.y(0), map.y(map.rows() - 1)})
    require_between(path, "position", x, -kFarthest, kFarthest, "m");
  for (Eigen::Index i = 0; i < map.height.size(); ++i)
    if (const double h = map.height.data()[i]; !std::isnan(h)) require_sane_height(path, map, h);
}

// Makes samples invalid whose value is one of `invalid`, in units of the file.
template <class Values>
Eigen::Index take_out_said(const std::vector<double>& invalid, double file_unit, Values* values) {
  constexpr double kHalfPlaceOfSingle = 0x1p-24;
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < values->size(); ++i) {
    double& value = values->data()[i];
    const bool said = std::any_of(invalid.begin(), invalid.end(), [&](double mark) {
      const double marked = mark * file_unit;
      return std::abs(value - marked) <= kHalfPlaceOfSingle * std::abs(marked);
    });
    if (said) value = kNaN, ++count;
  }
  return count;
}

void take_out_said(const std::vector<double>& invalid, Profile* profile) {
  profile->said_invalid = take_out_said(invalid, profile->file_unit, &profile->value);
}
void take_out_said(const std::vector<double>& invalid, HeightMap* map) {
  map->said_invalid = take_out_said(invalid, map->file_unit, &map->height);
}

// Sets the missing option to an arbitrary value, so that reading continues and shows what else is missing.
void suppose(const MissingFact& missing, MeasuredSource* source) {
  const std::string& fact = missing.fact();
  if (fact == "quantity") source->quantity = ProfileQuantity::kHeight;
  if (fact == "of") source->wavefront = false;
  if (fact == "x_unit") source->x_factor = 1e-3;
  if (fact == "value_unit") source->value_factor = 1e-9;
  if (fact == "pitch") source->pitch = 1e-3;
  if (fact == "wavelength") source->wavelength = 500e-9;
  if (fact == "hdu") source->hdu = missing.example();
  if (fact == "plane") source->plane = 1;
}

// Throws InputError for options that the format does not use; otherwise they would be ignored silently.
void require_options_of(MeasuredFormat format, const MeasuredSource& source) {
  using enum MeasuredFormat;
  if (format == kAuto) return;
  const bool matrix = format == kMapText;
  // DABAM has its own list of refused options
  const bool text = matrix || format == kProfileText || format == kDabam;
  const bool scaled =
      format == kZygo || format == kCodeVInt || format == kZemaxGridSag || format == kDftfringe;
  struct Option {
    bool refused;
    const char *name, *allowed;
  };
  for (const auto& [refused, name, allowed] :
       {Option{!matrix && source.columns, "columns", "it is for matrices of text (format map)"},
        Option{!matrix && source.bottom_first && format != kNpy, "first_row",
               "it is for matrices of text and arrays (formats map and npy)"},
        Option{source.hdu && format != kFits, "hdu", "it is for FITS files"},
        Option{source.plane && format != kFits && format != kNpy, "plane",
               "it is for cubes (formats fits and npy)"},
        Option{!text && source.x_factor, "x_unit", "it is for positions in text (formats profile and map)"},
        Option{scaled && (source.value_factor || source.value_in_waves), "value_unit",
               "such files state what their heights are"}})
    if (refused)
      throw InputError(source.path, fmt::format("option '{}'", name),
                       fmt::format("a file of format {}", to_string(format)),
                       fmt::format("no such option, because {}", allowed));
}

Measurement read_as(const MeasuredSource& source, MeasuredFormat format) {
  switch (format) {
    case MeasuredFormat::kDabam:
      return dabam_measurement(source);
    case MeasuredFormat::kProfileText:
      return chosen(read_profile_text(source), source);
    case MeasuredFormat::kMapText:
      return read_map_text(source);
    case MeasuredFormat::kZygo:
      return read_zygo(source);
    case MeasuredFormat::kCodeVInt:
      return read_codev_int(source);
    case MeasuredFormat::kFits:
      return read_fits(source);
    case MeasuredFormat::kZemaxGridSag:
      return read_zemax_grid_sag(source);
    case MeasuredFormat::kDatx:
      return read_datx(source);
    case MeasuredFormat::kOpd:
      return read_opd(source);
    case MeasuredFormat::kSdf:
      return read_sdf(source);
    case MeasuredFormat::kX3p:
      return read_x3p(source);
    case MeasuredFormat::kZygoText:
      return read_zygo_text(source);
    case MeasuredFormat::kWykoText:
      return read_wyko_text(source);
    case MeasuredFormat::kDftfringe:
      return read_dftfringe(source);
    case MeasuredFormat::kFourD:
      return read_4d(source);
    case MeasuredFormat::kNpy:
      return read_npy(source);
    case MeasuredFormat::kAuto:
      internal::refuse_foreign_format(source.path);
      refuse_unknown_text(source);
      break;
  }
  throw InputError(source.path, "", "a file of unknown format", "a file of format " + measured_format_list());
}

}  // namespace

bool is_waves(std::string_view unit) {
  const std::string lower = lower_case(unit);
  return lower == "waves" || lower == "wave";
}

Measurement read_measurement(const MeasuredSource& source) {
  MeasuredFormat format = source.format;
  if (format == MeasuredFormat::kAuto) format = detect_format(source.path);
  // Rows that extend over several lines look like columns of a profile, or like no format at all.
  if (source.columns && source.format == MeasuredFormat::kAuto &&
      (format == MeasuredFormat::kAuto || format == MeasuredFormat::kProfileText))
    format = MeasuredFormat::kMapText;
  require_options_of(format, source);
  Measurement data = read_as(source, format);
  std::visit(
      [&](auto& measured) {
        if (!source.invalid.empty()) take_out_said(source.invalid, &measured);
        require_sane(source.path, measured);
      },
      data);
  return data;
}

std::vector<std::string> missing_facts(const MeasuredSource& source) {
  std::vector<std::string> facts;
  MeasuredSource supposed = source;
  constexpr std::size_t kMost = 8;
  try {
    while (facts.size() < kMost) {
      try {
        const Measurement data = read_measurement(supposed);
        const auto* map = std::get_if<HeightMap>(&data);
        if (map && !(map->pitch_x > 0 && map->pitch_y > 0)) facts.push_back("pitch");
        return facts;
      } catch (const MissingFact& missing) {
        facts.push_back(missing.fact());
        suppose(missing, &supposed);
      }
    }
  } catch (const InputError&) {
    // The arbitrary values may not suit the file. The options found so far are then returned.
  }
  return facts;
}

}  // namespace aberfit
