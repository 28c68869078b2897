#include "aberfit/study/measured_psd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <stdexcept>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "aberfit/spectrum/surface_psd.h"

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
  source.value_in_waves = is_waves(file.value_unit);
  if (!file.value_unit.empty() && !source.value_in_waves)
    source.value_factor = unit_factor(file.value_unit, value);
  source.pitch = file.pitch;
  source.columns = file.columns;
  source.bottom_first = file.first_row == "bottom";
  source.wavelength = file.wavelength;
  if (!file.hdu.empty()) source.hdu = file.hdu;
  source.plane = file.plane;
  source.invalid = file.invalid;
  return source;
}

// The option as the user writes it: --value-unit on the command line, the key "value_unit" in a study.
std::string option_name(const std::string& key, bool typed) {
  if (!typed) return "\"" + key + '"';
  std::string flag = "--" + key;
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

// Readers name options by their keys.
std::string as_given(const std::string& text, bool typed) {
  static const std::regex kOption("option '([a-z_]+)'( or '([a-z_]+)')?");
  std::string result;
  auto at = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), kOption), end; match != end; ++match) {
    result.append(at, text.cbegin() + match->position());
    result += (typed ? "option " : "key ") + option_name((*match)[1], typed);
    if ((*match)[3].matched) result += " or " + option_name((*match)[3], typed);
    at = text.cbegin() + match->position() + match->length();
  }
  return result.append(at, text.cend());
}

// Throws one message for everything that a file leaves open. choices: the alternatives, if the first fact is
// a choice.
[[noreturn]] void ask_for(const std::vector<std::string>& facts, bool typed, const std::string& where,
                          const std::string& pointer, const std::string& file,
                          const std::string& choices = "") {
  struct Fact {
    const char *key, *what, *typed, *written;
  };
  static constexpr Fact kFacts[] = {
      {"hdu", "which of its images to read", "NAME|N", "\"OPD\" or 1"},
      {"plane", "which plane of its cube to read", "K (from 1)", "1"},
      {"quantity", "whether its values are heights or slopes", "height|slope", "\"height\" or \"slope\""},
      {"of", "whether it is of the surface or of a wavefront", "surface|wavefront",
       "\"surface\" or \"wavefront\""},
      {"x_unit", "the unit of its positions", "UNIT", "\"mm\""},
      {"value_unit", "the unit of its values", "UNIT (nm, ..., or waves with --wavelength)",
       "\"nm\", or \"waves\" with \"wavelength\""},
      {"pitch", "the distance of its points", "LENGTH (e.g. \"0.1 mm\")", "\"0.1 mm\""},
      {"wavelength", "the wavelength of its waves", "LENGTH (e.g. \"632.8 nm\")", "\"632.8 nm\""}};
  std::string open, allowed;
  for (const Fact& fact : kFacts) {
    if (std::find(facts.begin(), facts.end(), fact.key) == facts.end()) continue;
    open += (open.empty() ? "" : "; ") + std::string(fact.what);
    if (fact.key == facts.front() && !choices.empty()) open += " (" + choices + ")";
    allowed += (allowed.empty() ? "" : ", ") + option_name(fact.key, typed) + (typed ? " " : ": ") +
               (typed ? fact.typed : fact.written);
  }
  if (typed) throw InputError(file, "", "a file that does not say " + open, allowed);
  throw InputError(where, pointer, fmt::format("\"{}\", which does not say {}", file, open), allowed);
}

double largest_height(const Profile& profile) {
  const Profile heights = heights_of(profile);
  return heights.value.isFinite().select(heights.value.abs(), 0.0).maxCoeff();
}
double largest_height(const HeightMap& map) {
  return map.height.isFinite().select(map.height.abs(), 0.0).maxCoeff();
}

// After detrending, only rounding is left of a constant or a parabola. Rounding has a PSD, too, so we refuse
// it.
PsdEstimate estimate(const Measurement& data, const PsdEstimatorOptions& options, int threads) {
  constexpr double kRounding = 1e-13;
  return std::visit(
      [&](const auto& measured) {
        PsdEstimate result = estimate_psd(measured, options, threads);
        if (!(result.rms_height > kRounding * largest_height(measured)))
          throw std::invalid_argument("after detrending only rounding errors of the heights are left");
        return result;
      },
      data);
}

