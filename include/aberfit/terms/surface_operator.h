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

/// Height and gradient of a term surface at a list of points or, in the adjoint, the weights of each.
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

/// Methods for the Zernike part of L; all agree to rounding.
enum class ZernikeMethod {
  kFused,  ///< recurrences at every point without a stored matrix; any points
  kPolar,  ///< sums over the radial order per ring, then FFTs over the angle; needs PolarRings
};
/// Methods for the Fourier part of L.
enum class FourierMethod {
  kPhaseSums,  ///< vectorised sine and cosine per mode and point; any points
  kLattice,    ///< nonuniform FFT to 1e-10; lattice modes (TermSet::fourier_pitch), any points
};
std::string to_string(ZernikeMethod method);
std::string to_string(FourierMethod method);

/// Options of L. A method that is not set is kPolar or kLattice where points and terms allow it.
struct OperatorOptions {
  int threads = 1;
  std::optional<ZernikeMethod> zernike;
  std::optional<FourierMethod> fourier;
  /// Zernike terms at points outside `terms.radius` take height and slopes of the nearest point of the rim.
  /// This serves edge cells of a diffraction pupil. Outside, the polynomials grow as (rho + sqrt(rho^2 -
  /// 1))^n, e.g. 30 times at n = 28 and rho = 1.007.
  bool hold_at_rim = false;
};

/// The chosen methods, and the reason.
struct OperatorChoice {
  std::optional<ZernikeMethod> zernike;  ///< empty without Zernike terms
  std::optional<FourierMethod> fourier;  ///< empty without Fourier terms
  /// Prediction for one apply and one apply_transpose on one thread; zero for scattered points with no
  /// choice.
  double forward_seconds = 0;
  double adjoint_seconds = 0;
  std::string reason;  ///< one sentence
};

/// The linear map L from coefficients to heights and slopes at fixed points, and its adjoint.
/// surface_operator.cpp lists the methods of each family of terms, their errors and speeds. None stores
/// points x terms numbers. The object is immutable except for reused scratch memory, so several threads may
/// share it. Results do not depend on the thread count, to the last bit.
class SurfaceOperator {
 public:
  /// x, y: point coordinates [m], in the disc of `terms.radius` or slightly outside (Zernike terms grow as
  /// rho^n there). `threads`: number of threads of apply and apply_transpose. Uses kFused, and kLattice if
  /// there is a lattice. Throws std::invalid_argument for x and y of different length, an invalid (n, m), an
  /// odd spherical power, a mode off its lattice, or a radius that is not positive if Zernike or spherical
  /// terms need one.
  SurfaceOperator(TermSet terms, Eigen::ArrayXd x, Eigen::ArrayXd y, int threads = 1);
  /// The same at the points of a pupil, whose structure faster methods use. Also throws std::invalid_argument
  /// for a method that the structure does not allow, and for a structure that does not match the points.
  SurfaceOperator(TermSet terms, const PupilSample& pupil, const OperatorOptions& options);
  ~SurfaceOperator();
  SurfaceOperator(SurfaceOperator&&) noexcept;
  SurfaceOperator& operator=(SurfaceOperator&&) noexcept;

  const TermSet& terms() const;
  Eigen::Index points() const;
  const OperatorChoice& choice() const;

  /// field = L c. c: terms().size() entries [m]. The field is resized to points().
  void apply(const Eigen::VectorXd& coefficients, SurfaceField* field) const;

  /// L^T g, for each term the sum over points of g.height h + g.slope_x dh/dx + g.slope_y dh/dy, g = weights.
  Eigen::VectorXd apply_transpose(const SurfaceField& weights) const;

  /// The same for weights that vanish outside `rays`: entry i of the rays.size() weights belongs to point
  /// rays[i]. It uses the listed rays or all points, whichever should cost less (a function of rays.size()
  /// only).
  Eigen::VectorXd apply_transpose(std::span<const std::uint32_t> rays, const SurfaceField& weights) const;

  /// L^T for many weights of the heights alone: column k belongs to weights[k], with points() entries.
  /// Zernike terms use one matrix product. L is made block by block, by recurrences and phase sums for every
  /// choice of methods, in 0.02 to 0.1 of the time of one apply_transpose per weight (height_products.h).
  /// Lattice modes take half a transform each (fourier_lattice.h).
  Eigen::MatrixXd apply_transpose_heights(std::span<const Eigen::ArrayXd> weights) const;

  /// The same as apply_transpose, into memory of the caller; result is resized to terms().size().
  void apply_transpose(const SurfaceField& weights, Eigen::VectorXd* result) const;
  void apply_transpose(std::span<const std::uint32_t> rays, const SurfaceField& weights,
                       Eigen::VectorXd* result) const;

 private:
  struct Plan;
  std::unique_ptr<const Plan> plan_;
};

}  // namespace aberfit
