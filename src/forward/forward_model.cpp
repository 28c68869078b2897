#include "aberfit/forward/forward_model.h"

#include <stdexcept>

#include "aberfit/forward/focus_transfer.h"
#include "ray_forward.h"
#include "wave_forward.h"

namespace aberfit {
using namespace internal;

std::unique_ptr<ForwardModel> make_forward_model(const LightPath& path,
                                                 const std::vector<Statistic>& statistics, int threads) {
  if (path.model == FocusModel::kRays) return std::make_unique<RayForward>(path, statistics, threads);
  if (!path.aperture || !(path.wavelength > 0))
    throw std::invalid_argument("statistics of a diffracted spot need a wavelength and an aperture");
  if (path.centre != Centre::kNominal)
    throw std::invalid_argument(
        "statistics of a diffracted spot are centred on the nominal focus, not on the centroid");
  return std::make_unique<WaveForward>(path, statistics, threads);
}

Eigen::VectorXd focus_statistics(const LightPath& path, const Eigen::VectorXd& coefficients,
                                 const std::vector<Statistic>& statistics, int threads, Warnings* warnings) {
  const std::unique_ptr<ForwardModel> model = make_forward_model(path, statistics, threads);
  model->move_to(coefficients);
  return model->exact(warnings);
}

namespace {

std::unique_ptr<WaveForward> waves_of(const LightPath& path, const Eigen::VectorXd& coefficients) {
  if (path.model != FocusModel::kWaves)
    throw std::invalid_argument("only wave optics has a diffraction pattern of the whole surface");
  std::unique_ptr<ForwardModel> model = make_forward_model(path, {}, 1);
  model->move_to(coefficients);
  return std::unique_ptr<WaveForward>(static_cast<WaveForward*>(model.release()));
}

}  // namespace

TransferImage focus_transfer(const LightPath& path, const Eigen::VectorXd& coefficients, double dz,
                             int most_lags) {
  return waves_of(path, coefficients)->transfer(dz, most_lags);
}

Eigen::ArrayXXd focus_pixels(const LightPath& path, const Eigen::VectorXd& coefficients, double dz,
                             double half_width, int pixels) {
  return waves_of(path, coefficients)->pixels(dz, half_width, pixels);
}

OperatorOptions focus_operator(FocusModel model, int threads) {
  OperatorOptions options;
  options.threads = threads;
  options.hold_at_rim = model == FocusModel::kWaves;
  return options;
}

}  // namespace aberfit
