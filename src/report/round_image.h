#pragma once
#include <Eigen/Core>
#include <functional>

#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// Image of a round spot, as FocalLight::image, from its encircled energy EE(r) [m -> fraction], evaluated at
/// ascending radii. detail: lambda (f + dz)/D [m], the period of the finest ripple that an aperture of
/// diameter D can make. Error of a pixel of any size: 1e-6 of the energy.
Eigen::ArrayXXd round_image(const std::function<Eigen::ArrayXd(const Eigen::ArrayXd&)>& encircled_energy,
                            double detail, double half_width, int pixels);

/// Fraction of the energy of a round spot inside a radius [m], and its derivative [1/m].
using RoundSpot = std::function<MeanScatter::Encircled(double radius)>;

/// Corrects the aliased image of a spot from a pupil grid. Energy beyond the field of view [m] appears in
/// `periodic` on the other side. Its mean over surfaces, known from `mean`, is subtracted there and added
/// at its true place. periodic: FocalLight::image of this half width [m], 0 beyond the field of view. The
/// result is nowhere negative. detail: as above.
Eigen::ArrayXXd unfolded(const Eigen::ArrayXXd& periodic, const RoundSpot& mean, double detail,
                         double field_of_view, double half_width);

}  // namespace aberfit::internal
