#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "aberfit/scene/pupil.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// Height and gradient of a term surface at a list of points, or (in the adjoint) one weight for each of
/// them.
struct SurfaceField {
  Eigen::ArrayXd height;   ///< h [m]
  Eigen::ArrayXd slope_x;  ///< dh/dx
  Eigen::ArrayXd slope_y;  ///< dh/dy
  Eigen::Index size() const { return height.size(); }
  void resize(Eigen::Index n) {
    height.resize(n);
    slope_x.resize(n);
    slope_y.resize(n);
  }
};

/// Ways to compute the Zernike part of L; all agree to rounding.
enum class ZernikeMethod {
  kFused,  ///< recurrences at every point, no stored matrix; any points
  kPolar,  ///< sums over the radial order per ring, then FFTs over the angle; points on PolarRings
};
/// Ways to compute the Fourier part of L.
enum class FourierMethod {
  kPhaseSums,  ///< vectorised sine and cosine per mode and point; any points
  kLattice,    ///< nonuniform FFT to 1e-10; modes of a lattice (TermSet::fourier_pitch), any points
};
std::string to_string(ZernikeMethod method);
std::string to_string(FourierMethod method);

/// How L is to be computed. What is left open takes what the structure of points and terms allows: kPolar,
/// kLattice.
struct OperatorOptions {
  int threads = 1;
  std::optional<ZernikeMethod> zernike;
  std::optional<FourierMethod> fourier;
  /// Zernikes at points outside `terms.radius` take height and slopes of the nearest point of its rim. For
  /// cells of a diffraction pupil that the rim cuts: the polynomials grow as (rho + sqrt(rho^2 - 1))^n
  /// outside, 30 times at n = 28 and rho = 1.007.
  bool hold_at_rim = false;
};

/// What was chosen, and why.
struct OperatorChoice {
  std::optional<ZernikeMethod> zernike;  ///< nothing without Zernike terms
  std::optional<FourierMethod> fourier;  ///< nothing without Fourier terms
  /// Predicted for one apply and one apply_transpose on one thread (operator_cost.h); zero for scattered
  /// points that no choice was made for.
  double forward_seconds = 0;
  double adjoint_seconds = 0;
  std::string reason;  ///< one sentence
};

/// The linear map L from coefficients to heights and slopes at fixed points, and its adjoint. Each family of
/// terms has its method (see surface_operator.cpp for the methods, their measured errors and speeds); none
/// stores anything of the size points x terms. Immutable but for scratch memory, which is kept for
/// the next call, so one object may serve several threads; results do not depend on the thread count, to the
/// last bit.
class SurfaceOperator {
 public:
  /// x, y: point coordinates [m], in the disc of `terms.radius` or slightly outside (Zernikes grow as rho^n
  /// there). `threads`: how many threads apply and apply_transpose may use. Throws std::invalid_argument for
  /// x and y of different length, an (n, m) that is no Zernike mode, an odd spherical power, a mode off its
  /// lattice, or a radius that is not positive where Zernike or spherical terms need one. Methods: kFused,
  /// and kLattice where there is one.
  SurfaceOperator(TermSet terms, Eigen::ArrayXd x, Eigen::ArrayXd y, int threads = 1);
  /// The same on the points of a pupil, whose structure faster methods use. Throws std::invalid_argument,
  /// too, for a method that the structure does not allow, and a structure that is not that of the points.
  SurfaceOperator(TermSet terms, const PupilSample& pupil, const OperatorOptions& options);
  ~SurfaceOperator();
  SurfaceOperator(SurfaceOperator&&) noexcept;
  SurfaceOperator& operator=(SurfaceOperator&&) noexcept;

  const TermSet& terms() const;
  Eigen::Index points() const;
  const OperatorChoice& choice() const;

  /// field = L c. c: terms().size() entries [m]; field is resized to points().
  void apply(const Eigen::VectorXd& coefficients, SurfaceField* field) const;

  /// L^T g: for each coefficient the sum over points of g.height h + g.slope_x dh/dx + g.slope_y dh/dy of its
  /// term. weights: points() entries.
  Eigen::VectorXd apply_transpose(const SurfaceField& weights) const;

  /// The same for weights that vanish outside `rays`: weights has rays.size() entries, entry i belongs to
  /// point rays[i]. Point by point on the listed rays, or all points with zeros for the others, whichever is
  /// predicted to cost less (a function of rays.size() only).
  Eigen::VectorXd apply_transpose(std::span<const std::uint32_t> rays, const SurfaceField& weights) const;

  /// L^T of weights of the heights alone, many at once: column k is that of weights[k], points() entries.
  /// Zernikes: one product of matrices, of which L is made block by block, by recurrences and phase sums
  /// whatever the methods of the other functions: 0.02 to 0.1 of the time of one apply_transpose each
  /// (height_products.h). Modes of a lattice: half a transform each (fourier_lattice.h).
  Eigen::MatrixXd apply_transpose_heights(std::span<const Eigen::ArrayXd> weights) const;

  /// The same as apply_transpose into memory that the caller keeps; result is resized to terms().size().
  void apply_transpose(const SurfaceField& weights, Eigen::VectorXd* result) const;
  void apply_transpose(std::span<const std::uint32_t> rays, const SurfaceField& weights,
                       Eigen::VectorXd* result) const;

 private:
  struct Plan;
  std::unique_ptr<const Plan> plan_;
};

}  // namespace aberfit
