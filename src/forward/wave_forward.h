#pragma once
#include <memory>

#include "aberfit/forward/forward_model.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/transfer_image.h"
#include "height_blocks.h"
#include "moment_rays.h"

namespace aberfit::internal {

/// Statistics of the diffraction pattern of the pupil field: coefficients -> L -> phase -> PSF. The width of
/// `evaluate` is not used, because diffraction smooths by itself. Scatter angles and the RMS height come from
/// rays, exact for the order of the terms on any grid (MomentRays), plus those of the scatter. Waves have no
/// finite second moment, because a sharp edge scatters as 1/r^3.
class WaveForward : public ForwardModel {
 public:
  WaveForward(const LightPath& path, const std::vector<Statistic>& statistics, int threads);
  void move_to(const Eigen::VectorXd& coefficients) override;
  bool evaluate(double width, Eigen::VectorXd* values) override;
  bool gradients(const GradientSink& sink) override;
  Eigen::VectorXd exact(Warnings* warnings) override;
  std::string trouble() const override { return trouble_; }
  std::string unreachable(const std::vector<Target>& targets) const override;
  TransferImage transfer(double dz, int most_lags) {
    return diffraction_transfer(problem(), height(), dz, most_lags);
  }
  Eigen::ArrayXXd pixels(double dz, double half_width, int count) {
    return diffraction_pixels(problem(), height(), dz, half_width, count);
  }

 private:
  DiffractionProblem problem() const {
    return {diffraction_pupil_,    path_.mirror.focal_length,
            path_.wavelength,      path_.aliased_limit,
            path_.scatter,         departure_.size() > 0 ? &departure_ : nullptr,
            path_.single_precision};
  }
  void explain(const Eigen::VectorXd& values, Warnings* warnings);
  Eigen::VectorXd no_moments() const { return Eigen::VectorXd::Zero(Eigen::Index(split_.geometric.size())); }
  const Eigen::ArrayXd& height();  // heights of the mirror with its terms

  LightPath path_;
  int threads_;
  SplitStatistics split_;
  std::unique_ptr<MomentRays> moments_;  // of split_.geometric, on separate points; null without any, and
                                         // where all roughness scatters
  std::unique_ptr<const HeightBlocks> blocks_;  // for derivatives; null: cell by cell
  SurfaceField field_;
  DiffractionPupil diffraction_pupil_;
  Eigen::ArrayXd departure_;  // departure of the mirror from a parabola [m], empty for parabolas
  DiffractionWorkspace own_workspace_;
  DiffractionWorkspace& workspace_;
  Eigen::VectorXd coefficients_;
  bool known_ = false;  // height_ belongs to coefficients_
  Eigen::ArrayXd height_;
  std::string trouble_;
};

}  // namespace aberfit::internal
