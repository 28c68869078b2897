#pragma once
#include "aberfit/forward/forward_model.h"

namespace aberfit::internal {

/// Warning for points `pitch` [m] apart, in rows and columns, with fewer than two per cycle of these terms. A
/// wave of the surface then aliases to a longer one. Phase steps between cells may be small all the same (no
/// `psf-aliased`), and all rays may meet the wave at one phase.
std::optional<Warning> undersampled(const TermSet& terms, double pitch);

/// Statistics of the traced rays: coefficients -> L -> trace -> smooth statistics, one adjoint pass each.
/// Scatter tilts each ray by its own slope, the same for every surface.
class RayForward : public ForwardModel {
 public:
  RayForward(const LightPath& path, std::vector<Statistic> statistics, int threads);
  void move_to(const Eigen::VectorXd& coefficients) override;
  bool evaluate(double width, Eigen::VectorXd* values) override;
  bool gradients(const GradientSink& sink) override;
  Eigen::VectorXd exact(Warnings* warnings) override;
  std::string trouble() const override;

  const SurfaceField& field() const { return field_; }  ///< surface of the last point

 private:
  /// Sends d statistic/d coefficients of every ray gradient to `sink`.
  void pull_back(const std::vector<const RayGradient*>& gradients, const GradientSink& sink) const;

  const SurfaceField& whole_field() const { return known_.size() > 0 ? whole_ : field_; }

  LightPath path_;
  std::vector<Statistic> statistics_;
  int threads_;
  RayBundle nominal_;
  FocusInput input() const;

  // Constant field at the pupil points: the known Zernikes of the mirror and the slopes of its scatter.
  // of_revolution_ is the rest of the mirror.
  Mirror of_revolution_;
  SurfaceField known_, whole_;  // empty without any; whole_: field_ + known_
  SurfaceField field_;
  RayBundle rays_;
  FocusWorkspace workspace_;
  std::vector<StatisticGradient> gradients_;
  SurfaceField height_weights_;  // zero slopes, for statistics of the height alone
};

}  // namespace aberfit::internal
