#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>

#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "even_polynomial.h"

namespace aberfit::internal {

/// The wave in the pupil of a mirror without roughness. Its coordinate P = f times the direction cosine of
/// the ray from that point [m] is conjugate to the focal plane: P = r / (1 + t^2), t = r/2f (PHYSICS 6). Even
/// illumination of the aperture has the amplitude 2/((1 + c) sqrt(c)), with c = sqrt(1 - (P/f)^2) the cosine
/// of the ray's angle.
class PupilField {
 public:
  /// Height of the surface above the parabola [m] at x, y [m].
  using Departure = std::function<double(double, double)>;

  /// `departure` is added to that of `mirror`; may be empty. Throws ComputationError where the mirror has no
  /// sag, or is 45 degrees steep, so that rays do not come back to the focus.
  PupilField(const Mirror& mirror, const Aperture& aperture, double wavelength, const Departure& departure);

  double outer() const { return outer_; }  ///< largest |P| of the aperture [m]
  double inner() const { return inner_; }  ///< of an annulus [m]; 0 for others
  bool has_departure() const { return !is_parabola_; }
  /// Outline, amplitude and phase depend on |P| alone.
  bool is_round() const { return is_round_; }
  double focal_length() const { return focal_length_; }
  double wavelength() const { return wavelength_; }
  const Aperture& aperture() const { return aperture_; }
  /// Phase of the departure at x, y in P [rad].
  double departure_phase(double x, double y) const { return departure_at(x, y); }

  /// Computes, for n pairs of points of a round field in the plane f + dz, the product of their amplitudes
  /// and the phase at the first point less that at the second [rad]. The phase is 4 pi h/(lambda (1 + t^2)) +
  /// (2 pi/lambda) dz (1 - c)/(1 + dz/f). scratch: room for n.
  void pairs(double dz, const double* x1, const double* y1, const double* x2, const double* y2, int n,
             double* amplitude, double* difference, double* scratch) const;
  /// Computes amplitude and phase [rad] of a round field at distances from the axis [m] in that plane.
  void along_radius(double dz, const Eigen::ArrayXd& p, Eigen::ArrayXd* amplitude,
                    Eigen::ArrayXd* phase) const;
  /// Largest slope of the phase of a round field [rad/m].
  double steepest(double dz) const;

 private:
  double departure_at(double x, double y) const;
  void add_departure(const double* x, const double* y, int n, double* result) const;

  Departure departure_;  // of the mirror, with the added one
  Aperture aperture_;
  double focal_length_ = 0, wavelength_ = 0;
  double outer_ = 0, inner_ = 0;
  bool is_parabola_ = true, is_round_ = true;
  // Phase of the departure over P [rad], if it is round and a short polynomial.
  std::optional<EvenPolynomial> even_;
};

}  // namespace aberfit::internal
