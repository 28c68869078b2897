#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/measured/padding.h"
#include "aberfit/spectrum/outliers.h"
#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {
namespace {

// Limits of heights, slopes and lengths that mirrors can have. Lengths range from the smallest scan of a
// force microscope to a telescope of 39 m or a dish of 50 m for millimetre waves.
constexpr double kHighest = 0.01;                  // fraction of the length, after subtraction of a parabola
constexpr double kSteepest = 1;                    // [rad]
constexpr double kShortest = 1e-7, kLongest = 50;  // [m]

std::string with_and_without(const SurfaceRms& with, const SurfaceRms& without) {
  const auto length = [](double value) { return format_quantity(value, Dimension::kLength); };
  const auto angle = [](double value) { return format_quantity(value, Dimension::kAngle); };
  return fmt::format("the RMS slope is {} instead of {}, the RMS height {} instead of {}",
                     angle(without.slope), angle(with.slope), length(without.height), length(with.height));
}

// Example: "1,929 of 5,184 points (37.2 %) have the height 0 m exactly (0 in the file), ..., in 4 blocks".
std::string padding_words(const HeightMap& map, const Padding& one) {
  const double valid = double(valid_count(map));
  const std::string where =
      one.outside == one.points ? "all of them outside the convex hull of the others"
      : one.outside == 0        ? "none of them outside the convex hull of the others"
                         : grouped(double(one.outside)) + " of them outside the convex hull of the others";
  return fmt::format(
      "{} of {} points ({:.3g} %) have the height {} exactly ({:.9g} in the file), {}, in {} "
      "{}",
      grouped(double(one.points)), grouped(valid), 100 * double(one.points) / valid,
      format_quantity(one.height, Dimension::kLength), one.height / map.file_unit, where,
      grouped(double(one.blocks)), one.blocks == 1 ? "block" : "blocks");
}

// Warns but removes nothing, because only the author of the file knows whether a height is padding.
void warn_of_padding(const HeightMap& map, const DetrendOptions& detrend, Warnings* warnings) {
  const std::vector<Padding> padding = find_padding(map);
  if (padding.empty()) return;
  HeightMap rest = map;
  take_out(&rest, padded_points(map, padding));
  std::string text, values;
  for (const Padding& one : padding) {
    text += padding_words(map, one) + "; ";
    values += fmt::format("{}{:.9g}", values.empty() ? "" : ",", one.height / map.file_unit);
  }
  warnings->push_back(
      {"padding", fmt::format("{}without them {}. If they are not measured, set `invalid: [{}]` (`--invalid "
                              "{}`) to make them holes",
                              text, with_and_without(surface_rms(map, detrend), surface_rms(rest, detrend)),
                              values, values)});
}

template <class Measured>
void treat(Measured* data, OutlierTreatment treatment, const DetrendOptions& detrend, Warnings* warnings) {
  const Outliers outliers = find_outliers(*data);
  if (outliers.count == 0) return;
  Measured clean = *data;
  take_out(&clean, outliers.found);
  const std::string found =
      fmt::format("{} of {} samples differ from their surroundings by more than {:.2g} sigma",
                  grouped(double(outliers.count)), grouped(double(outliers.tested)), outliers.threshold);
  const std::string effect = with_and_without(surface_rms(*data, detrend), surface_rms(clean, detrend));
  if (treatment == OutlierTreatment::kWarn) {
    warnings->push_back(
        {"outliers",
         fmt::format("{}; without them {}; `outliers: \"reject\"` makes them holes", found, effect)});
    return;
  }
  warnings->push_back({"outliers-rejected", fmt::format("{} and become holes: {}", found, effect)});
  *data = std::move(clean);
}

// Peak to valley; negative if nothing is valid.
template <class Values>
double span(const Values& z) {
  return z.isFinite().select(z, -kInfinity).maxCoeff() - z.isFinite().select(z, kInfinity).minCoeff();
}

// Describes an implausible length or height; empty if both are plausible.
std::string unusual_extent(double height, double length, const char* of) {
  const auto length_text = [](double value) { return format_quantity(value, Dimension::kLength); };
  if (length > 0 && !(length >= kShortest && length <= kLongest)) {
    const double factor = length > kLongest ? 1e-3 : 1e3, meant = length * factor;
    const bool explains = meant >= kShortest && meant <= kLongest;
    return fmt::format("the {} is {}, but usual values are {} to {}{}", of, length_text(length),
                       length_text(kShortest), length_text(kLongest),
                       explains ? fmt::format(", {} for example", length_text(meant)) : "");
  }
  if (!(length > 0 && height > kHighest * length)) return "";
  return fmt::format("heights without their parabola span {} of the {}, {}; usual values are up to {}",
                     format_percent(height / length), of, length_text(length), format_percent(kHighest));
}

std::string unusual(const Profile& profile) {
  if (profile.size() == 0) return "";
  const Eigen::ArrayXd& x = profile.x;
  const double length = x[x.size() - 1] - x[0];
  if (profile.quantity != ProfileQuantity::kSlope)
    return unusual_extent(span(detrend(profile, {}).value), length, "record's length");
  if (const std::string what = unusual_extent(0, length, "record's length"); !what.empty()) return what;
  const double most = profile.value.isFinite().select(profile.value.abs(), 0.0).maxCoeff();
  if (!(most > kSteepest)) return "";
  return fmt::format("slopes reach {}; usual values are up to {}", format_quantity(most, Dimension::kAngle),
                     format_quantity(kSteepest, Dimension::kAngle));
}

std::string unusual(const HeightMap& map) {
  const double diagonal = std::hypot(map.pitch_x * double(map.columns()), map.pitch_y * double(map.rows()));
  return unusual_extent(span(detrend(map, {}).height), diagonal, "map's diagonal");
}

}  // namespace

Warnings screen(Measurement* data, OutlierTreatment treatment, const DetrendOptions& detrend) {
  Warnings warnings;
  if (const auto* map = std::get_if<HeightMap>(data)) warn_of_padding(*map, detrend, &warnings);
  std::visit(
      [&](auto& measured) {
        if (treatment != OutlierTreatment::kKeep) treat(&measured, treatment, detrend, &warnings);
        if (const std::string what = unusual(measured); !what.empty())
          warnings.push_back({"unusual", what + ". Is a unit wrong, of the values or of the positions "
                                                "(`value_unit`, `x_unit`, `pitch`)?"});
      },
      *data);
  return warnings;
}

}  // namespace aberfit
