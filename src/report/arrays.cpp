#include "aberfit/report/arrays.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "aberfit/core/constants.h"
#include "focal_frame.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr int kRadii = 501;
constexpr int kFewestPixels = 129, kMostPixels = 513;  // odd, so that the centre is a pixel
constexpr int kFrequencies = 256;                      // for theory alone, up to the cutoff

// Pixels per side of a window: fine enough for Nyquist in wave optics, coarse enough to count rays.
int pixels_of(const ArrayInput& input, double half_width) {
  const bool counted =
      std::isfinite((input.surface ? input.surface : input.theory)->sample_size());  // random points
  if (counted) return kFewestPixels;
  const double nyquist =
      0.5 * input.wavelength * input.mirror.focal_length / (2 * aperture_radius(input.aperture));
  const double wanted = std::ceil(2 * half_width / nyquist);
  return int(std::clamp<double>(wanted, kFewestPixels, kMostPixels)) | 1;
}

// The largest radius of the curves.
double last_radius(const ArrayInput& input, const Eigen::ArrayXd& planes, double scale) {
  double last = 0;
  for (const FocalLight* light : {input.theory, input.surface})
    if (light)
      for (const double dz : planes)
        if (const double end = 1.2 * curve_end(*light, dz); std::isfinite(end)) last = std::max(last, end);
  return last > 0 ? last : 4 * scale;
}

LightArrays of_light(const FocalLight& light, const FocusArrays& axes) {
  LightArrays result;
  const Eigen::Index radii = axes.radius.size(), rings = radii - 1;
  result.encircled_energy.resize(axes.plane.size(), radii);
  for (Eigen::Index k = 0; k < axes.plane.size(); ++k)
    result.encircled_energy.row(k) = light.encircled_energy(axes.radius, axes.plane[k]).transpose();
  const Eigen::ArrayXd square = axes.radius.square();
  const Eigen::ArrayXd area = kPi * (square.tail(rings) - square.head(rings));
  result.ring_profile =
      (result.encircled_energy.rightCols(rings) - result.encircled_energy.leftCols(rings)).rowwise() /
      area.transpose();
  const double pixel = axes.pixel[1] - axes.pixel[0];
  const Eigen::Index pixels = axes.pixel.size();
  result.psf = light.image(0.0, 0.5 * double(pixels) * pixel, int(pixels)) / (pixel * pixel);
  return result;
}

}  // namespace

FocusArrays make_focus_arrays(const ArrayInput& input) {
  const FocalLight& reference = input.theory ? *input.theory : *input.surface;
  FocusArrays arrays;
  arrays.title = input.title;
  arrays.wavelength = input.wavelength;
  arrays.focal_length = input.mirror.focal_length;
  arrays.diameter = 2 * aperture_radius(input.aperture);
  std::set<double> planes(input.planes.begin(), input.planes.end());
  planes.insert(0.0);
  arrays.plane.resize(Eigen::Index(planes.size()));
  std::copy(planes.begin(), planes.end(), arrays.plane.begin());
  const double scale = spot_scale(input.core_sigma, {input.theory, input.surface});
  arrays.radius = Eigen::ArrayXd::LinSpaced(kRadii, 0.0, last_radius(input, arrays.plane, scale));
  const double half = image_half_width(reference.statistic(EncircledEnergyRadius{0.9, 0.0}), scale);
  const int pixels = pixels_of(input, half);
  const double pixel = 2 * half / pixels;
  arrays.pixel = Eigen::ArrayXd::LinSpaced(pixels, -half + 0.5 * pixel, half - 0.5 * pixel);

  if (input.theory) arrays.theory = of_light(*input.theory, arrays);
  if (input.surface) arrays.surface = of_light(*input.surface, arrays);
  if (input.surface) arrays.surface->otf = input.surface->transfer();
  // Theory uses the axis of the surface's OTF if there is one, so that the two can be compared.
  const double cutoff = arrays.diameter / (input.wavelength * input.mirror.focal_length);
  Eigen::ArrayXd frequency = Eigen::ArrayXd::LinSpaced(kFrequencies + 1, 0.0, cutoff);
  if (arrays.surface && arrays.surface->otf) {
    const TransferImage& otf = *arrays.surface->otf;
    frequency = otf.step * Eigen::ArrayXd::LinSpaced(otf.middle + 1, 0.0, double(otf.middle));
  }
  if (input.theory) arrays.theory->mtf = input.theory->round_transfer(frequency);
  if ((arrays.surface && arrays.surface->otf) || (arrays.theory && arrays.theory->mtf))
    arrays.frequency = frequency;
  if (input.rest)
    arrays.halo = halo_kernel(ScatterFunction(*input.rest, input.wavelength),
                              pixel / input.mirror.focal_length, pixels);
  return arrays;
}

}  // namespace aberfit
