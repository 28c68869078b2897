#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "aberfit/forward/focus_forward.h"

namespace aberfit {

/// The way from coefficients to statistics and back, for one physics. Remembers the last point: a solver asks
/// for the derivatives where it has just asked for the values. For one caller at a time.
class ForwardModel {
 public:
  /// Takes d statistic k/d coefficients; may be called from several threads at once, for different k.
  using GradientSink = std::function<void(std::size_t k, const Eigen::VectorXd& gradient)>;

  virtual ~ForwardModel() = default;
  /// The surface with these coefficients [m] from now on.
  virtual void move_to(const Eigen::VectorXd& coefficients) = 0;
  /// Statistics there, smoothed over `width` [m] where the physics does not smooth by itself. False when one
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

/// The model of the scene's physics. The scene's parts must outlive it. Throws std::invalid_argument as
/// focus_statistics does.
std::unique_ptr<ForwardModel> make_forward_model(const FocusScene& scene,
                                                 const std::vector<Statistic>& statistics, int threads);

/// Whether the statistics of this physics have derivatives without smoothing: one solve at any width.
inline bool smooth_by_itself(FocusPhysics physics) { return physics != FocusPhysics::kRays; }

}  // namespace aberfit
