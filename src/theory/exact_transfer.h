#pragma once
#include <memory>
#include <vector>

#include "pupil_overlap.h"
#include "surface_transfer.h"

namespace aberfit::internal {

/// E(x) = (4 pi/lambda)^2 (C(0) - C(x)) as polynomials on panels, good to 1e-12 exp(E) wherever exp(-E) is
/// not gone.
class ExponentTable {
 public:
  /// `limit` = E at infinity, may be infinite. Of `options` the cutoff is the largest x.
  ExponentTable(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent, double limit,
                const SurfaceTransferOptions& options);
  /// Infinity where exp(-E) is gone. x ascending, any number up to 24.
  PanelArray operator()(const PanelArray& x) const;
  double operator()(double x) const;
  /// x from which exp(-E) is gone for good [m]; infinity where it never is.
  double end() const { return end_; }
  std::vector<double> edges() const;
  double unresolved() const { return unresolved_; }

 private:
  std::vector<TransferPanel> panels_;
  std::vector<PanelArray> legendre_;  // coefficients of each panel
  std::vector<bool> gone_;
  double end_ = 0, unresolved_ = 0;
};

/// The optical transfer function of a rough mirror in its aperture-exact form (PHYSICS 6),
///   OTF(x) = int A(P + x/2) A*(P - x/2) H d2P / int |A|^2 d2P,
///   H = exp(-(4 pi/(lambda (1 + t^2)))^2 (C(0) - C(dr))),
/// t at the midpoint, dr the distance on the mirror of the two points: x times (1 + t^2) across the radius
/// and (1 + t^2)^2/(1 - t^2) along it. With c the cosine of the ray's angle and q = 1/(1 + t^2) = (1 + c)/2
/// this is dr = (x/q) sqrt(1 + (p . x/|x|)^2/c^2): H depends on |p|^2 and on the part of p along x alone. It
/// is interpolated in these two over the aperture by Chebyshev polynomials, whose moments `PupilOverlap`
/// holds.
class ExactTransfer {
 public:
  ExactTransfer(PupilField field, const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent,
                double limit, SurfaceTransferOptions options);
  ~ExactTransfer();

  /// On panels of x / cutoff(). Of light scattered alone: less what the limit of H leaves at every shear.
  std::vector<TransferPanel> panels(double dz, bool scattered_only) const;
  double at(double x, double dz) const;
  /// Mean of H over the aperture at a shear x, and of its limit.
  double mean_surface_transfer(double x) const { return interpolated(whole_, x); }
  /// Mean of H over the overlap of the aperture with itself at shears x [m], ascending: `at` over what it is
  /// without roughness, for a mirror without aberrations in the focus. Where nothing overlaps over the
  /// aperture.
  Eigen::ArrayXd mean_over_overlap(const Eigen::ArrayXd& x) const;
  double core_share() const;
  double cutoff() const { return 2 * field_.outer(); }
  double unresolved() const { return table_->unresolved(); }
  bool is_round() const { return field_.is_round() && field_.corners().empty(); }

 private:
  double part(int i, int j, double x) const;
  double interpolated(const Eigen::ArrayXd& moment, double x) const;  // sum_ij moment_ij H(a_i, b_j) at x
  PanelArray part(int i, int j, const PanelArray& x, bool scattered_only) const;
  MomentPanels moments(double dz) const;
  double moment_accuracy() const;
  MomentPanels far_moments(double dz, const std::vector<double>& breakpoints, double end) const;
  void append(const MomentPanel& moments, double a, double b, int halvings, bool scattered_only,
              std::vector<TransferPanel>* result) const;

  PupilField field_;
  int order_ = 1, halvings_ = 0;
  double limit_ = 0;
  std::vector<double> stretch_, share_;  // of (i, j): dr/x; of i: q^2
  std::unique_ptr<PupilOverlap> focus_overlap_;
  std::unique_ptr<const ExponentTable> table_;
  Eigen::ArrayXd whole_;  // moments of the whole aperture
  MomentPanels focus_;
};

}  // namespace aberfit::internal