void warn_of_missing_band(const PsdEstimate& estimate, const PsdFitOptions& asked, PsdModelFit* fit) {
  const auto frequency = [](double f) { return format_quantity(f, Dimension::kSpatialFrequency); };
  const auto warn = [&](const char* key, double wanted, double there) {
    fit->warnings.push_back(
        {"band-beyond-data", fmt::format("{} is {}, but the bins end at {}, and so do the fit and its model",
                                         key, frequency(wanted), frequency(there))});
  };
  const double low = estimate.low[0], high = estimate.high[estimate.high.size() - 1];
  if (asked.f_min > 0 && asked.f_min < low) warn("f_min", asked.f_min, low);
  if (asked.f_max > high) warn("f_max", asked.f_max, high);
}

void warn_of_bands_beyond(const PsdEstimate& estimate, const std::vector<FrequencyBand>& bands,
                          PsdModelFit* fit) {
  const SurfacePsd surface = surface_psd(estimate, *fit);
  const auto frequency = [](double f) { return format_quantity(f, Dimension::kSpatialFrequency); };
  for (const FrequencyBand& band : bands) {
    const BandContent content = band_content(surface, estimate.kind, band);
    const auto reached = [](double there, double wanted) { return std::abs(there / wanted - 1) < 1e-9; };
    if (reached(content.from, band.f_min) && reached(content.to, band.f_max)) continue;
    fit->warnings.push_back(
        {"band-beyond-data",
         fmt::format("the band {} is {} to {}, {}", band.name, frequency(band.f_min), frequency(band.f_max),
                     content.to == 0
                         ? std::string("where there is no bin, so it has no RMS")
                         : fmt::format("which has bins only from {} to {}; its RMS is that of these bins",
                                       frequency(content.from), frequency(content.to)))});
  }
}

// The fit of a steep PSD follows its many bins, but most of the RMS is in the few bins of lowest frequency.
void warn_of_other_rms(const PsdEstimate& estimate, PsdModelFit* fit) {
  if (fit->status == PsdFitStatus::kFailed) return;
  constexpr double kNoticed = 0.1;
  constexpr Eigen::Index kLowest = 3;
  const SurfacePsd surface = surface_psd(estimate, *fit);
  const auto rms = [&](bool of_model, double to) {
    return rms_in_band(surface, estimate.kind, of_model, fit->f_min, to);
  };
  const BandRms model = rms(true, fit->f_max), data = rms(false, fit->f_max);
  const double height = model.height / data.height, slope = model.slope / data.slope;
  if (!(std::abs(height - 1) > kNoticed || std::abs(slope - 1) > kNoticed)) return;
  Eigen::Index first = 0;
  while (first + kLowest < surface.psd.size() && surface.frequency[first] < fit->f_min) ++first;
  const Eigen::Index last = std::min(first + kLowest, surface.psd.size()) - 1;
  const double share = std::pow(rms(false, surface.high[last]).height / data.height, 2);
  fit->warnings.push_back(
      {"rms-not-as-measured",
       fmt::format("in its band the model has {:.2f} times the RMS height and {:.2f} times the RMS slope of "
                   "the bins. The {} lowest bins, with {:.0f} degrees of freedom in all, hold {:.0f} % of "
                   "the height variance{}. The model describes surfaces like this one; for exactly this "
                   "surface take the block with its RMS height and slope, or psd.csv as a table",
                   height, slope, last - first + 1, surface.dof.segment(first, last - first + 1).sum(),
                   100 * share, fit->model_error > 0 ? ", and the model does not describe the bins" : "")});
}

// Values of a program with the facts of the study, as if a file without facts of its own had them.
Measurement with_facts(Measurement data, const MeasuredSource& source, const std::string& name) {
  if (source.value_in_waves && !source.wavelength)
    throw InputError(name, "", "values in waves", "a wavelength of these waves, option 'wavelength'");
  auto* const profile = std::get_if<Profile>(&data);
  if (profile && source.quantity) profile->quantity = *source.quantity;
  const bool is_slope = profile && profile->quantity == ProfileQuantity::kSlope;
  const double unit = source.value_in_waves ? *source.wavelength : source.value_factor.value_or(1);
  const double factor = unit * (source.wavefront.value_or(false) && !is_slope ? 0.5 : 1.0);
  std::visit([&](auto& measured) { measured.file_unit = factor; }, data);
  if (profile) {
    profile->value *= factor;
    profile->x *= source.x_factor.value_or(1);
  } else {
    HeightMap& map = std::get<HeightMap>(data);
    map.height *= factor;
    if (source.pitch) map.pitch_x = map.pitch_y = *source.pitch;
  }
  return data;
}

}  // namespace

