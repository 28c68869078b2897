#include "aberfit/measured/read_measurement.h"

#include <fmt/format.h>

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

Measurement chosen(std::vector<Profile> profiles, const MeasuredSource& source) {
  if (source.column < 1 || std::size_t(source.column) > profiles.size())
    throw InputError(source.path, "option 'column'", fmt::format("{}", source.column),
                     profiles.size() == 1 ? "1, the only scan line"
                                          : fmt::format("a scan line from 1 to {}", profiles.size()));
  return std::move(profiles[std::size_t(source.column) - 1]);
}

// DABAM metadata give every factor, and its profiles are of the surface: an option would be ignored unsaid.
Measurement dabam_measurement(const MeasuredSource& source) {
  const char* given = source.wavefront.value_or(false) ? "of"
                      : source.x_factor                ? "x_unit"
                      : source.value_factor            ? "value_unit"
                      : source.pitch                   ? "pitch"
                                                       : nullptr;
  if (given)
    throw InputError(source.path, fmt::format("option '{}'", given), "a DABAM profile, whose metadata say it",
                     "no such option; or the .dat file read as format 'profile'");
  std::vector<Profile> profiles = read_dabam(source.path);
  const bool slopes = profiles.front().quantity == ProfileQuantity::kSlope;
  if (source.quantity && *source.quantity != profiles.front().quantity)
    throw InputError(source.path, "option 'quantity'",
                     slopes ? "a profile of slopes" : "a profile of heights",
                     "the quantity that FILE_FORMAT names, or no such option");
  return chosen(std::move(profiles), source);
}

}  // namespace

Measurement read_measurement(const MeasuredSource& source) {
  const MeasuredFormat format =
      source.format == MeasuredFormat::kAuto ? detect_format(source.path) : source.format;
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
    case MeasuredFormat::kAuto:
      break;
  }
  throw InputError(
      source.path, "", "no format that is known here",
      "DABAM, columns or a matrix of numbers, Zygo MetroPro .dat, CODE V INT, FITS, Zemax grid sag");
}

}  // namespace aberfit
