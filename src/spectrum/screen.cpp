#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "aberfit/core/constants.h"
#include "aberfit/core/text.h"
#include "aberfit/core/units.h"
#include "aberfit/spectrum/outliers.h"
#include "aberfit/spectrum/psd_estimate.h"

namespace aberfit {
namespace {

constexpr double kHighest = 0.01;  // of the length, a parabola taken off
constexpr double kSteepest = 1;    // [rad]

std::string with_and_without(const SurfaceRms& with, const SurfaceRms& without) {
  const auto length = [](double value) { return format_quantity(value, Dimension::kLength); };
  const auto angle = [](double value) { return format_quantity(value, Dimension::kAngle); };
  return fmt::format("the RMS slope is {} instead of {}, the RMS height {} instead of {}",
                     angle(without.slope), angle(with.slope), length(without.height), length(with.height));
}

template <class Measured>
void treat(Measured* data, OutlierTreatment treatment, const DetrendOptions& detrend, Warnings* warnings) {
  const Outliers outliers = find_outliers(*data);
  if (outliers.count == 0) return;
  Measured clean = *data;
  take_out(&clean, outliers.found);
  const std::string found =
      fmt::format("{} of {} samples stand out of their surroundings by more than {:.2g} sigma",
                  grouped(double(outliers.count)), grouped(double(outliers.tested)), outliers.threshold);
  const std::string effect = with_and_without(surface_rms(*data, detrend), surface_rms(clean, detrend));
  if (treatment == OutlierTreatment::kWarn) {
    warnings->push_back(
        {"outliers",
         fmt::format("{}; without them {}; `outliers: \"reject\"` takes them out as holes", found, effect)});
    return;
  }
  warnings->push_back({"outliers-rejected", fmt::format("{} and are taken out as holes: {}", found, effect)});
  *data = std::move(clean);
}

// Peak to valley; negative where nothing is valid.
template <class Values>
double span(const Values& z) {
  return z.isFinite().select(z, -kInfinity).maxCoeff() - z.isFinite().select(z, kInfinity).minCoeff();
}

// What spans more of a length than a mirror's heights do; empty where nothing does.
std::string too_high(double height, double length, const char* of) {
  if (!(length > 0 && height > kHighest * length)) return "";
  return fmt::format("heights without their parabola span {} of the {}", format_percent(height / length), of);
}

std::string implausible(const Profile& profile) {
  if (profile.size() == 0) return "";
  if (profile.quantity == ProfileQuantity::kSlope) {
    const double most = profile.value.isFinite().select(profile.value.abs(), 0.0).maxCoeff();
    return most > kSteepest ? fmt::format("slopes reach {}", format_quantity(most, Dimension::kAngle)) : "";
  }
  const Eigen::ArrayXd& x = profile.x;
  return too_high(span(detrend(profile, {}).value), x[x.size() - 1] - x[0], "record's length");
}

std::string implausible(const HeightMap& map) {
  const double diagonal = std::hypot(map.pitch_x * double(map.columns()), map.pitch_y * double(map.rows()));
  return too_high(span(detrend(map, {}).height), diagonal, "map's diagonal");
}

}  // namespace

Warnings screen(Measurement* data, OutlierTreatment treatment, const DetrendOptions& detrend) {
  Warnings warnings;
  std::visit(
      [&](auto& measured) {
        if (treatment != OutlierTreatment::kKeep) treat(&measured, treatment, detrend, &warnings);
        if (const std::string what = implausible(measured); !what.empty())
          warnings.push_back({"implausible-values",
                              what +
                                  ": more than a mirror has; the unit of the values or of the positions is "
                                  "probably another (`value_unit`, `x_unit`, `pitch`)"});
      },
      *data);
  return warnings;
}

}  // namespace aberfit
