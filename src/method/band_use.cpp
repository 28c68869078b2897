#include "aberfit/method/band_use.h"

#include <algorithm>
#include <cmath>

namespace aberfit {

BandUse band_use(const Task& task, const Groundwork& ground, const TermSet& terms, Eigen::Index rays) {
  BandUse band;
  const RadialPsd& psd = *ground.term_psd;
  band.modelled_f_min = psd.f_min();
  band.modelled_f_max = psd.f_max();
  band.limited_by = "specification";
  const auto cut = [&](double frequency, const char* by) {
    if (frequency < band.modelled_f_max) band.modelled_f_max = frequency, band.limited_by = by;
  };
  if (terms.fourier.empty()) {
    const int order = terms.zernike.empty() ? 0 : terms.zernike.back().n;
    cut(zernike_cutoff(order, ground.radius), "zernike");
  } else {
    // A plane wave represents a cell of frequencies; the band ends where the farthest cell ends.
    double highest = 0;
    for (const FourierMode& mode : terms.fourier) highest = std::max(highest, std::hypot(mode.fx, mode.fy));
    if (task.terms.fourier && task.terms.fourier->sampling == FourierSampling::kLog) highest = psd.f_max();
    cut(highest, "fourier");
  }
  cut(0.5 * std::sqrt(double(rays) / aperture_area(task.aperture)), "rays");
  band.modelled_f_max = std::max(band.modelled_f_max, psd.f_min());
  const PsdMoments all = psd_moments(psd);
  // The left-out part itself, because the difference of two nearly equal numbers loses digits.
  if (band.modelled_f_max < psd.f_max()) {
    const PsdMoments rest = psd_moments(psd.band(band.modelled_f_max, psd.f_max()));
    band.left_out_height_share = rest.height_variance / all.height_variance;
    band.left_out_slope_share = rest.slope_variance / all.slope_variance;
  }
  band.ee90_change = std::sqrt(std::max(0.0, 1 - band.left_out_slope_share)) - 1;
  return band;
}

}  // namespace aberfit
