#include "aberfit/study/unusual.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "aberfit/core/constants.h"
#include "aberfit/core/overloaded.h"
#include "aberfit/core/units.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "statistic_key.h"

namespace aberfit {
namespace {

// The numbers that laws join. A number that the study does not have is NaN and breaks no law.
struct Scene {
  double focal = kNaN, across = kNaN, wavelength = kNaN;           // [m]
  double departure = kNaN;                                         // slope beside the parabola's
  double rms = kNaN, slope = kNaN, lowest = kNaN, highest = kNaN;  // of one roughness [m], [1], [/m]
  double whole = kNaN;  // RMS of the sum that the roughness is part of [m]
  double jitter = kNaN, fried = kNaN, fried_wavelength = kNaN, place = kNaN;  // [rad], [m], [m], [m]
};

enum class Number {
  kFocal,
  kAcross,
  kSwap,
  kBoth,
  kWavelength,
  kDeparture,
  kRms,
  kBand,
  kJitter,
  kFried,
  kPlace
};

// A quantity and the range that includes everything that is built or measured.
struct Law {
  const char* quantity;  // text with its value
  double (*value)(const Scene&);
  double low, high;
  std::vector<Number> numbers;  // those that may be wrong if it is broken
  double common = kNaN;         // most common value; NaN if no value is much more common
};

// These are the reasons for the limits.
// f/0.25: the rim of a faster parabola is steeper than 45 degrees, and light reaches the focus from behind.
// f/5000: the mirrors of gravitational-wave detectors have f/3300, planned ones f/4400. Telescopes have f/1
// to f/50.
// 5 um: a mirror of a projector's chip. 110 m: Green Bank, the largest dish for waves below 1 cm.
// Mirrors reflect waves from 10 pm (nuclear lines) to radio; the dishes that this program covers end at 1 cm.
// 10 wavelengths: the smallest dishes; scalar theory describes no focus of a smaller one.
// 1 mrad of motion: solar dishes, which have the coarsest tracking.
// r0 at 500 nm (lambda^(6/5)): 1 mm over a hot road, 10 m at a wavelength where air hardly matters.
std::vector<Law> scene_laws() {
  return {{"an f-number of {:.4g}",
           [](const Scene& s) { return s.focal / s.across; },
           0.25,
           5000,
           {Number::kAcross, Number::kFocal, Number::kSwap},
           7},
          {"{:.4g} m across",
           [](const Scene& s) { return s.across; },
           5e-6,
           110,
           {Number::kAcross, Number::kBoth}},
          {"a wavelength of {:.3g} m",
           [](const Scene& s) { return s.wavelength; },
           1e-11,
           1e-2,
           {Number::kWavelength}},
          {"{:.3g} wavelengths across",
           [](const Scene& s) { return s.across / s.wavelength; },
           10,
           kInfinity,
           {Number::kWavelength, Number::kAcross}},
          {"a motion of the image by {:.3g} rad",
           [](const Scene& s) { return s.jitter; },
           0,
           1e-3,
           {Number::kJitter}},
          {"an r0 of {:.3g} m at 500 nm",
           [](const Scene& s) { return s.fried * std::pow(500e-9 / s.fried_wavelength, 1.2); },
           1e-3,
           10,
           {Number::kFried}}};
}

// This slope comes from the conic, the even powers and the known Zernikes; a sphere of f/0.5 has 0.08.
std::vector<Law> shape_laws() {
  return {{"a slope of {:.3g} in addition to the parabola's at the rim",
           [](const Scene& s) { return s.departure; },
           0,
           0.1,
           {Number::kDeparture}}};
}

// 2.5e-5 wavelengths scatter 1e-7 of the light, (4 pi rms/lambda)^2. A smaller fraction is lost in the
// scatter of air.
// 100 wavelengths: the dishes of Cherenkov telescopes, the roughest mirrors for visible light, have 20.
// A slope of 0.1 spreads the light over a fifth of the focal length, and the first order in it errs by 5 %.
// One cycle across: slower roughness only tilts and bends the mirror. One cycle in a wavelength: faster
// roughness does not scatter.
std::vector<Law> roughness_laws() {
  return {{"an RMS height of {:.3g} wavelengths",
           [](const Scene& s) { return s.rms / s.wavelength; },
           0,
           100,
           {Number::kRms, Number::kWavelength}},
          {"an RMS height of {:.3g} wavelengths",
           [](const Scene& s) { return s.whole / s.wavelength; },
           2.5e-5,
           kInfinity,
           {Number::kRms, Number::kWavelength}},
          {"an RMS slope of {:.3g} per axis",
           [](const Scene& s) { return s.slope; },
           0,
           0.1,
           {Number::kRms, Number::kBand}},
          {"{:.3g} cycles across at the highest frequency",
           [](const Scene& s) { return s.highest * s.across; },
           1,
           kInfinity,
           {Number::kBand, Number::kAcross}},
          {"{:.3g} cycles in a wavelength at the lowest frequency",
           [](const Scene& s) { return s.lowest * s.wavelength; },
           0,
           1,
           {Number::kBand, Number::kWavelength}}};
}

// A length in the focus: a slope of 0.05 moves a ray by a tenth of the focal length.
// A plane out of focus: half-way to the mirror the beam is half as wide as the mirror.
std::vector<Law> place_laws(double farthest) {
  return {{"{:.3g} times the focal length",
           [](const Scene& s) { return std::abs(s.place) / s.focal; },
           0,
           farthest,
           {Number::kPlace}}};
}
constexpr double kFarthestPlace = 0.1, kFarthestPlane = 0.5;

bool is_broken(const Law& law, const Scene& scene) {
  constexpr double kRounding = 1e-9;
  const double value = law.value(scene);
  return value < law.low * (1 - kRounding) || value > law.high * (1 + kRounding);
}
long broken(const std::vector<Law>& laws, const Scene& scene) {
  return std::count_if(laws.begin(), laws.end(), [&](const Law& law) { return is_broken(law, scene); });
}

// The scene with one number `factor` times as large.
Scene with(Scene scene, Number number, double factor) {
  switch (number) {
    case Number::kFocal:
      scene.focal *= factor;
      break;
    case Number::kAcross:
      scene.across *= factor;
      break;
    case Number::kSwap:
      std::swap(scene.focal, scene.across);
      break;
    case Number::kBoth:
      scene.focal *= factor, scene.across *= factor;
      break;
    case Number::kWavelength:
      scene.wavelength *= factor;
      break;
    case Number::kDeparture:
      scene.departure *= factor;
      break;
    case Number::kRms:
      scene.rms *= factor, scene.slope *= factor, scene.whole *= factor;
      break;
    case Number::kBand:
      scene.lowest *= factor, scene.highest *= factor, scene.slope *= factor;
      break;
    case Number::kJitter:
      scene.jitter *= factor;
      break;
    case Number::kFried:
      scene.fried *= factor;
      break;
    case Number::kPlace:
      scene.place *= factor;
      break;
  }
  return scene;
}

// The place of a number in the study, and its name there.
struct Place {
  Number number;
  std::string name, pointer;
  double value = kNaN;
  Dimension dimension = Dimension::kLength;
  double power = 1;  // `value` changes by factor^power if the scene's number changes by `factor`
};

constexpr double kArcsecond = kPi / 180 / 3600;  // [rad]

struct Slip {
  Number number;
  double factor;
  long left = 0;  // laws still broken once it is undone
};

// Factors between the unit meant and metres, the unit of plain numbers; for angles, between arcseconds and
// radians.
std::span<const double> factors_of(Number number) {
  static constexpr double kOfLengths[] = {1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9}, kOfAngles[] = {kArcsecond};
  static constexpr double kOfSwap[] = {1};
  if (number == Number::kSwap) return kOfSwap;
  return number == Number::kJitter ? std::span<const double>(kOfAngles) : kOfLengths;
}

// The slips that explain why `law` is broken and that leave the fewest other laws broken.
std::vector<Slip> slips(const std::vector<Law>& laws, const Law& law, const Scene& scene) {
  std::vector<Slip> found;
  for (const Number number : law.numbers) {
    std::optional<Slip> best;  // best for this number; of two equally good ones the smaller change
    for (const double factor : factors_of(number)) {
      const Scene then = with(scene, number, factor);
      const Slip slip{number, factor, broken(laws, then)};
      if (!is_broken(law, then) && (!best || slip.left < best->left)) best = slip;
    }
    if (best) found.push_back(*best);
  }
  const auto fewest = std::min_element(found.begin(), found.end(),
                                       [](const Slip& a, const Slip& b) { return a.left < b.left; });
  if (fewest == found.end()) return found;
  const long left = fewest->left, before = broken(laws, scene);
  std::erase_if(found, [&](const Slip& slip) { return slip.left > left || slip.left >= before; });
  if (std::isnan(law.common)) return found;
  constexpr double kAsLikely = 1;  // decades farther from the common value than the best slip
  const auto distance = [&](const Slip& slip) {
    return std::abs(std::log10(law.value(with(scene, slip.number, slip.factor)) / law.common));
  };
  double best = kInfinity;
  for (const Slip& slip : found) best = std::min(best, distance(slip));
  std::erase_if(found, [&](const Slip& slip) { return distance(slip) > best + kAsLikely; });
  // Both a long focus with a small mirror and the reverse may remain; the more common size of mirror comes
  // first.
  const auto size = [&](const Slip& slip) {
    constexpr double kCommonSize = 0.3;
    return std::abs(std::log10(with(scene, slip.number, slip.factor).across / kCommonSize));
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const Slip& a, const Slip& b) { return size(a) < size(b); });
  return found;
}

std::string range_text(const Law& law) {
  if (law.low == 0) return fmt::format("up to {:.4g}", law.high);
  return std::isinf(law.high) ? fmt::format("{:.4g} and more", law.low)
                              : fmt::format("{:.4g} to {:.4g}", law.low, law.high);
}

const Place& place_of(const std::vector<Place>& places, Number number) {
  if (number == Number::kSwap) number = Number::kFocal;
  if (number == Number::kBoth) number = Number::kAcross;
  return *std::find_if(places.begin(), places.end(),
                       [&](const Place& place) { return place.number == number; });
}

std::string quantity_text(const Law& law, const Scene& scene) {
  return fmt::format(fmt::runtime(law.quantity), law.value(scene));
}

std::string meant_by(const std::vector<Slip>& found, const Law& law, const Scene& scene,
                     const std::vector<Place>& places) {
  if (found.empty()) return "Check the number and its unit.";
  std::string units, then;
  bool swapped = false;
  const auto named = [](const Place& place, double factor) {
    const std::string value =
        factor == kArcsecond ? fmt::format("{:.4g} arcsec", place.value)
                             : format_quantity(place.value * std::pow(factor, place.power), place.dimension);
    return fmt::format("{} {}", place.name, value);
  };
  for (const Slip& slip : found) {
    std::string one = named(place_of(places, slip.number), slip.factor);
    if (slip.number == Number::kBoth) one += " and " + named(place_of(places, Number::kFocal), slip.factor);
    swapped = swapped || slip.number == Number::kSwap;
    if (slip.number != Number::kSwap) units += (units.empty() ? "" : " or ") + one;
    const std::string here = fmt::format("{:.3g}", law.value(with(scene, slip.number, slip.factor)));
    if (then.find(here) == std::string::npos) then += (then.empty() ? "" : " or ") + here;
  }
  const char* const kSwapped = "re focal length and diameter interchanged";
  const std::string question = units.empty() ? fmt::format("A{}", kSwapped)
                               : swapped     ? fmt::format("Is {} meant, or a{}", units, kSwapped)
                                             : fmt::format("Is {} meant", units);
  return fmt::format("{}? Then it is {}.", question, then);
}

// Reports the broken laws and corrects `scene` to the values probably meant, so that one slip is reported
// once. others: laws that are not reported, but that no slip may break.
void explain(std::vector<Law> laws, const std::vector<Law>& others, const std::vector<Place>& places,
             Scene* scene, std::vector<UnusualNumber>* unusual) {
  while (true) {
    const auto law =
        std::find_if(laws.begin(), laws.end(), [&](const Law& one) { return is_broken(one, *scene); });
    if (law == laws.end()) return;
    std::vector<Law> all = laws;
    all.insert(all.end(), others.begin(), others.end());
    std::vector<Slip> found = slips(all, *law, *scene);
    const Place& place = place_of(places, found.empty() ? law->numbers.front() : found.front().number);
    if (place.dimension == Dimension::kNumber) found.clear();  // it has no unit
    unusual->push_back({place.pointer, format_quantity(place.value, place.dimension),
                        quantity_text(*law, *scene), range_text(*law), meant_by(found, *law, *scene, places),
                        law->value(*scene) < law->low});
    if (!found.empty()) *scene = with(*scene, found.front().number, found.front().factor);
    laws.erase(law);
  }
}

Place place_of_aperture(const Aperture& aperture) {
  Place place{Number::kAcross, "a diameter of", "/aperture/diameter", 2 * aperture_radius(aperture)};
  if (const auto* rectangle = std::get_if<RectangleAperture>(&aperture)) {
    const bool wide = rectangle->width >= rectangle->height;
    place.name = wide ? "a width of" : "a height of";
    place.pointer = wide ? "/aperture/width" : "/aperture/height";
    place.value = std::max(rectangle->width, rectangle->height);
  }
  if (std::holds_alternative<PolygonAperture>(aperture))
    place.name = "a size of", place.pointer = "/aperture/vertices";
  if (std::holds_alternative<SegmentedAperture>(aperture))
    place.name = "a size of", place.pointer = "/aperture";
  return place;
}

// The term that adds most to the slope of the rim beside the parabola's; `slope` becomes the sum of all
// sizes. If a slip changes the size of the mirror, the disc of its Zernikes changes with it.
Place steepest_departure(const Mirror& mirror, double radius, double* slope) {
  Place steepest{Number::kDeparture, "a height of", "/mirror/conic", mirror.conic, Dimension::kNumber};
  const double curvature = 0.5 / mirror.focal_length;
  const double root = std::sqrt(1 - (1 + mirror.conic) * std::pow(curvature * radius, 2));
  double most = std::abs(curvature * radius / root - curvature * radius);
  *slope = most;
  const auto add = [&](double size, const std::string& pointer, double value, Dimension dimension) {
    *slope += std::abs(size);
    if (!(std::abs(size) > most)) return;
    most = std::abs(size);
    steepest.pointer = pointer, steepest.value = value, steepest.dimension = dimension;
  };
  for (std::size_t k = 0; k < mirror.spherical.size(); ++k) {
    const int power = 2 * int(k) + 4;
    add(power * mirror.spherical[k] * std::pow(radius, power - 1),
        fmt::format("/mirror/spherical/c{}", power), mirror.spherical[k], Dimension::kNumber);
  }
  for (const KnownZernike& term : mirror.zernike) {
    // At the rim of its disc, d/d rho of a Zernike is its norm times (n (n + 2) - m^2)/2.
    const int n = term.mode.n, m = term.mode.m;
    const double at_rim = std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1)) * 0.5 * (n * (n + 2) - m * m);
    add(term.height / mirror.zernike_radius * at_rim,
        fmt::format("/mirror/zernike/noll/{}", noll_index(term.mode)), term.height, Dimension::kLength);
  }
  return steepest;
}

