#include "wave_forward.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "aberfit/core/units.h"
#include "aberfit/trace/nominal_surface.h"

namespace aberfit::internal {
namespace {

constexpr double kSamePoint = 1e-6;  // in pitches
constexpr double kNarrower = 0.02;   // phases can narrow single rings of a pattern a little

// The diffraction pupil of a pupil sample, whose grid gives the pitch.
DiffractionPupil pupil_of(const LightPath& path) {
  const auto refuse = [] {
    throw std::invalid_argument(
        "statistics by wave optics need the points of diffraction_pupil(aperture, focal length, pitch)");
  };
  const auto* grid = std::get_if<CartesianGrid>(&path.pupil.structure);
  double focal_length = kParaxial;
  std::array<double, 2> shift{};
  if (const auto* directions = std::get_if<DirectionGrid>(&path.pupil.structure)) {
    grid = &directions->cells;
    focal_length = directions->focal_length;
    shift = directions->shift;
  }
  if (!grid || grid->x.size() < 2) refuse();
  const double pitch = (grid->x[grid->x.size() - 1] - grid->x[0]) / double(grid->x.size() - 1);
  DiffractionPupil pupil = diffraction_pupil(*path.aperture, focal_length, pitch, shift);
  const double limit = kSamePoint * pitch;
  if (pupil.sample.size() != path.pupil.size() || !((pupil.sample.x - path.pupil.x).abs() <= limit).all() ||
      !((pupil.sample.y - path.pupil.y).abs() <= limit).all())
    refuse();
  return pupil;
}

// Height errors [m] of a parabola with the same focal length that have the phase of the mirror. A path to the
// focus by way of the height z is sqrt(rho^2 + (f - z)^2) - z; for the parabola z_p it is f. The difference
// is written so that nothing cancels. To first order it is the departure of the sags.
Eigen::ArrayXd departure_of(const Mirror& mirror, const DiffractionPupil& pupil,
                            const OperatorOptions& options) {
  const PupilSample& sample = pupil.sample;
  Eigen::ArrayXd departure = departure_from_parabola(mirror, sample, options);
  const bool paraxial = !std::holds_alternative<DirectionGrid>(sample.structure);
  if (paraxial) return departure;
  const double f = mirror.focal_length;
  for (Eigen::Index i = 0; i < departure.size(); ++i) {
    const double x = sample.x[i], y = sample.y[i], sag = (x * x + y * y) / (4 * f), d = departure[i];
    const double path = f + sag, more = d * (d - 2 * (f - sag));
    const double longer = more / (std::sqrt(path * path + more) + path) - d;
    departure[i] = -longer / (2 * pupil.obliquity[i]);
  }
  return departure;
}

// A required energy fraction inside a radius [m] in plane dz.
struct Wanted {
  double fraction, radius, dz;
  bool of_share;     // judged as the fraction inside the radius, else as the radius of the fraction
  double tolerance;  // in the unit of the judged value
};
std::optional<Wanted> wanted_light(const Target& target) {
  if (const auto* ee = std::get_if<EncircledEnergyRadius>(&target.statistic))
    return Wanted{ee->fraction, target.value, ee->dz, false, target.tolerance};
  if (const auto* share = std::get_if<RingThrough>(&target.statistic))
    return Wanted{target.value, share->ring_radius, share->dz, true, target.tolerance};
  return std::nullopt;
}

// The two farthest planes [m] of the statistics, in front of the mirror; 0: none.
std::array<double, 2> outermost_planes(const std::vector<Statistic>& statistics, double focal_length) {
  std::array<double, 2> ends{0, 0};
  for (const Statistic& statistic : statistics) {
    const double dz = plane_of_light(statistic).value_or(0);
    if (!(focal_length + dz > 0) || !std::isfinite(dz)) continue;
    ends = {std::min(ends[0], dz), std::max(ends[1], dz)};
  }
  return ends;
}

// Returns why a required energy fraction is out of reach: the perfect mirror in the focus holds less there.
// perfect: its judged value. Empty where there is no such reason.
std::string below_diffraction(const Wanted& wanted, double perfect) {
  const bool beyond = wanted.of_share ? wanted.fraction - wanted.tolerance > (1 + kNarrower) * perfect
                                      : wanted.radius + wanted.tolerance < (1 - kNarrower) * perfect;
  if (!beyond) return {};
  const std::string best = wanted.of_share ? fmt::format("{:.3g} % there", 100 * perfect)
                                           : "within " + format_quantity(perfect, Dimension::kLength);
  return fmt::format(
      "the target of {:.3g} % of the energy within {} is sharper than a perfect mirror, which needs {}; "
      "diffraction of the aperture allows no less",
      100 * wanted.fraction, format_quantity(wanted.radius, Dimension::kLength), best);
}

}  // namespace

WaveForward::WaveForward(const LightPath& path, const std::vector<Statistic>& statistics, int threads)
    : path_(path),
      threads_(threads),
      split_(statistics),
      diffraction_pupil_(pupil_of(path)),
      departure_(departure_of(path.mirror, diffraction_pupil_, focus_operator(FocusModel::kWaves, threads))),
      workspace_(path.workspace ? *path.workspace : own_workspace_) {
  if (split_.geometric.empty()) return;
  const TermSet& terms = path.surface.terms();
  if (terms.segments && terms.segments_begin() == 0) return;
  moments_ = make_moment_rays(path.mirror, *path.aperture, terms, split_.geometric, threads);
  if (!moments_)  // the order is too high; the grid cells are used
    moments_ = std::make_unique<MomentRays>(path.mirror, path.pupil, terms,
                                            focus_operator(FocusModel::kWaves, threads), split_.geometric);
}

void WaveForward::move_to(const Eigen::VectorXd& coefficients) {
  if (moments_) moments_->move_to(coefficients);
  coefficients_ = coefficients;
  known_ = false;
}

// Moments have points of their own; a caller that needs only them needs no cell heights.
const Eigen::ArrayXd& WaveForward::height() {
  if (known_) return height_;
  path_.surface.apply(coefficients_, &field_);
  height_ = field_.height;
  if (departure_.size() > 0) height_ += departure_;
  known_ = true;
  return height_;
}

bool WaveForward::evaluate(double width, Eigen::VectorXd* values) {
  values->setConstant(Eigen::Index(split_.own.size() + split_.geometric.size()), std::nan(""));
  bool exist = true;
  Eigen::VectorXd some;
  if (!split_.geometric.empty()) {
    if (moments_)
      exist = moments_->rays().evaluate(width > 0 ? width : 1, &some);  // moments use no kernel
    else
      some = no_moments();
    for (std::size_t j = 0; j < split_.geometric.size(); ++j)
      (*values)[Eigen::Index(split_.geometric_place[j])] =
          with_scatter(path_.scatter.get(), split_.geometric[j], some[Eigen::Index(j)]);
  }
  if (!split_.own.empty()) {
    const DiffractionProblem waves = problem();
    if (!evaluate_diffraction(waves, height(), split_.own, threads_, &workspace_, &some, nullptr))
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
  for (std::size_t j = 0; !moments_ && j < split_.geometric.size(); ++j)
    sink(split_.geometric_place[j], Eigen::VectorXd::Zero(coefficients_.size()));
  if (moments_) {
    Eigen::VectorXd of_terms;
    if (!moments_->rays().evaluate(1, &of_terms)) return false;
    const auto chained = [&](std::size_t j, const Eigen::VectorXd& gradient) {
      const double own = of_terms[Eigen::Index(j)],
                   sum = with_scatter(path_.scatter.get(), split_.geometric[j], own);
      Eigen::VectorXd all = Eigen::VectorXd::Zero(coefficients_.size());
      all.head(gradient.size()) = path_.scatter ? own / sum * gradient : gradient;
      sink(split_.geometric_place[j], all);
    };
    if (!moments_->rays().gradients(chained)) return false;
  }
  if (split_.own.empty()) return true;
  Eigen::VectorXd values;
  std::vector<Eigen::ArrayXd> d_height;
  const DiffractionProblem waves = problem();
  const TermSet& terms = path_.surface.terms();
  const int side = HeightBlocks::side(terms, path_.pupil);
  if (side > 1 && !blocks_)
    blocks_ = std::make_unique<const HeightBlocks>(terms, path_.pupil, side,
                                                   focus_operator(FocusModel::kWaves, threads_));
  GradientReduction reduce;
  if (blocks_) reduce = [this](const Eigen::ArrayXd& weights) { return blocks_->sums(weights); };
  if (!evaluate_diffraction(waves, height(), split_.own, threads_, &workspace_, &values, &d_height, reduce))
    return false;
  const Eigen::MatrixXd gradients =
      blocks_ ? blocks_->products(d_height) : path_.surface.apply_transpose_heights(d_height);
  for (std::size_t j = 0; j < split_.own.size(); ++j)
    sink(split_.own_place[j], gradients.col(Eigen::Index(j)));
  return true;
}

Eigen::VectorXd WaveForward::exact(Warnings* warnings) {
  Eigen::VectorXd values;
  evaluate(0, &values);
  const Eigen::VectorXd geometric = moments_ ? moments_->rays().exact(warnings) : no_moments();
  for (std::size_t j = 0; j < split_.geometric.size(); ++j)
    values[Eigen::Index(split_.geometric_place[j])] =
        with_scatter(path_.scatter.get(), split_.geometric[j], geometric[Eigen::Index(j)]);
  if (!warnings) return values;
  explain(values, warnings);
  const double pitch = std::max(diffraction_pupil_.pitch_x, diffraction_pupil_.pitch_y);
  if (const auto coarse = undersampled(path_.surface.terms(), pitch)) warnings->push_back(*coarse);
  return values;
}

void WaveForward::explain(const Eigen::VectorXd& values, Warnings* warnings) {
  if (values.allFinite()) return;
  const DiffractionProblem waves = problem();
  DiffractionCheck check = check_diffraction(waves, height(), 0.0);
  for (const double dz : outermost_planes(split_.own, waves.focal_length)) {
    DiffractionCheck there = check_diffraction(waves, height(), dz);
    if (there.aliased_share > std::max(check.aliased_share, waves.aliased_limit)) check = std::move(there);
  }
  const bool finite = height().allFinite(), aliased = check.aliased_share > waves.aliased_limit;
  // A surface without a pattern has none of its statistics, which is reported once.
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
    if (!kind_of(split_.own[j]).in_waves())
      warnings->push_back({"rms-radius-of-waves", name + " does not exist for waves: a sharp edge diffracts "
                                                         "energy as 1/r^3, whose second moment diverges"});
    else if (!finite || aliased)
      without_pattern.push_back(name);
    else
      warnings->push_back(
          {"statistic-missing", fmt::format("{} does not exist inside the pupil grid's field of view of {}, "
                                            "or lies in a dark ring; take a finer grid",
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
  std::vector<Wanted> light;
  std::vector<Statistic> in_focus;
  for (const Target& target : targets) {
    const std::optional<Wanted> wanted = wanted_light(target);
    if (!wanted) continue;
    const double largest = 0.5 * path_.wavelength * (path_.mirror.focal_length + wanted->dz) / pitch;
    if (!path_.scatter && wanted->radius > largest)
      return fmt::format(
          "the target of {:.3g} % of the energy within {} lies outside the field of view of the pupil grid, "
          "which ends at {}; take a finer grid",
          100 * wanted->fraction, format_quantity(wanted->radius, Dimension::kLength),
          format_quantity(largest, Dimension::kLength));
    light.push_back(*wanted);
    if (wanted->of_share)
      in_focus.push_back(RingThrough{wanted->radius, 0});
    else
      in_focus.push_back(EncircledEnergyRadius{wanted->fraction, 0});
  }
  if (light.empty()) return {};
  const Eigen::ArrayXd flat = Eigen::ArrayXd::Zero(path_.pupil.size());
  Eigen::VectorXd perfect;
  DiffractionProblem waves = problem();
  waves.scatter = nullptr;
  evaluate_diffraction(waves, flat, in_focus, threads_, nullptr, &perfect, nullptr);
  for (std::size_t k = 0; k < light.size(); ++k)
    if (std::string why = below_diffraction(light[k], perfect[Eigen::Index(k)]); !why.empty()) return why;
  return {};
}

}  // namespace aberfit::internal
