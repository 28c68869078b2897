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

/// The path from a term surface to the focus: everything that the statistics of the surface depend on.
struct LightPath {
  const Mirror& mirror;
  const PupilSample&
      pupil;  ///< kWaves: the sample of diffraction_pupil(*aperture, mirror.focal_length, pitch)
  const SurfaceOperator& surface;  ///< L at the pupil points
  FocusModel model = FocusModel::kRays;
  double wavelength = 0;                      ///< [m]; needed unless kRays
  const Aperture* aperture = nullptr;         ///< needed unless kRays
  Centre centre = Centre::kNominal;           ///< kCentroid: kRays only
  double aliased_limit = kMostAliased;        ///< kWaves: see DiffractionProblem
  DiffractionWorkspace* workspace = nullptr;  ///< kWaves: optional workspace; null: its own
  /// Roughness beyond the terms; null: none. By waves it enters as its mean; by rays every ray is tilted by
  /// an independent Gaussian slope (scattered_rays.h).
  std::shared_ptr<const MeanScatter> scatter = {};
  bool single_precision = false;  ///< kWaves: see DiffractionProblem
};

/// Maps coefficients to statistics and back, for one model. It remembers the last point, because a solver
/// requests values and then derivatives there. For one caller at a time. The sampling error of its values is
/// that of statistics_with_error.h.
class ForwardModel {
 public:
  /// Receives d statistic k/d coefficients; may be called from several threads at once, for different k.
  using GradientSink = std::function<void(std::size_t k, const Eigen::VectorXd& gradient)>;

  virtual ~ForwardModel() = default;
  /// Sets the surface by its coefficients [m].
  virtual void move_to(const Eigen::VectorXd& coefficients) = 0;
  /// Statistics of that surface, smoothed over `width` [m] where the model does not smooth by itself. False
  /// when one has no value or derivative.
  virtual bool evaluate(double width, Eigen::VectorXd* values) = 0;
  /// Derivatives of the last `evaluate`, each statistic once. False when one does not exist.
  virtual bool gradients(const GradientSink& sink) = 0;
  /// Unsmoothed statistics of that surface; NaN where one does not exist, with an optional warning each.
  virtual Eigen::VectorXd exact(Warnings* warnings) = 0;
  /// Returns why the last `evaluate` returned false: one clause.
  virtual std::string trouble() const = 0;
  /// Returns why no surface can reach one of the targets; empty where no reason is known.
  virtual std::string unreachable(const std::vector<Target>&) const { return {}; }
};

/// The forward model of the path, whose parts must outlive it. Throws std::invalid_argument for what the
/// model cannot do: kCentroid unless kRays, no wavelength or aperture, a pupil that is no diffraction pupil.
std::unique_ptr<ForwardModel> make_forward_model(const LightPath& path,
                                                 const std::vector<Statistic>& statistics, int threads);

/// Unsmoothed statistics of the surface with `coefficients` [m], in the requested order. NaN where one does
/// not exist, each with a warning unless `warnings` is null. Throws as make_forward_model does.
Eigen::VectorXd focus_statistics(const LightPath& path, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads, Warnings* warnings);

/// Options for computing L at the pupil points of a model.
OperatorOptions focus_operator(FocusModel model, int threads);

/// True when the statistics of this model have derivatives without smoothing and need one solve only.
inline bool smooth_by_itself(FocusModel model) { return model != FocusModel::kRays; }

}  // namespace aberfit