// Height and band of a closed model as a study has them. Without a highest frequency a length ends the band.
void add_keys_of(PsdModel model, const std::string& pointer, std::vector<Place>* places) {
  const std::vector<PsdMember> members = psd_members(model);
  const bool ends = std::any_of(members.begin(), members.end(), [](const PsdMember& member) {
    return member.role == PsdRole::kHighest && std::isfinite(member.values[0]);
  });
  for (const auto& [name, role, values] : members) {
    if (values.empty()) continue;
    const std::string key = pointer + "/" + name;
    if (role == PsdRole::kRms) places->push_back({Number::kRms, "an RMS height of", key, values[0]});
    if (role == PsdRole::kHighest && ends)
      places->push_back(
          {Number::kBand, "a highest frequency of", key, values[0], Dimension::kSpatialFrequency, 1});
    if (role == PsdRole::kLength && !ends)
      places->push_back({Number::kBand, "a length of", key, values[0], Dimension::kLength, -1});
  }
}

// Weight of a surface in the path: size of its beam over the pupil, and its heights over those of a mirror.
struct InPath {
  double footprint, height;
  double whole = 0;  // RMS height of the sum that a roughness is part of [m]
};

// `scene` has no roughness; `of_scene` holds the places of its numbers.
void look_at_roughness(const RoughnessModel& node, const std::string& pointer, InPath path,
                       const Scene& scene, const std::vector<Place>& of_scene,
                       std::vector<UnusualNumber>* unusual) {
  if (const auto* sum = std::get_if<RoughnessSum>(&node.model)) {
    if (path.whole == 0) path.whole = psd_moments(RadialPsd(psd_model(node))).rms_height();
    for (std::size_t i = 0; i < sum->parts.size(); ++i)
      look_at_roughness(sum->parts[i], fmt::format("{}/parts/{}", pointer, i), path, scene, of_scene,
                        unusual);
    return;
  }
  const RadialPsd psd(psd_model(node));
  const PsdMoments moments = psd_moments(psd);
  Scene here = scene;
  if (!std::isfinite(moments.height_variance)) return;  // its height is infinite: no law applies
  here.rms = path.height * moments.rms_height();
  here.whole = path.height * std::max(path.whole, moments.rms_height());
  here.slope = path.height * moments.rms_slope_per_axis();
  here.lowest = psd.f_min(), here.highest = psd.f_max(), here.across *= path.footprint;
  // exp(-(pi l f)^2), which ends nowhere and falls faster than powers, has fallen to 2 % where f = 2/(pi l).
  if (std::isinf(psd.f_max()) && psd.high_frequency_terms().empty())
    here.highest = 2 * psd.breakpoints().back();
  std::vector<Place> places;
  std::visit(Overloaded{[](const PsdTableFile&) {}, [](const MeasuredPsd&) {}, [](const RoughnessSum&) {},
                        [&](const auto& closed) { add_keys_of(closed, pointer, &places); }},
             node.model);
  places.push_back({Number::kRms, "an RMS height of", pointer, moments.rms_height()});
  places.push_back(
      {Number::kBand, "a highest frequency of", pointer, psd.f_max(), Dimension::kSpatialFrequency});
  places.insert(places.end(), of_scene.begin(), of_scene.end());
  explain(roughness_laws(), scene_laws(), places, &here, unusual);
}

