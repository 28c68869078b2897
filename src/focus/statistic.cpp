#include "aberfit/focus/statistic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace aberfit {
namespace {

// At most 6 significant digits, positional (an exponent would be one more spelling of the same name), no
// trailing zeros, no -0.
std::string digits(double value) {
  const double rounded = std::stod(fmt::format("{:.5e}", value));
  if (rounded == 0.0 || !std::isfinite(rounded)) return fmt::format("{}", std::abs(rounded));
  const int decimals = std::max(0, 5 - int(std::floor(std::log10(std::abs(rounded)))));
  std::string text = fmt::format("{:.{}f}", rounded, decimals);
  if (decimals > 0) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text;
}

std::string encircled(double fraction) { return "ee" + digits(100.0 * fraction); }

std::string plane(double dz) {
  const std::string millimetres = digits(1e3 * dz);
  return millimetres == "0" ? "" : "@" + millimetres + "mm";
}

std::string ring(const RingFwhm& statistic) {
  if (statistic.ring_radius) return "@ring=" + digits(1e6 * *statistic.ring_radius) + "um";
  const std::string name = encircled(statistic.ring_fraction);
  return name == "ee90" ? "" : "@ring=" + name;
}

struct Name {
  std::string operator()(const EncircledEnergyRadius& s) const {
    return encircled(s.fraction) + "_radius_m" + plane(s.dz);
  }
  std::string operator()(const RingFwhm& s) const { return "ring_fwhm_m" + ring(s); }
  std::string operator()(const RingThrough& s) const { return "ring_through" + plane(s.dz); }
  std::string operator()(const ScatterRms&) const { return "scatter_rms_rad"; }
  std::string operator()(const ScatterMean&) const { return "scatter_mean_rad"; }
  std::string operator()(const SpotFwhm&) const { return "spot_fwhm_m"; }
  std::string operator()(const RmsRadius& s) const { return "rms_radius_m" + plane(s.dz); }
  std::string operator()(const RmsHeight&) const { return "rms_height_m"; }
};

}  // namespace

Target aim_of(const Target& target) {
  const auto* radius = std::get_if<EncircledEnergyRadius>(&target.statistic);
  if (!radius || !target.curve_slope) {
    Target aim = target;
    aim.scale = target.relative_to();
    return aim;
  }
  const double scale = std::max(*target.curve_slope, kFlattestCurve);
  Target aim;
  aim.statistic = RingThrough{target.value, radius->dz};
  aim.value = radius->fraction;
  aim.standard_error = *target.curve_slope * target.standard_error / target.value;
  aim.tolerance = scale * target.tolerance / target.value;
  aim.scale = scale;
  aim.degrees_of_freedom = target.degrees_of_freedom;
  return aim;
}

std::vector<Target> aims_of(const std::vector<Target>& targets) {
  std::vector<Target> aims;
  aims.reserve(targets.size());
  for (const Target& target : targets) aims.push_back(aim_of(target));
  return aims;
}

std::vector<Statistic> statistics_of(const std::vector<Target>& targets) {
  std::vector<Statistic> statistics;
  statistics.reserve(targets.size());
  for (const Target& target : targets) statistics.push_back(target.statistic);
  return statistics;
}

double gaussian_curve_slope(double fraction) { return -2 * (1 - fraction) * std::log1p(-fraction); }

std::string statistic_name(const Statistic& statistic) { return std::visit(Name{}, statistic); }

}  // namespace aberfit
