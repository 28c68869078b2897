#pragma once
#include <Eigen/Core>
#include <functional>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// Image of a round spot, as FocalLight::image, from its encircled energy EE(r) [m -> share], which is asked
/// for at ascending radii. A pixel is the sum of nine parts, each with the mean irradiance of the annulus
/// through it that is as wide as the part.
Eigen::ArrayXXd round_image(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& encircled_energy,
                            double half_width, int pixels);

/// Share of the light of a round spot inside a radius [m], and its derivative [1/m].
using RoundSpot = std::function<MeanScatter::Encircled(double radius)>;

/// The image of a spot of which cells of a pupil have one period: what `mean`, its mean over surfaces, has
/// beyond the field of view [m] comes into `periodic` from the other side. It is taken off there, in the mean
/// over surfaces all of it, and put where it belongs. periodic: as FocalLight::image of that half width [m],
/// nothing beyond the field of view. Nowhere below zero.
Eigen::ArrayXXd unfolded(const Eigen::ArrayXXd& periodic, const RoundSpot& mean, double field_of_view,
                         double half_width);

}  // namespace aberfit::internal
