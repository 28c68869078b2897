#pragma once
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "pupil_moments.h"
#include "surface_transfer.h"

namespace aberfit::internal {

/// E(x) = (4 pi/lambda)^2 (C(0) - C(x)) as polynomials on panels. Error 1e-12 exp(E).
class ExponentTable {
 public:
  /// limit: E at infinity, may be infinite. The cutoff in `options` is the largest x.
  ExponentTable(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent, double limit,
                const SurfaceTransferOptions& options);
  /// Infinity where exp(-E) is negligible. x ascending, up to 24 numbers.
  PanelArray operator()(const PanelArray& x) const;
  double operator()(double x) const;
  /// x [m] from which exp(-E) stays negligible; infinity if there is none.
  double end() const { return end_; }
  /// x [m], to the next node, from which E stays at `exponent` or above; infinity if there is none.
  double beyond(double exponent) const;
  std::vector<double> edges() const;
  double unresolved() const { return unresolved_; }

 private:
  friend class ExponentChange;
  PanelFunction function_;
  std::vector<bool> gone_;
  double end_ = 0, unresolved_ = 0;
};

/// dE/dp at all shears of an ExponentTable, to 1e-12 exp(E), where exp(-E) is not negligible.
class ExponentChange {
 public:
  /// uneven: the change of the `uneven` of ExactTransfer.
  ExponentChange(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& change, double uneven,
                 const ExponentTable& table, double smallest);
  /// The simple case dE/dp = proportion E.
  ExponentChange(double proportion, double uneven, const ExponentTable& table);
  PanelArray operator()(const PanelArray& x) const;
  double uneven() const { return uneven_; }
  std::vector<double> edges() const;

 private:
  PanelFunction function_;
  double uneven_ = 0;
};

/// The optical transfer function of a rough mirror in its aperture-exact form (PHYSICS 6),
///   OTF(x) = int A(P + x/2) A*(P - x/2) H d2P / int |A|^2 d2P,
///   H = exp(-(4 pi/lambda)^2 (q1 q2 (C(0) - C(dr)) + (q1 - q2)^2 V / 2)).
/// q = 1/(1 + t^2) = (1 + c)/2 at either point, c is the cosine of the ray's angle, dr the distance of the
/// points on the mirror. For x -> 0, dr = (x/q) sqrt(1 + (p . x/|x|)^2/c^2) at the midpoint p. The values of
/// a pair add the second order in x/f. q1 q2 and dr depend on the mean square from the axis, p^2 + x^2/4, and
/// everything on (p . x)^2. So H depends only on x, |p|^2 and the part of p along x. Chebyshev polynomials in
/// the last two interpolate it over the aperture; `PupilMoments` holds their moments. V is the height
/// variance of waves up to ten times as long as the aperture, less 2 f^2 times the slope variance of longer
/// waves. Those tilt the mirror, and lift it, which moves no energy. Error against a sum over all pairs of
/// points: 3e-5 of the energy from f/1.5 on, 1.2e-4 at f/1, 4e-4 at f/0.75 and 1.3e-3 at f/0.5
/// (tests/theory/ghs_pairs_test.cpp).
class ExactTransfer {
 public:
  /// limit: E at infinity, may be infinite; uneven: (4 pi/lambda)^2 V.
  ExactTransfer(std::shared_ptr<const PupilMoments> pupil,
                const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& exponent, double limit,
                double uneven, SurfaceTransferOptions options);

  /// The transfer function on panels of x / cutoff(). scattered_only: without the limit of H, the core.
  std::vector<TransferPanel> panels(double dz, bool scattered_only) const;
  /// Its change with p; `change` is dE/dp.
  std::vector<TransferPanel> change_panels(double dz, const ExponentChange& change) const;
  /// Combines the changes of E and of `uneven`.
  ExponentChange change_of(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& change,
                           double uneven) const;
  ExponentChange change_of(double proportion) const { return {proportion, proportion * uneven_, *table_}; }
  double at(double x, double dz) const;
  /// Mean over the aperture of H at a shear x, with q1 = q2 as at the midpoint.
  double mean_surface_transfer(double x) const { return interpolated(pupil_->whole(), x, 0); }
  /// Mean of H over the overlap of the aperture with its copy at ascending shears x [m]. In a perfect focus
  /// it is `at` over its value without roughness. Without overlap: the aperture's mean.
  Eigen::ArrayXd mean_over_overlap(const Eigen::ArrayXd& x) const;
  double core_share() const;
  /// -d(core_share)/d(limit of E).
  double core_slope() const;
  double cutoff() const { return pupil_->cutoff(); }
  double unresolved() const { return table_->unresolved(); }
  bool is_round() const { return pupil_->is_round(); }
  bool has_departure() const { return pupil_->has_departure(); }  ///< departs from a perfect mirror

 private:
  /// H, or its change, at nodes (i, j) of the pupil and shears x.
  using Part = std::function<PanelArray(int i, int j, const PanelArray& x)>;
  // Two points about the node (i, j) of the pupil: q1 q2, distance over shear, and (q1 - q2)^2/2.
  template <typename Real>
  struct PairOfPoints {
    Real share, stretch, apart;
    // -ln H, or its change, from E at their distance.
    Real exponent(const Real& e, double uneven) const { return share * e + apart * uneven; }
  };
  template <typename Real>
  PairOfPoints<Real> pair_at(int i, int j, const Real& shear) const {
    using std::exp;
    const auto k = std::size_t(i * pupil_->order() + j);
    const Real x2 = shear * shear;
    return {pupil_->share()[std::size_t(i)] * exp(-pupil_->fall()[k] * x2),
            pupil_->stretch()[k] * (1 + pupil_->bend()[k] * x2), pupil_->apart()[k] * x2};
  }
  double part(int i, int j, double x, double shear) const;
  // sum_ij moment_ij H(a_i, b_j) at x, for points that are `shear` apart.
  double interpolated(const Eigen::ArrayXd& moment, double x, double shear) const;
  PanelArray part(int i, int j, const PanelArray& x, bool scattered_only) const;
  std::vector<TransferPanel> resolved(double dz, std::vector<double> edges, const Part& part) const;
  void append(const MomentPanel& moments, double a, double b, int halvings, const Part& part,
              std::vector<TransferPanel>* result) const;
  std::shared_ptr<const MomentPanels> moments(double dz) const;
  double end() const;

  std::shared_ptr<const PupilMoments> pupil_;
  double limit_ = 0, uneven_ = 0, smallest_ = 0;
  std::unique_ptr<const ExponentTable> table_;
};

}  // namespace aberfit::internal