// Lengths in the focus that the study asks for or limits.
std::vector<Place> places_in_focus(const Study& study) {
  std::vector<Place> places;
  const auto add = [&](const std::string& pointer, double value, Dimension dimension = Dimension::kLength) {
    places.push_back({Number::kPlace, dimension == Dimension::kAngle ? "an angle of" : "a length of", pointer,
                      value, dimension});
  };
  const std::vector<std::string> keys = internal::keys_of(study.target.statistics);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const StatisticRequest& request = study.target.statistics[i];
    const std::string pointer = "/target/statistics/" + keys[i];
    if (const auto* ring = std::get_if<double>(&request.ring)) add(pointer + "/ring", *ring);
    if (request.name == "ring_profile") continue;
    const StatisticKind& kind = kind_of_key(request.name);
    const StudyOption& option = option_of_key(request.name);
    const bool in_a_plane = kind.plane == FocalPlane::kFocus || kind.plane == FocalPlane::kGiven;
    if (request.value && in_a_plane && kind.dimension == Dimension::kLength)
      add(pointer + "/value", *request.value);
    for (std::size_t k = 0; k < request.places.size() && option.dimension == Dimension::kLength; ++k)
      add(fmt::format("{}/{}/{}", pointer, option.key, k), request.places[k]);
  }
  if (!study.solve) return places;
  for (const Budget& budget : study.solve->budgets) {
    const bool in_focus = !budget.of_surface && !budget.in_wavelengths &&
                          (budget.of_light || !std::holds_alternative<RmsHeight>(budget.statistic));
    if (in_focus && (budget.dimension == Dimension::kLength || budget.dimension == Dimension::kAngle))
      add("/solve/so_that/" + budget.key, budget.limit, budget.dimension);
  }
  return places;
}

