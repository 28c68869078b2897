#include "aberfit/forward/forward_model.h"

#include <stdexcept>

#include "convolved_forward.h"
#include "ray_forward.h"
#include "wave_forward.h"

namespace aberfit {

std::unique_ptr<ForwardModel> make_forward_model(const FocusScene& scene,
                                                 const std::vector<Statistic>& statistics, int threads) {
  if (scene.physics == FocusPhysics::kRays) return std::make_unique<RayForward>(scene, statistics, threads);
  if (!scene.aperture || !(scene.wavelength > 0))
    throw std::invalid_argument("statistics of a diffracted spot need a wavelength and an aperture");
  if (scene.centre != Centre::kNominal)
    throw std::invalid_argument(
        "statistics of a diffracted spot are about the nominal focus, not about the centroid");
  if (scene.physics == FocusPhysics::kWaves) return std::make_unique<WaveForward>(scene, statistics, threads);
  return std::make_unique<ConvolvedForward>(scene, statistics, threads);
}

Eigen::VectorXd focus_statistics(const FocusScene& scene, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads, Warnings* warnings) {
  const std::unique_ptr<ForwardModel> model = make_forward_model(scene, statistics, threads);
  model->move_to(coefficients);
  return model->exact(warnings);
}

PsfImage focus_psf(const FocusScene& scene, const Eigen::VectorXd& coefficients, const PsfWindow& window) {
  if (scene.physics != FocusPhysics::kWaves)
    throw std::invalid_argument("only waves have a diffraction pattern of the whole surface");
  const std::unique_ptr<ForwardModel> model = make_forward_model(scene, {}, 1);
  model->move_to(coefficients);
  return static_cast<const WaveForward&>(*model).psf(window);
}

}  // namespace aberfit
