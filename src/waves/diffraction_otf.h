#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// A mean spot to which the energy of a transfer function is added inside q = `end`.
struct MeanLight {
  const MeanScatter* scatter = nullptr;  ///< null: none
  double radius = 0;                     ///< radius of q = 1 in the plane of the mean spot [m]
  double end = 0;                        ///< q
  std::optional<double> dz = {};         ///< that plane if it is not the focus [m]

  MeanScatter::Encircled encircled(double q) const;
};

/// The part of the transfer function that circles about the focus need: sums of C_m over lags of equal
/// length, on the nodes of a LagTable.
class RadialOtf {
 public:
  RadialOtf() = default;
  explicit RadialOtf(Eigen::ArrayXd values, const MeanLight& mean = {});

  const Eigen::ArrayXd& values() const { return values_; }

  /// Encircled energy of the radius q, and its derivative with respect to q. q is in periods of the PSF: q =
  /// r u, u = pitch/(lambda f).
  struct Encircled {
    double energy, density;
  };
  Encircled encircled(double q) const;
  double energy(double q) const { return encircled(q).energy; }
  double density(double q) const { return encircled(q).density; }
  /// Smallest q <= q_max whose circle holds `fraction`; nothing if there is none. Results are stored.
  std::optional<double> radius(double fraction, double q_max);

  /// d energy / d values.
  static Eigen::ArrayXd energy_weights(double q, Eigen::Index nodes);
  /// d transfer / d values for the energy within q = `end`, at the lag `lag`:
  ///   2 pi int_0^end J0(2 pi q s_j) J0(2 pi q lag) q dq (Lommel's integral)
  static Eigen::ArrayXd transfer_weights(double end, double lag, Eigen::Index nodes);

 private:
  Eigen::ArrayXd values_;
  MeanLight mean_;
  std::optional<double> find_radius(double fraction, double q_max);
  Encircled of_values(double q) const;

  Eigen::ArrayXd lag_, per_lag_;  // s_j and T_j/s_j from j = 1
  std::vector<double> doubled_;   // energies at the first radii of every search
  struct Found {
    double fraction, q_max;
    std::optional<double> radius;
  };
  std::vector<Found> found_;
};

/// FWHM, between the outermost half crossings, of the line spread function L(xi) = Re(C_0) + 2 Re sum_(m>0)
/// C_m exp(-2 pi i m xi). xi is in periods of the PSF; C_m is the transfer function along one axis.
/// `gradient`, when given: g_m with d FWHM = Re sum_m g_m dC_m. Returns nothing when there is no peak or no
/// crossing in the period.
std::optional<double> otf_line_width(const Eigen::ArrayXcd& transfer, Eigen::ArrayXcd* gradient);

}  // namespace aberfit::internal
