#include "aberfit/method/specified_light.h"

#include <fmt/format.h>

#include "aberfit/theory/light_property.h"

namespace aberfit {
namespace {

// radius: a function of the energy fraction.
template <class Radius>
void add_diameters(const Radius& radius, SpecifiedLight* light) {
  for (const double share : {0.5, 0.8, 0.9})
    light->values.push_back({fmt::format("ee{:g}_diameter", 100 * share), 2 * radius(share), true});
  light->values.push_back({"hew", light->values.front().value, true});
}

// Strehl ratio and PSSN refer to the parabola. The peak of a band with uneven irradiance is not known.
bool parabola_is_cheap(const GhsPupil& pupil) {
  if (pupil.light().is_band() && pupil.has_uneven_light()) return false;
  return is_parabola(pupil.mirror()) || std::holds_alternative<CircleAperture>(pupil.aperture()) ||
         std::holds_alternative<AnnulusAperture>(pupil.aperture());
}

void add_light(const GeneralisedHarveyShack& mean, SpecifiedLight* light) {
  std::vector<LightProperty> wanted{IrradianceFwhm{}, EnsquaredSide{0.8}, TotalScatter{}};
  std::vector<SpecifiedValue> values{{"fwhm", 0, true}, {"ensquared80_side", 0, true}, {"tis", 0, false}};
  if (parabola_is_cheap(mean.pupil())) {
    wanted.insert(wanted.end(), {StrehlRatio{}, PointSourceSensitivity{0.15}});
    values.insert(values.end(), {{"strehl", 0, false}, {"pssn@0.15m", 0, false}});
  }
  const Eigen::VectorXd found = LightProperties(wanted, mean.pupil())(mean);
  for (std::size_t k = 0; k < values.size(); ++k) values[k].value = found[Eigen::Index(k)];
  light->values.insert(light->values.end(), values.begin(), values.end());
}

}  // namespace

SpecifiedLight specified_light(const Groundwork& ground) {
  SpecifiedLight light;
  light.focal_length = ground.focal_length;
  if (ground.specified_spot) {
    light.theory = to_string(Theory::kGhs);
    const MeanSpot focus = ground.specified_spot->at_plane(0);
    add_diameters([&](double share) { return focus.encircled_energy_radius(share); }, &light);
    add_light(*ground.specified_spot, &light);
    const GeneralisedHarveyShack& mean = *ground.specified_spot;
    for (std::size_t k = 0; k < mean.lines().size(); ++k) {
      const LightLine& line = mean.pupil().light().lines()[k];
      const MeanSpot spot = mean.lines()[k]->at_plane(0);
      light.lines.push_back({line.wavelength, line.share, 2 * spot.encircled_energy_radius(0.5),
                             2 * spot.encircled_energy_radius(0.8)});
    }
  } else if (ground.use.theory == Theory::kGeometric && ground.theory) {
    light.theory = to_string(Theory::kGeometric);
    add_diameters([&](double share) { return ground.theory->encircled_energy_radius(share, 0); }, &light);
  }
  return light;
}

}  // namespace aberfit
