#pragma once
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/theory/vocabulary.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {

/// The way of light from a term surface to the focus: all that the statistics of the surface depend on.
struct LightPath {
  const Mirror& mirror;
  const PupilSample&
      pupil;  ///< for kWaves the sample of diffraction_pupil(*aperture, mirror.focal_length, pitch)
  const SurfaceOperator& surface;  ///< L at the pupil points
  FocusModel model = FocusModel::kRays;
  double wavelength = 0;                      ///< [m]; needed unless kRays
  const Aperture* aperture = nullptr;         ///< needed unless kRays
  Centre centre = Centre::kNominal;           ///< kCentroid: kRays only
  double aliased_limit = kMostAliased;        ///< kWaves: as DiffractionProblem has it
  DiffractionWorkspace* workspace = nullptr;  ///< kWaves: to work in; null: one of its own
  /// Roughness that the terms do not stand for; null: none. By waves its mean; by rays every ray is turned by
  /// a Gaussian slope of its own (scattered_rays.h).
  std::shared_ptr<const MeanScatter> scatter = {};
  bool single_precision = false;  ///< kWaves: as DiffractionProblem has it
};

/// The way from coefficients to statistics and back, for one model. Remembers the last point: a solver asks
/// for the derivatives where it has just asked for the values. For one caller at a time. How far its values
/// are from those of endlessly many points: statistics_with_error.h.
class ForwardModel {
 public:
  /// Takes d statistic k/d coefficients; may be called from several threads at once, for different k.
  using GradientSink = std::function<void(std::size_t k, const Eigen::VectorXd& gradient)>;

  virtual ~ForwardModel() = default;
  /// The surface with these coefficients [m] from now on.
  virtual void move_to(const Eigen::VectorXd& coefficients) = 0;
  /// Statistics there, smoothed over `width` [m] where the model does not smooth by itself. False when one
  /// has no value or derivative.
  virtual bool evaluate(double width, Eigen::VectorXd* values) = 0;
  /// Derivatives of all that `evaluate` gave last, each statistic once. False when one does not exist.
  virtual bool gradients(const GradientSink& sink) = 0;
  /// Unsmoothed statistics there; NaN where one does not exist, each with a warning when `warnings` is given.
  virtual Eigen::VectorXd exact(Warnings* warnings) = 0;
  /// Why `evaluate` gave false last: one clause.
  virtual std::string trouble() const = 0;
  /// Why a target is out of reach of every surface; empty when nothing speaks against any.
  virtual std::string unreachable(const std::vector<Target>&) const { return {}; }
};

/// The forward model of the path. The path's parts must outlive it. Throws std::invalid_argument for what the
/// model cannot do: kCentroid unless kRays, no wavelength or aperture, a pupil that is no diffraction pupil.
std::unique_ptr<ForwardModel> make_forward_model(const LightPath& path,
                                                 const std::vector<Statistic>& statistics, int threads);

/// Statistics of the surface with `coefficients` [m], unsmoothed, in the order asked. NaN where one does not
/// exist, each with a warning when `warnings` is given. Throws as make_forward_model does.
Eigen::VectorXd focus_statistics(const LightPath& path, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads, Warnings* warnings);

/// The diffraction pattern of the surface with `coefficients` [m] in `window`, as kWaves has it. Throws
/// std::invalid_argument for another model, and as diffraction_psf does.
PsfImage focus_psf(const LightPath& path, const Eigen::VectorXd& coefficients, const PsfWindow& window);

/// How L is to be computed at the pupil points of a model.
OperatorOptions focus_operator(FocusModel model, int threads);

/// Whether the statistics of this model have derivatives without smoothing: one solve at any width.
inline bool smooth_by_itself(FocusModel model) { return model != FocusModel::kRays; }

}  // namespace aberfit
