#include "aberfit/study/measured_psd.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"

namespace aberfit {
namespace {

MeasuredSource source_of(const MeasuredFile& file, const std::string& path) {
  MeasuredSource source;
  source.path = path;
  source.format = file.format;
  source.column = file.column;
  if (!file.quantity.empty())
    source.quantity = file.quantity == "slope" ? ProfileQuantity::kSlope : ProfileQuantity::kHeight;
  if (!file.of.empty()) source.wavefront = file.of == "wavefront";
  const Dimension value = file.quantity == "slope" ? Dimension::kAngle : Dimension::kLength;
  if (!file.x_unit.empty()) source.x_factor = unit_factor(file.x_unit, Dimension::kLength);
  if (!file.value_unit.empty()) source.value_factor = unit_factor(file.value_unit, value);
  source.pitch = file.pitch;
  source.wavelength = file.wavelength;
  return source;
}

double largest_height(const Profile& profile) {
  const Profile heights = heights_of(profile);
  return heights.value.isFinite().select(heights.value.abs(), 0.0).maxCoeff();
}
double largest_height(const HeightMap& map) {
  return map.height.isFinite().select(map.height.abs(), 0.0).maxCoeff();
}

// What is left of a constant or a parabola after detrending is rounding, and rounding has a PSD, too.
PsdEstimate estimate(const Measurement& data, const PsdEstimatorOptions& options, int threads) {
  constexpr double kRounding = 1e-13;
  return std::visit(
      [&](const auto& measured) {
        PsdEstimate result = estimate_psd(measured, options, threads);
        if (!(result.rms_height > kRounding * largest_height(measured)))
          throw std::invalid_argument("nothing but rounding is left of the heights after detrending");
        return result;
      },
      data);
}

}  // namespace

Measurement load_measurement(const MeasuredFile& file, const std::string& folder, const std::string& where,
                             const std::string& pointer) {
  Measurement data;
  try {
    data = read_measurement(source_of(file, (std::filesystem::path(folder) / file.file).string()));
  } catch (const InputError& error) {
    throw InputError(where, pointer,
                     fmt::format("in \"{}\"{}{}: {}", file.file, error.pointer().empty() ? "" : ", ",
                                 error.pointer(), error.found()),
                     error.allowed());
  }
  if (auto* profile = std::get_if<Profile>(&data)) profile->value *= file.scale;
  if (auto* map = std::get_if<HeightMap>(&data)) map->height *= file.scale;
  return data;
}

void measure_psd(MeasuredPsd& measured, const std::string& folder, const std::string& where,
                 const std::string& pointer, int threads) {
  measured.data.clear();
  std::vector<PsdEstimate> bands;
  for (std::size_t i = 0; i <= measured.further.size(); ++i) {
    const MeasuredFile& file = i == 0 ? measured.source : measured.further[i - 1];
    const std::string key = pointer + (i == 0 ? "/file" : fmt::format("/further/{}/file", i - 1));
    measured.data.push_back(load_measurement(file, folder, where, key));
    try {
      bands.push_back(estimate(measured.data.back(), measured.estimator, threads));
    } catch (const std::invalid_argument& error) {
      throw InputError(where, key, fmt::format("\"{}\": {}", file.file, error.what()),
                       "a measurement whose PSD can be estimated");
    }
  }
  try {
    measured.estimate = bands.size() == 1 ? std::move(bands.front()) : stitch(bands);
  } catch (const std::invalid_argument& error) {
    throw InputError(where, pointer + "/further", error.what(), "measurements of one kind, profiles or maps");
  }
  measured.result = fit_psd_model(measured.estimate, measured.fit);
  if (measured.result.status == PsdFitStatus::kFailed)
    throw InputError(where, pointer + "/file",
                     fmt::format("\"{}\": {}", measured.source.file, measured.result.message),
                     "a PSD that a model fits; try another band (f_min, f_max), family or detrend");
}

}  // namespace aberfit
