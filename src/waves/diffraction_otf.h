#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// A mean spot that the light of a transfer function is added to, inside q = `end`.
struct MeanLight {
  const MeanScatter* scatter = nullptr;  ///< null: none
  double radius = 0;                     ///< of q = 1 in the plane of the mean spot [m]
  double end = 0;                        ///< q
  std::optional<double> dz = {};         ///< that plane where it is not the focus [m]

  MeanScatter::Encircled encircled(double q) const;
};

/// The transfer function as far as circles about the focus see it: sums of C_m over lags of equal length, on
/// the nodes of a LagTable.
class RadialOtf {
 public:
  RadialOtf() = default;
  explicit RadialOtf(Eigen::ArrayXd values, const MeanLight& mean = {});

  const Eigen::ArrayXd& values() const { return values_; }

  /// Energy inside the circle of radius q (in periods of the PSF: r u, u = pitch/(lambda f)), and its
  /// derivative by q.
  struct Encircled {
    double energy, density;
  };
  Encircled encircled(double q) const;
  double energy(double q) const { return encircled(q).energy; }
  double density(double q) const { return encircled(q).density; }
  /// Smallest q <= q_max whose circle holds `fraction`; nothing if none does. Remembers what it found.
  std::optional<double> radius(double fraction, double q_max);

  /// d energy / d values.
  static Eigen::ArrayXd energy_weights(double q, Eigen::Index nodes);
  /// d transfer / d values: of the light within q = `end`, at a lag of `lag`.
  ///   2 pi int_0^end J0(2 pi q s_j) J0(2 pi q lag) q dq (Lommel's integral)
  static Eigen::ArrayXd transfer_weights(double end, double lag, Eigen::Index nodes);

 private:
  Eigen::ArrayXd values_;
  MeanLight mean_;
  std::optional<double> find_radius(double fraction, double q_max);
  Encircled of_values(double q) const;

  Eigen::ArrayXd lag_, per_lag_;  // s_j and T_j/s_j from j = 1
  std::vector<double> doubled_;   // energies of the radii that a search for any fraction looks at first
  struct Found {
    double fraction, q_max;
    std::optional<double> radius;
  };
  std::vector<Found> found_;
};

}  // namespace aberfit::internal
