#pragma once
#include <optional>

#include "aberfit/trace/ray_bundle.h"

namespace aberfit {

/// Full width at half maximum of N(z), the share of light inside a ring of fixed radius about the nominal
/// axis or the centroid of z = f.
struct RingWidth {
  double fwhm = 0;                  ///< [m]
  double lower = 0, upper = 0;      ///< half-maximum crossings next to the peak, dz [m]
  double peak = 0, peak_share = 0;  ///< where N is largest, and its value
  int crossings = 2;  ///< of the half-maximum level inside the search range; more than 2: several peaks
};

/// N counted exactly on a fine grid of planes (each ray gives one interval of z, binned once), crossings
/// interpolated: relative error below 1e-5. Nothing when N does not fall to half on both sides within a
/// hundred ring/slope lengths.
std::optional<RingWidth> exact_ring_width(const RayBundle& rays, double ring_radius, double centre_x,
                                          double centre_y);

/// The smooth twin: N with the kernel integral of half-width `width` in radius, its peak and crossings by
/// root finding. When `gradient` is given, appends d fwhm at fixed ring radius; d_ring is d fwhm / d
/// ring_radius.
std::optional<RingWidth> smooth_ring_width(const RayBundle& rays, double ring_radius, double centre_x,
                                           double centre_y, double width, RayGradient* gradient,
                                           double* d_ring);

}  // namespace aberfit
