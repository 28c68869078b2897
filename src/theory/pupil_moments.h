#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "moment_panels.h"
#include "pupil_field.h"

namespace aberfit::internal {

class LightMoments;
class PupilCells;
struct FocalGrid;

/// The part of the transfer function that mirror, aperture and wavelength decide, without the roughness:
/// moments of the pupil's autocorrelation. They are computed plane by plane on demand. Round pupils use
/// quadrature of the overlap (PupilOverlap). All others, and round ones far out of focus, use the focal
/// irradiance (LightMoments). Safe from many threads; results do not depend on earlier calls.
class PupilMoments {
 public:
  PupilMoments(PupilField field, int halvings);
  ~PupilMoments();

  const PupilField& field() const { return field_; }
  double cutoff() const { return 2 * field_.outer(); }
  bool is_round() const { return field_.is_round(); }
  bool has_departure() const { return field_.has_departure(); }
  int order() const { return basis_.order; }
  /// stretch (i, j): distance on the mirror over a small shear; share (i): q^2.
  const std::vector<double>& stretch() const { return stretch_; }
  const std::vector<double>& share() const { return share_; }
  /// Effect of a shear x [m], (i, j) [1/m^2]: distances grow by 1 + bend x^2, q1 q2 = q^2 exp(-fall x^2), and
  /// (q1 - q2)^2 / 2 = apart x^2.
  const std::vector<double>& bend() const { return bend_; }
  const std::vector<double>& fall() const { return fall_; }
  const std::vector<double>& apart() const { return apart_; }
  double least_stretch() const;
  double most_stretch() const;  ///< over all shears
  /// Moments of the whole aperture.
  const Eigen::ArrayXd& whole() const { return whole_; }
  /// Moments over [0, end'] of shear / cutoff, end' the next power of 2^(1/4) from `end` on, at most 1, so
  /// that roughness of similar amplitude uses the same data. Keeps the first hundred results. Throws
  /// ComputationError where the phase is too steep for every method.
  std::shared_ptr<const MomentPanels> panels(double dz, double end) const;
  /// Moments at one shear x [m].
  Eigen::ArrayXd at(double x, double dz) const;

 private:
  MomentPanels make(double dz, double end) const;
  bool by_overlap(double dz, double end) const;
  LightMoments by_light(double dz, double end) const;
  const PupilCells& cells_for(double dz, double end) const;

  PupilField field_;
  int halvings_ = 0;
  MomentBasis basis_;
  int degree_ = 0;  // total degree in a and b of moments from the irradiance
  std::vector<double> stretch_, share_, bend_, fall_, apart_;
  Eigen::ArrayXd whole_;
  struct Known;
  std::unique_ptr<Known> known_;
};

}  // namespace aberfit::internal
