#include "convolved_forward.h"

#include <fmt/format.h>

#include <cmath>

#include "smallest_radius.h"

namespace aberfit {
namespace {

bool is_geometric(const Statistic& statistic) {
  return std::holds_alternative<ScatterRms>(statistic) || std::holds_alternative<ScatterMean>(statistic) ||
         std::holds_alternative<RmsHeight>(statistic) || std::holds_alternative<SpotFwhm>(statistic);
}

Warning missing(const Statistic& statistic) {
  if (std::holds_alternative<RmsRadius>(statistic))
    return {"rms-radius-of-waves",
            statistic_name(statistic) +
                " does not exist for a diffracted spot: a sharp edge scatters light as "
                "1/r^3, whose second moment diverges"};
  if (is_geometric(statistic))
    return {"statistic-missing",
            statistic_name(statistic) + " has no derivative where the surface does not move a ray"};
  return {
      "statistic-missing",
      statistic_name(statistic) +
          " does not exist: the spot reaches beyond 300 Airy radii, or the light inside the ring does not "
          "fall to half on both sides of the focus"};
}

}  // namespace

ConvolvedForward::ConvolvedForward(const FocusScene& scene, const std::vector<Statistic>& statistics,
                                   int threads)
    : threads_(threads),
      split_(statistics, is_geometric),
      rays_(scene, split_.geometric, threads),
      pattern_(*scene.aperture, scene.mirror.focal_length, scene.wavelength),
      wavelength_(scene.wavelength),
      unit_(scene.wavelength * scene.mirror.focal_length / (2 * aperture_radius(*scene.aperture))) {}

bool ConvolvedForward::evaluate(double width, Eigen::VectorXd* values) {
  values->setConstant(Eigen::Index(split_.own.size() + split_.geometric.size()), std::nan(""));
  bool exist = true;
  Eigen::VectorXd some;
  if (!split_.geometric.empty()) {
    exist = rays_.evaluate(width, &some);
    for (std::size_t j = 0; j < split_.geometric.size(); ++j)
      (*values)[Eigen::Index(split_.geometric_place[j])] = some[Eigen::Index(j)];
  }
  if (!split_.own.empty()) {
    if (!evaluate_convolved(pattern_, rays_.rays(), split_.own, threads_, &some, nullptr)) exist = false;
    for (std::size_t j = 0; j < split_.own.size(); ++j)
      (*values)[Eigen::Index(split_.own_place[j])] = some[Eigen::Index(j)];
  }
  trouble_.clear();
  for (std::size_t j = 0; !exist && j < split_.own.size(); ++j)
    if (trouble_.empty() && !std::isfinite((*values)[Eigen::Index(split_.own_place[j])]))
      trouble_ = missing(split_.own[j]).message;
  for (std::size_t j = 0; !exist && j < split_.geometric.size(); ++j)
    if (trouble_.empty() && !std::isfinite((*values)[Eigen::Index(split_.geometric_place[j])]))
      trouble_ = missing(split_.geometric[j]).message;
  return exist;
}

bool ConvolvedForward::gradients(const GradientSink& sink) {
  if (!split_.geometric.empty() && !rays_.gradients([&](std::size_t j, const Eigen::VectorXd& gradient) {
        sink(split_.geometric_place[j], gradient);
      }))
    return false;
  if (split_.own.empty()) return true;
  Eigen::VectorXd values;
  std::vector<RayGradient> gradients;
  if (!evaluate_convolved(pattern_, rays_.rays(), split_.own, threads_, &values, &gradients)) return false;
  std::vector<const RayGradient*> all;
  for (const RayGradient& gradient : gradients) all.push_back(&gradient);
  rays_.pull_back(
      all, [&](std::size_t j, const Eigen::VectorXd& gradient) { sink(split_.own_place[j], gradient); });
  return true;
}

Eigen::VectorXd ConvolvedForward::exact(Warnings* warnings) {
  Eigen::VectorXd values(Eigen::Index(split_.own.size() + split_.geometric.size()));
  Eigen::VectorXd some = rays_.exact(warnings);
  for (std::size_t j = 0; j < split_.geometric.size(); ++j)
    values[Eigen::Index(split_.geometric_place[j])] = some[Eigen::Index(j)];
  if (!split_.own.empty()) evaluate_convolved(pattern_, rays_.rays(), split_.own, threads_, &some, nullptr);
  std::vector<std::string> rough;
  for (std::size_t j = 0; j < split_.own.size(); ++j) {
    values[Eigen::Index(split_.own_place[j])] = some[Eigen::Index(j)];
    if (warnings && !std::isfinite(some[Eigen::Index(j)])) warnings->push_back(missing(split_.own[j]));
    if (rough_defocus(split_.own[j], some[Eigen::Index(j)])) rough.push_back(statistic_name(split_.own[j]));
  }
  if (warnings && !rough.empty())
    warnings->push_back(
        {"convolved-defocus",
         fmt::format("{}{} of spots of few Airy radii out of focus, where rays spread by the focal pattern "
                     "miss encircled energies by 1 to 10 %; waves do not",
                     rough.front(),
                     rough.size() == 1 ? " is" : fmt::format(" and {} more are", rough.size() - 1))});
  return values;
}

// Where the header of ConvolvedPlane finds errors of 1 % and more.
bool ConvolvedForward::rough_defocus(const Statistic& statistic, double value) const {
  constexpr double kFewPatterns = 10, kDepthsOfFocus = 2;
  const auto* radius = std::get_if<EncircledEnergyRadius>(&statistic);
  return radius && value < kFewPatterns * unit_ &&
         std::abs(radius->dz) > kDepthsOfFocus * unit_ * unit_ / wavelength_;
}

std::string ConvolvedForward::unreachable(const std::vector<Target>& targets) const {
  // One ray to the focus: the pattern itself.
  RayBundle point;
  for (Eigen::ArrayXd* component : {&point.x, &point.y, &point.tx, &point.ty}) component->setZero(1);
  point.weight.setOnes(1);
  const ConvolvedPlane perfect(pattern_, point, 0.0);
  for (const Target& target : targets)
    if (const auto* s = std::get_if<EncircledEnergyRadius>(&target.statistic))
      if (const auto radius = perfect.radius(s->fraction))
        if (std::string why = below_diffraction(target, *radius); !why.empty()) return why;
  return {};
}

}  // namespace aberfit
