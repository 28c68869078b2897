#include "study_rules.h"

#include <fmt/format.h>

#include <cmath>

#include "aberfit/core/errors.h"
#include "aberfit/core/units.h"
#include "statistic_key.h"

namespace aberfit::internal {
namespace {

constexpr double kSameLength = 1e-9;  // rounding of a computed length in a file

// The reader has already refused a file without these values, but a program may have forgotten them.
void check_required(const Study& study) {
  const auto require = [&](double length, const char* pointer, const char* what) {
    if (!(length > 0))
      throw InputError(study.path, pointer, format_quantity(length, Dimension::kLength), what);
  };
  require(study.mirror.focal_length, "/mirror/focal_length", "a focal length above 0");
  require(aperture_radius(study.aperture), "/aperture", "an aperture with an area");
  require(study.wavelength, "/light/wavelength", "a wavelength above 0");
}

void check_aperture(const Study& study) {
  const double radius = aperture_radius(study.aperture), domain = sag_domain_radius(study.mirror);
  if (!study.mirror.zernike.empty() && study.mirror.zernike_radius < radius * (1 - kSameLength))
    throw InputError(study.path, "/mirror/zernike/radius",
                     format_quantity(study.mirror.zernike_radius, Dimension::kLength),
                     fmt::format("at least {}, the largest distance of the aperture from the axis, because "
                                 "outside their disc Zernikes grow without bound",
                                 format_quantity(radius, Dimension::kLength)));
  if (radius < domain) return;
  static const char* const kSizes[] = {"diameter", "diameter", "", "vertices", ""};
  const std::string key = kSizes[study.aperture.index()];
  throw InputError(
      study.path, key.empty() ? "/aperture" : "/aperture/" + key,
      fmt::format("an aperture that reaches {} from the axis", format_quantity(radius, Dimension::kLength)),
      fmt::format("less than {}, where the sag of this mirror (conic {}) ends",
                  format_quantity(domain, Dimension::kLength), study.mirror.conic));
}

void check_psd(const Study& study, const PsdModel& model, const std::string& pointer) {
  if (const auto* sum = std::get_if<SumPsd>(&model))
    for (std::size_t i = 0; i < sum->parts.size(); ++i)
      check_psd(study, sum->parts[i], fmt::format("{}/parts/{}", pointer, i));
  const std::string problem = psd_problem(model);
  if (!problem.empty()) throw InputError(study.path, pointer, problem, "a PSD with finite height variance");
  const PsdMoments moments = psd_moments(RadialPsd(model));
  // Budgets concern only the light, and for that the structure function is enough.
  if (!std::isfinite(moments.height_variance) && !study.solve)
    throw InputError(
        study.path, pointer, "a PSD whose height variance is infinite",
        "a band or exponent that keeps it finite, such as an f_min of a tenth of a cycle across, or a "
        "k-correlation whose B is the outer scale (only budgets of `solve` do not need it)");
  if (!std::isfinite(moments.slope_variance))
    throw InputError(study.path, pointer, "a PSD whose slope variance is infinite",
                     "f_max, or a 2-D exponent above 4, because rays need a finite RMS slope");
}

// Without a PSD we cannot predict targets, realisations or orders of terms.
void check_without_roughness(const Study& study) {
  const auto fail = [&](const std::string& pointer, const std::string& found, const std::string& allowed) {
    throw InputError(study.path, pointer, found, allowed + ", because the study has no roughness");
  };
  if (study.target.statistics.empty())
    throw InputError(study.path, "/roughness", kMissing,
                     "a study needs \"roughness\": {\"psd\": {\"model\": \"uniform\", \"rms\": \"20 nm\", "
                     "\"f_min\": \"2.5 /m\", \"f_max\": \"40 /m\"}}, or a value for every statistic");
  const std::vector<std::string> keys = keys_of(study.target.statistics);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const StatisticRequest& request = study.target.statistics[i];
    if (request.name == "ring_profile") {
      if (std::holds_alternative<std::string>(request.ring))
        fail("/target/statistics/ring_profile/ring", '"' + std::get<std::string>(request.ring) + '"',
             "a length such as \"76 um\"");
      continue;
    }
    if (request.value) continue;
    fail("/target/statistics/" + keys[i] + "/value", kMissing,
         "the statistic needs its value, such as \"76 um\"");
  }
  if (study.fit.prior != PriorMode::kZeroMean) fail("/fit/prior", "\"near-start\"", "\"zero-mean\"");
  if (study.terms.fourier) fail("/terms/fourier", "plane waves", "zernike with n_max, or spherical");
  if (const auto zernikes = study.terms.zernikes(); zernikes && !zernikes->n_max)
    fail("/terms/zernike/n_max", kMissing,
         "terms/zernike needs the highest radial order, such as \"n_max\": 20");
}

// These problems are known before the fit, so we report them before it.
void check_exports(const Study& study) {
  constexpr int kListedOrder = 20;  // highest order of OpticStudio's Zernike surfaces: 231 terms
  const auto& zernike = study.terms.zernike;
  for (std::size_t i = 0; i < study.output.exports.size(); ++i) {
    const ExportFormat format = study.output.exports[i];
    const bool noll = format == ExportFormat::kZernikeNoll, fringe = format == ExportFormat::kCodeVZfr;
    const auto fail = [&](const std::string& why) {
      throw InputError(study.path, "/output/export/" + std::to_string(i),
                       '"' + export_names()[std::size_t(format)] + "\" " + why,
                       "a map instead (zemax-grid-sag, codev-int, fits-opd, csv)");
    };
    if ((noll || fringe) && study.terms.fourier)
      fail("with Fourier terms, which a Zernike listing cannot hold");
    if (noll && zernike && zernike->n_max.value_or(0) > kListedOrder)
      fail("with n_max above 20, where its listing ends");
  }
}

// The place where a ring or a line spread is widest depends on the wavelength.
void check_band(const Study& study) {
  const std::vector<std::string> keys = keys_of(study.target.statistics);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string& name = study.target.statistics[i].name;
    if (study.wavelength.is_band() &&
        (name == "ring_profile" || kind_of_key(name).measure == Measure::kHalfWidth))
      throw InputError(study.path, "/target/statistics/" + keys[i], "\"" + name + "\" in a band of light",
                       "encircled energies, which add over wavelengths; or light of one wavelength");
  }
}

}  // namespace

void check_rules(const Study& study) {
  check_required(study);
  check_aperture(study);
  check_exports(study);
  check_band(study);
  if (study.trace.pupil.layout == PupilLayout::kPolar && usual_layout(study.aperture) != PupilLayout::kPolar)
    throw InputError(study.path, "/trace/pupil", "\"polar\"",
                     "\"random\", \"sobol\" or \"grid\", because the polar layout is for circles and annuli");
  if (study.solve && study.solve->with)
    for (std::size_t k = 0; k < study.solve->with->surfaces.size(); ++k)
      check_psd(study, psd_model(study.solve->with->surfaces[k].psd),
                fmt::format("/solve/with/surfaces/{}/psd", k));
  if (study.psd)
    check_psd(study, *study.psd, "/roughness/psd");
  else if (!study.map && !(study.solve && study.solve->ceilings))  // which need none
    check_without_roughness(study);
}

}  // namespace aberfit::internal
