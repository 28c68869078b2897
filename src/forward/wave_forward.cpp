#include "wave_forward.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aberfit/core/units.h"
#include "aberfit/trace/nominal_surface.h"

namespace aberfit::internal {
namespace {

constexpr double kSamePoint = 1e-6;  // in pitches
constexpr double kNarrower = 0.02;   // phases can narrow single rings of a pattern a little

// The diffraction pupil that a pupil sample was taken from: its grid tells the pitch.
DiffractionPupil pupil_of(const LightPath& path) {
  const auto refuse = [] {
    throw std::invalid_argument(
        "statistics by wave optics need the points of diffraction_pupil(aperture, pitch)");
  };
  const auto* grid = std::get_if<CartesianGrid>(&path.pupil.structure);
  if (!grid || grid->x.size() < 2) refuse();
  const double pitch = (grid->x[grid->x.size() - 1] - grid->x[0]) / double(grid->x.size() - 1);
  DiffractionPupil pupil = diffraction_pupil(*path.aperture, pitch);
  const double limit = kSamePoint * pitch;
  if (pupil.sample.size() != path.pupil.size() || !((pupil.sample.x - path.pupil.x).abs() <= limit).all() ||
      !((pupil.sample.y - path.pupil.y).abs() <= limit).all())
    refuse();
  return pupil;
}

// Why an encircled-energy radius cannot be met: it lies well below `perfect` [m], that of the perfect
// mirror's diffraction pattern in focus. Empty when it does not.
std::string below_diffraction(const Target& target, double perfect) {
  if (!(target.value + target.tolerance < (1 - kNarrower) * perfect)) return {};
  return fmt::format(
      "the target {} = {} lies below the {} of a perfect mirror: the aperture's diffraction allows no less",
      statistic_name(target.statistic), format_quantity(target.value, Dimension::kLength),
      format_quantity(perfect, Dimension::kLength));
}

}  // namespace

WaveForward::WaveForward(const LightPath& path, const std::vector<Statistic>& statistics, int threads)
    : path_(path),
      threads_(threads),
      split_(statistics, is_moment),
      diffraction_pupil_(pupil_of(path)),
      departure_(departure_from_parabola(path.mirror, diffraction_pupil_.sample,
                                         focus_operator(FocusModel::kWaves, threads))) {
  if (split_.geometric.empty()) return;
  const TermSet& terms = path.surface.terms();
  moments_ = make_moment_rays(path.mirror, *path.aperture, terms, split_.geometric, threads);
  if (!moments_)  // terms of so high an order that the cells have to do
    moments_ = std::make_unique<MomentRays>(path.mirror, path.pupil, terms,
                                            focus_operator(FocusModel::kWaves, threads), split_.geometric);
}

void WaveForward::move_to(const Eigen::VectorXd& coefficients) {
  path_.surface.apply(coefficients, &field_);
  height_ = field_.height;
  if (moments_) moments_->rays().move_to(coefficients);
  if (departure_.size() > 0) height_ += departure_;
}

bool WaveForward::evaluate(double width, Eigen::VectorXd* values) {
  values->setConstant(Eigen::Index(split_.own.size() + split_.geometric.size()), std::nan(""));
  bool exist = true;
  Eigen::VectorXd some;
  if (!split_.geometric.empty()) {
    exist = moments_->rays().evaluate(width > 0 ? width : 1, &some);  // moments: no kernel in them
    for (std::size_t j = 0; j < split_.geometric.size(); ++j)
      (*values)[Eigen::Index(split_.geometric_place[j])] = some[Eigen::Index(j)];
  }
  if (!split_.own.empty()) {
    const DiffractionProblem waves = problem();
    if (!evaluate_diffraction(waves, height_, split_.own, threads_, &workspace_, &some, nullptr))
      exist = false;
    for (std::size_t j = 0; j < split_.own.size(); ++j)
      (*values)[Eigen::Index(split_.own_place[j])] = some[Eigen::Index(j)];
  }
  trouble_.clear();
  if (!exist) {
    Warnings found;
    explain(*values, &found);
    if (!found.empty()) trouble_ = found.front().message;
  }
  return exist;
}

bool WaveForward::gradients(const GradientSink& sink) {
  if (!split_.geometric.empty() &&
      !moments_->rays().gradients(
          [&](std::size_t j, const Eigen::VectorXd& gradient) { sink(split_.geometric_place[j], gradient); }))
    return false;
  if (split_.own.empty()) return true;
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> d_height;
  const DiffractionProblem waves = problem();
  if (!evaluate_diffraction(waves, height_, split_.own, threads_, &workspace_, &values, &d_height))
    return false;
  pull_back_heights(path_.surface, &d_height, threads_, [&](std::size_t j, const Eigen::VectorXd& gradient) {
    sink(split_.own_place[j], gradient);
  });
  return true;
}

Eigen::VectorXd WaveForward::exact(Warnings* warnings) {
  Eigen::VectorXd values;
  evaluate(0, &values);
  Eigen::VectorXd geometric;
  if (moments_) geometric = moments_->rays().exact(warnings);
  for (std::size_t j = 0; j < split_.geometric.size(); ++j)
    values[Eigen::Index(split_.geometric_place[j])] = geometric[Eigen::Index(j)];
  if (warnings) explain(values, warnings);
  return values;
}

void WaveForward::explain(const Eigen::VectorXd& values, Warnings* warnings) const {
  const DiffractionProblem waves = problem();
  const DiffractionCheck check = check_diffraction(waves, height_, 0.0);
  const bool finite = height_.allFinite(), aliased = check.aliased_share > waves.aliased_limit;
  // A surface that has no pattern has none of its statistics: said once.
  std::vector<std::string> without_pattern;
  const auto lacks = [&](std::size_t place) { return !std::isfinite(values[Eigen::Index(place)]); };
  for (std::size_t j = 0; j < split_.geometric.size(); ++j)
    if (lacks(split_.geometric_place[j]))
      warnings->push_back(
          {"statistic-missing",
           statistic_name(split_.geometric[j]) + " has no derivative where the surface does not move a ray"});
  for (std::size_t j = 0; j < split_.own.size(); ++j) {
    if (!lacks(split_.own_place[j])) continue;
    const std::string name = statistic_name(split_.own[j]);
    if (std::holds_alternative<RmsRadius>(split_.own[j]))
      warnings->push_back({"rms-radius-of-waves",
                           name + " does not exist for waves: a sharp edge scatters light as 1/r^3, whose "
                                  "second moment diverges"});
    else if (!finite || aliased)
      without_pattern.push_back(name);
    else
      warnings->push_back(
          {"statistic-missing",
           fmt::format("{} does not exist inside the field of view of {} that the pupil grid has, or lies in "
                       "a dark ring; take a finer grid",
                       name, format_quantity(check.field_of_view, Dimension::kLength))});
  }
  if (without_pattern.empty()) return;
  const std::string more =
      without_pattern.size() == 1 ? "" : fmt::format(" and {} more", without_pattern.size() - 1);
  const std::string why = !finite ? "the surface has heights that are not finite, so it has no PSF"
                                  : check.warnings.front().message;
  warnings->push_back(
      {finite ? "psf-aliased" : "psf-not-finite", without_pattern.front() + more + ": " + why});
}

std::string WaveForward::unreachable(const std::vector<Target>& targets) const {
  const double pitch = std::max(diffraction_pupil_.pitch_x, diffraction_pupil_.pitch_y);
  std::vector<Target> radii;
  std::vector<Statistic> in_focus;
  for (const Target& target : targets) {
    const auto* radius = std::get_if<EncircledEnergyRadius>(&target.statistic);
    if (!radius) continue;
    const double largest = 0.5 * path_.wavelength * (path_.mirror.focal_length + radius->dz) / pitch;
    if (target.value > largest)
      return fmt::format(
          "the target {} = {} lies outside the field of view of the pupil grid, which ends at {}: take a "
          "finer grid",
          statistic_name(target.statistic), format_quantity(target.value, Dimension::kLength),
          format_quantity(largest, Dimension::kLength));
    radii.push_back(target);
    in_focus.push_back(EncircledEnergyRadius{radius->fraction, 0});
  }
  if (radii.empty()) return {};
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(path_.pupil.size());
  Eigen::VectorXd perfect;
  const DiffractionProblem waves = problem();
  evaluate_diffraction(waves, flat, in_focus, threads_, nullptr, &perfect, nullptr);
  for (std::size_t k = 0; k < radii.size(); ++k)
    if (std::string why = below_diffraction(radii[k], perfect[Eigen::Index(k)]); !why.empty()) return why;
  return {};
}

}  // namespace aberfit::internal
