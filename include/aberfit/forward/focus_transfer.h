#pragma once
#include "aberfit/forward/forward_model.h"
#include "aberfit/waves/transfer_image.h"

namespace aberfit {

/// The transfer function in the plane z = f + dz [m] of the surface with `coefficients` [m], by kWaves.
/// Throws std::invalid_argument for another model, and as diffraction_transfer does.
TransferImage focus_transfer(const LightPath& path, const Eigen::VectorXd& coefficients, double dz,
                             int most_lags);

/// Energy fraction per pixel of that surface's image, see diffraction_pixels. Throws as above.
Eigen::ArrayXXd focus_pixels(const LightPath& path, const Eigen::VectorXd& coefficients, double dz,
                             double half_width, int pixels);

}  // namespace aberfit