Measurement load_measurement(const MeasuredFile& file, const std::string& folder, const std::string& where,
                             const std::string& pointer, ClearRegion* clear) {
  const MeasuredSource source = source_of(file, (std::filesystem::path(folder) / file.file).string());
  const bool typed = where == kCommandLine;
  Measurement data;
  try {
    data = file.values ? with_facts(*file.values, source, file.file) : read_measurement(source);
  } catch (const InputError& error) {
    if (const auto* missing = dynamic_cast<const MissingFact*>(&error))
      if (const std::vector<std::string> facts = missing_facts(source); facts.size() > 1) {
        const bool choice = missing->fact() == "hdu" || missing->fact() == "plane";
        ask_for(facts, typed, where, pointer, file.file, choice ? error.found() : "");
      }
    if (typed)
      throw InputError(file.file, as_given(error.pointer(), typed), as_given(error.found(), typed),
                       as_given(error.allowed(), typed));
    throw InputError(where, pointer,
                     fmt::format("in \"{}\"{}{}: {}", file.file, error.pointer().empty() ? "" : ", ",
                                 as_given(error.pointer(), typed), as_given(error.found(), typed)),
                     as_given(error.allowed(), typed));
  }
  if (const auto* map = std::get_if<HeightMap>(&data); map && !(map->pitch_x > 0 && map->pitch_y > 0))
    ask_for({"pitch"}, typed, where, pointer, file.file);
  if (auto* map = std::get_if<HeightMap>(&data))
    for (Warning& warning : map->warnings) warning.message = as_given(warning.message, typed);
  std::optional<Eigen::Index> said;
  if (!file.invalid.empty())
    said = std::visit([](const auto& measured) { return measured.said_invalid; }, data);
  clear->said_invalid = said;
  std::visit([&](auto& measured) { measured.file_unit *= file.scale; }, data);
  if (auto* profile = std::get_if<Profile>(&data)) profile->value *= file.scale;
  if (auto* map = std::get_if<HeightMap>(&data)) map->height *= file.scale;
  if (file.clear.whole()) return data;
  const char* key = file.clear.aperture ? "aperture" : file.clear.mask.empty() ? "erode" : "mask";
  try {
    *clear = take_clear_part(&data, file.clear, (std::filesystem::path(folder) / file.clear.mask).string(),
                             source.bottom_first);
    clear->said_invalid = said;
  } catch (const std::invalid_argument& error) {
    throw InputError(where, pointer.substr(0, pointer.rfind('/') + 1) + key,
                     fmt::format("of \"{}\": {}", file.file, error.what()), "a part of the measurement");
  }
  return data;
}

void measure_psd(MeasuredPsd& measured, const std::string& folder, const std::string& where,
                 const std::string& pointer, int threads) {
  measured.data.clear(), measured.clear.clear();
  std::vector<PsdEstimate> bands;
  for (std::size_t i = 0; i <= measured.further.size(); ++i) {
    const MeasuredFile& file = i == 0 ? measured.source : measured.further[i - 1];
    const std::string key = pointer + (i == 0 ? "/file" : fmt::format("/further/{}/file", i - 1));
    measured.data.push_back(load_measurement(file, folder, where, key, &measured.clear.emplace_back()));
    try {
      const Warnings seen = screen(&measured.data.back(), measured.outliers, measured.estimator.detrend);
      bands.push_back(estimate(measured.data.back(), measured.estimator, threads));
      bands.back().warnings.insert(bands.back().warnings.begin(), seen.begin(), seen.end());
      if (const auto* map = std::get_if<HeightMap>(&measured.data.back()))
        bands.back().warnings.insert(bands.back().warnings.begin(), map->warnings.begin(),
                                     map->warnings.end());
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
  warn_of_missing_band(measured.estimate, measured.fit, &measured.result);
  warn_of_bands_beyond(measured.estimate, measured.bands, &measured.result);
  warn_of_other_rms(measured.estimate, &measured.result);
  if (measured.result.status == PsdFitStatus::kFailed)
    throw InputError(where, pointer + "/file",
                     fmt::format("\"{}\": {}", measured.source.file, measured.result.message),
                     "a PSD that a model fits; try another band (f_min, f_max), family or detrend");
}

}  // namespace aberfit