// Planes that statistics are asked for in.
std::vector<Place> planes_of(const Study& study) {
  std::vector<Place> planes;
  const std::vector<std::string> keys = internal::keys_of(study.target.statistics);
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (std::size_t k = 0; k < study.target.statistics[i].planes.size(); ++k)
      planes.push_back({Number::kPlace, "a plane at",
                        fmt::format("/target/statistics/{}/planes/{}", keys[i], k),
                        study.target.statistics[i].planes[k]});
  return planes;
}

}  // namespace

std::vector<UnusualNumber> unusual_numbers(const Study& study) {
  std::vector<UnusualNumber> unusual;
  const auto given = [](double value) { return value > 0 ? value : kNaN; };  // a program's study may lack it
  Scene scene;
  scene.focal = given(study.mirror.focal_length), scene.wavelength = given(study.wavelength);
  scene.across = given(2 * aperture_radius(study.aperture));
  std::vector<Place> places = {
      place_of_aperture(study.aperture),
      {Number::kFocal, "a focal length of", "/mirror/focal_length", scene.focal},
      {Number::kWavelength, "a wavelength of", "/light/wavelength", scene.wavelength}};
  const auto* with = study.solve && study.solve->with ? &*study.solve->with : nullptr;
  if (with) {
    scene.jitter = with->jitter;
    places.push_back({Number::kJitter, "a jitter of", "/solve/with/jitter", with->jitter, Dimension::kAngle});
  }
  if (with && with->atmosphere) {
    scene.fried = with->atmosphere->r0, scene.fried_wavelength = with->atmosphere->wavelength;
    places.push_back({Number::kFried, "an r0 of", "/solve/with/atmosphere/r0", scene.fried});
  }
  explain(scene_laws(), {}, places, &scene, &unusual);
  Mirror meant = study.mirror;
  meant.focal_length = scene.focal;
  meant.zernike_radius *= 0.5 * scene.across / aperture_radius(study.aperture);
  const Place shape = steepest_departure(meant, 0.5 * scene.across, &scene.departure);
  explain(shape_laws(), {}, {shape}, &scene, &unusual);
  if (study.roughness) look_at_roughness(*study.roughness, "/roughness/psd", {1, 1}, scene, places, &unusual);
  for (std::size_t k = 0; with && k < with->surfaces.size(); ++k) {
    const OtherSurfaceSpec& surface = with->surfaces[k];
    look_at_roughness(surface.psd, fmt::format("/solve/with/surfaces/{}/psd", k),
                      {surface.footprint, surface.is_wavefront ? 0.5 : 1.0}, scene, places, &unusual);
  }
  const auto look_at_place = [&](const Place& place, double farthest) {
    Scene here = scene;
    here.place = place.dimension == Dimension::kAngle ? place.value * scene.focal : place.value;
    explain(place_laws(farthest), {}, {place}, &here, &unusual);
  };
  for (const Place& place : places_in_focus(study)) look_at_place(place, kFarthestPlace);
  for (const Place& plane : planes_of(study)) look_at_place(plane, kFarthestPlane);
  return unusual;
}

Warnings unusual_warnings(const Study& study) {
  Warnings warnings;
  for (const UnusualNumber& number : unusual_numbers(study))
    warnings.push_back({kUnusual, fmt::format("{} is {}: {}; {} is usual. {}", number.pointer, number.value,
                                              number.quantity, number.ordinary, number.meant)});
  return warnings;
}

}  // namespace aberfit
