#include "aberfit/theory/scattering_band.h"

#include <cmath>

#include "aberfit/roughness/psd_integrals.h"

namespace aberfit {
namespace {

constexpr double kNothing = 1e-12;
constexpr double kWiderThanMirrors = 1e-3;  // [cycles/m]

}  // namespace

ScatteringBand scattering_band(const RadialPsd& psd, double wavelength) {
  const double edge = 1 / wavelength;
  ScatteringBand result{psd, std::sqrt(radial_moment(psd, 0)), 0};
  if (!(psd.f_max() > edge)) return result;
  double all = result.rms_height * result.rms_height;
  if (!std::isfinite(all)) all = radial_moment(psd, 0, kWiderThanMirrors);
  const double cut = radial_moment(psd, 0, edge);
  if (!(cut > kNothing * all)) return result;
  result.psd = psd.band(0, edge);
  result.rms_height = std::sqrt(radial_moment(result.psd, 0));
  result.cut_share = std::isfinite(cut) ? cut / all : 1;
  return result;
}

}  // namespace aberfit
