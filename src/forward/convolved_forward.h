#pragma once
#include "aberfit/theory/convolved_focus.h"
#include "aberfit/forward/forward_model.h"
#include "ray_forward.h"
#include "split_statistics.h"

namespace aberfit {

/// Statistics of the traced rays, each spread by the diffraction pattern of the aperture. Scatter angles, RMS
/// height and the FWHM of the line spread profile, whose Gaussian kernel stands for the pattern, are those of
/// the rays. The pattern smooths: the width of `evaluate` reaches the statistics of the rays only.
class ConvolvedForward : public ForwardModel {
 public:
  ConvolvedForward(const FocusScene& scene, const std::vector<Statistic>& statistics, int threads);
  void move_to(const Eigen::VectorXd& coefficients) override { rays_.move_to(coefficients); }
  bool evaluate(double width, Eigen::VectorXd* values) override;
  bool gradients(const GradientSink& sink) override;
  Eigen::VectorXd exact(Warnings* warnings) override;
  std::string trouble() const override { return trouble_; }
  std::string unreachable(const std::vector<Target>& targets) const override;

 private:
  bool rough_defocus(const Statistic& statistic, double value) const;

  int threads_;
  SplitStatistics split_;
  RayForward rays_;
  AperturePattern pattern_;
  double wavelength_, unit_;  // unit: lambda F [m]
  std::string trouble_;
};

}  // namespace aberfit
