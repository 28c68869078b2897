#include "pupil_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aberfit/core/errors.h"
#include "pupil_kernel.h"

namespace aberfit::internal {
namespace {

constexpr double kSamePhase = 1e-9;   // [rad], for points at one radius of a round surface
constexpr double kRoundPhase = 1e-9;  // [rad], for the polynomial of a round departure

// P over r.
double conjugate(double rho, double focal_length) {
  const double t = 0.5 * rho / focal_length;
  return 1 / (1 + t * t);
}

}  // namespace

PupilField::PupilField(const Mirror& mirror, const Aperture& aperture, double wavelength,
                       const Departure& departure)
    : aperture_(aperture), focal_length_(mirror.focal_length), wavelength_(wavelength) {
  const double rim = aperture_radius(aperture);
  if (!(rim > 0 && rim < 2 * focal_length_ && aperture_area(aperture) > 0))
    throw ComputationError(
        fmt::format("no light returns to the focus: the aperture's radius is {} m, but must be above zero "
                    "and below twice the focal length of {} m, where the mirror's slope is 45 degrees",
                    rim, focal_length_));
  if (!(rim < sag_domain_radius(mirror)))
    throw ComputationError(fmt::format("the mirror has no sag {} m off its axis", rim));
  is_parabola_ = !departure && is_parabola(mirror);
  if (!is_parabola_)
    departure_ = [mirror, departure](double x, double y) {
      const double own = base_surface(mirror, x, y).height - (x * x + y * y) / (4 * mirror.focal_length);
      return own + (departure ? departure(x, y) : 0.0);
    };
  outer_ = rim * conjugate(rim, focal_length_);
  if (const auto* annulus = std::get_if<AnnulusAperture>(&aperture)) {
    const double rho = 0.5 * annulus->inner_diameter;
    inner_ = rho * conjugate(rho, focal_length_);
  }
  is_round_ = aperture_outlines(aperture).empty();
  if (!is_parabola_) {
    for (const double part : {0.31, 0.77, 1.0})
      for (const double angle : {0.4, 1.3, 2.9, 4.4}) {
        const double first = departure_(part * rim, 0);
        const double here = departure_(part * rim * std::cos(angle), part * rim * std::sin(angle));
        if (!std::isfinite(first) || !std::isfinite(here))
          throw ComputationError(
              fmt::format("the mirror's height {} m off its axis is not a number", part * rim));
        if (std::abs(here - first) * 4 * std::numbers::pi / wavelength > kSamePhase) is_round_ = false;
      }
    if (is_round_)
      even_ = EvenPolynomial::of([this](double p) { return departure_at(p, 0); }, outer_, kRoundPhase);
  }
}

double PupilField::departure_at(double x, double y) const {
  const double p2 = (x * x + y * y) / (focal_length_ * focal_length_), c = std::sqrt(1 - p2);
  const double scale = 2 / (1 + c);  // r over P
  return 2 * std::numbers::pi / wavelength_ * (1 + c) * departure_(scale * x, scale * y);
}

// One root and one division serve amplitude and defocus; 1 - c = p^2 / (1 + c) avoids cancellation.
void PupilField::pairs(double dz, const double* x1, const double* y1, const double* x2, const double* y2,
                       int n, double* amplitude, double* difference, double* scratch) const {
  const double scale = 1 / (focal_length_ * focal_length_);
  const double defocus = 2 * std::numbers::pi / wavelength_ * dz / (1 + dz / focal_length_);
  parabola_pairs(best_instruction_set(), scale, defocus, {x1, y1, x2, y2, n, amplitude, difference});
  if (is_parabola_) return;
  add_departure(x1, y1, n, difference);
  std::fill(scratch, scratch + n, 0.0);
  add_departure(x2, y2, n, scratch);
  for (int k = 0; k < n; ++k) difference[k] -= scratch[k];
}

void PupilField::add_departure(const double* x, const double* y, int n, double* result) const {
  if (even_)
    even_->add(x, y, n, result);
  else
    for (int k = 0; k < n; ++k) result[k] += departure_at(std::sqrt(x[k] * x[k] + y[k] * y[k]), 0);
}

void PupilField::along_radius(double dz, const Eigen::ArrayXd& p, Eigen::ArrayXd* amplitude,
                              Eigen::ArrayXd* phase) const {
  const Eigen::ArrayXd axis = Eigen::ArrayXd::Zero(p.size());
  Eigen::ArrayXd scratch(p.size());
  amplitude->resize(p.size());
  phase->resize(p.size());
  pairs(dz, p.data(), axis.data(), axis.data(), axis.data(), int(p.size()), amplitude->data(), phase->data(),
        scratch.data());  // the amplitude on the axis is 1
}

double PupilField::steepest(double dz) const {
  constexpr int kSteps = 400;
  Eigen::ArrayXd amplitude, phase;
  along_radius(dz, Eigen::ArrayXd::LinSpaced(kSteps + 1, inner_, outer_), &amplitude, &phase);
  return (phase.tail(kSteps) - phase.head(kSteps)).abs().maxCoeff() * kSteps / (outer_ - inner_);
}

}  // namespace aberfit::internal
