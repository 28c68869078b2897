#pragma once
#include <Eigen/Core>
#include <functional>

namespace aberfit::internal {

/// Image of a round spot, as FocalLight::image, from its encircled energy EE(r) [m -> share], which is asked
/// for at ascending radii. A pixel is the sum of nine parts, each with the mean irradiance of the annulus
/// through it that is as wide as the part.
Eigen::ArrayXXd round_image(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& encircled_energy,
                            double half_width, int pixels);

}  // namespace aberfit::internal
