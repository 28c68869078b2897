#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "aberfit/focus/statistic.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/light.h"
#include "aberfit/scene/mirror.h"

namespace aberfit {

class PsdDerivative;

namespace internal {
class ExactTransfer;
class PupilMoments;
class RadialTransform;
class ExponentChange;
struct TransferPanel;
}  // namespace internal

/// The ensemble-mean spot in one plane by its OTF. Copies are cheap; const use from many threads is safe.
class MeanSpot {
 public:
  /// Fraction of the energy within `radius` [m] of the axis: EE(r) = 2 pi r int OTF(nu) J1(2 pi nu r) dnu.
  double encircled_energy(double radius) const;
  /// dEE/dr [1/m]; it equals 2 pi r times the mean irradiance.
  double encircled_energy_slope(double radius) const;
  /// Radius [m] that holds `fraction` of the energy, to a relative 1e-12. NaN for fractions outside (0, 1).
  /// Infinity if it does not lie within r = f, where direction cosines end.
  double encircled_energy_radius(double fraction) const;
  /// Mean irradiance at `radius` >= 0 [m], for a total energy of 1 [1/m^2].
  double irradiance(double radius) const;
  /// Derivative of the irradiance over the radius [1/m^3].
  double irradiance_slope(double radius) const;
  /// Radius [m] of the highest irradiance of a spot that is the same in all directions. It is 0 without
  /// aberrations. The search ends when the remaining energy is too little for a higher ring.
  double highest_radius() const;
  /// Fraction of the energy in a square of `side` [m] about the axis, whose edge cuts circles of side/(2 cos
  /// t):
  ///   (4/pi) int_0^(pi/4) EE(side/(2 cos t)) dt.
  /// Gauss-Legendre with twelve nodes, and one more for each 2 rad of v between the middle of an edge and a
  /// corner (at most 512). Without symmetry it is the mean over squares turned all ways.
  double ensquared_energy(double side) const;
  /// Derivative of the ensquared energy over the side [1/m].
  double ensquared_energy_slope(double side) const;
  /// Full side [m] of the square about the axis that holds `fraction` of the energy, to a relative 1e-12. It
  /// lies between sqrt2 and 2 times the encircled energy radius. NaN and infinity as for that radius.
  double ensquared_side(double fraction) const;
  /// Full width [m] at half maximum of the irradiance, to a relative 1e-12. It is twice the radius at which
  /// the irradiance first falls to half of the largest value further in. The search steps by lambda N/4 or
  /// 1/64 of the spot, whichever is longer, so finer rings far out of focus may be missed. NaN where the
  /// irradiance does not fall to half within r = f.
  double fwhm() const;
  /// Transfer function at the image frequency nu >= 0 [cycles/m], as `GeneralisedHarveyShack::transfer`.
  double transfer(double nu) const;
  /// 2 int OTF OTF' OTF_air^2 s ds over s = shear/cutoff in [0, 1]. OTF' is the transfer function of `other`
  /// in the same pupil. OTF_air = exp(-3.44 (x/r0)^(5/3)) at shears x [m] in the focus. r0 > 0 [m].
  double seen_through_air(const MeanSpot& other, double r0) const;

 private:
  friend class GeneralisedHarveyShack;
  friend class JacobianOfGhs;
  struct Share {
    double value = 0, derivative = 0;  // over v
  };
  Share share(double v) const;
  double peak_radius() const;
  double summit_near(double radius, double step) const;
  double search_step() const;

  std::shared_ptr<const internal::RadialTransform> transform_;
  double v_per_radius_ = 0;  // v = 2 pi nu_cutoff r [1/m]
  double focal_length_ = 0;
  double cutoff_ = 0;  // shear at which the transfer function ends [m]
  double guess_ = 0;   // radius of the order of the spot [m]
};

struct GhsOptions {
  int halvings = 0;  ///< number of extra halvings of every quadrature panel, to check convergence
  /// Height [m] at x, y [m] that is added to the mirror's own surface; may be empty. Together with the
  /// mirror's departure from the parabola it is the aberration whose spot the roughness spreads.
  std::function<double(double, double)> departure = {};
};

/// The scene without its roughness, for predictions with many PSDs. It keeps the pupil's autocorrelation,
/// plane by plane. That saves half of the work in the focus and nearly all elsewhere, with identical results.
/// Copies are cheap and use the same memory; const use from many threads is safe.
class GhsPupil {
 public:
  /// Throws as GeneralisedHarveyShack does for mirrors and apertures.
  GhsPupil(const Mirror& mirror, const Aperture& aperture, const Light& light,
           const GhsOptions& options = {});

  const Mirror& mirror() const { return mirror_; }
  const Aperture& aperture() const { return aperture_; }
  double wavelength() const { return wavelength_; }  ///< mean [m]
  const Light& light() const { return light_; }
  /// The same aperture and source with a parabola of the same focal length and without segment errors. The
  /// copy keeps the computed autocorrelations if the mirror is such a parabola already.
  GhsPupil of_parabola() const;
  /// The same pupil without segment errors. The copy keeps what has been computed if there are none.
  GhsPupil with_segments_in_place() const;
  /// True if the mean spot has aberrations and differs with direction, because the mirror or the aperture is
  /// not one of revolution. Its highest irradiance then does not follow from its mean over direction.
  bool has_uneven_light() const;
  /// Height added to the mirror's surface; may be empty.
  const std::function<double(double, double)>& departure() const { return options_.departure; }

 private:
  friend class GeneralisedHarveyShack;
  Mirror mirror_;
  Aperture aperture_;
  Light light_;
  double wavelength_ = 0;
  GhsOptions options_;
  std::shared_ptr<const internal::PupilMoments> moments_;
  std::vector<GhsPupil> lines_;  // one pupil for each wavelength of a band
};

/// Generalised Harvey-Shack prediction of the ensemble-mean spot of a rough mirror (PHYSICS 6; Krywonos,
/// Harvey and Choi 2011, at normal incidence). It is exact for a stationary Gaussian surface in scalar
/// diffraction at small scatter angles. P is the position in the pupil and x = lambda (f + dz) nu the shear;
/// both are f times a direction cosine [m]:
///   OTF(x) = int A(P + x/2) A*(P - x/2) H(P, x) d2P / int |A|^2 d2P,
///   H = exp(-(4 pi/lambda)^2 (q1 q2 (C(0) - C(dr)) + (q1 - q2)^2 V/2)),  q = 1/(1 + t^2), t = r/2f,
/// with q1 and q2 at the two points. ExactTransfer in src/theory defines A, dr and V.
///
/// Valid for every aperture and every mirror. The pupil field A holds the conic, spherical terms, `departure`
/// and the defocus. Planes and centre refer to the nominal focus f. Pupils without symmetry give the real
/// part of the OTF, averaged over azimuth. Reflection follows the physical law; for convention `paper` pass
/// the PSD of half the heights. Frequencies above 1/lambda do not scatter and are cut off. Where the height
/// variance diverges towards f = 0 (power laws), the structure function replaces the autocorrelation and no
/// specular core remains. Where f_max x exceeds 100 cycles within the aperture, the band edge is softened by
/// 1 %: the autocorrelation at such shears is that of S cos^4(pi f / (2 f_max)).
///
/// Error of encircled energies for circles and annuli with rotational symmetry: below 1e-9, plus 2e-6
/// (relative) from the interpolation of H over the aperture. The two-point form of H adds 3e-5 from f/1.5 on,
/// 1.2e-4 at f/1 and 1.3e-3 at f/0.5. All other apertures: below 1e-4. The error of the theory itself comes
/// on top, see `theory_error`. Phases too steep for 2 GB of grid points, about 1000 waves over the aperture,
/// are refused (20,000 waves for round pupils). Const use from many threads is safe.
class GeneralisedHarveyShack {
 public:
  /// For a band the energy is the weighted sum over its wavelengths. Quantities that are not properties of
  /// the focal irradiance (g, cut_share, surface_transfer, overlap_transfer) refer to the mean wavelength.
  /// Throws ComputationError where the structure function is infinite (PSDs as steep as f^-4 at f = 0), where
  /// the aperture reaches 45 degrees on the mirror, or where the mirror has no sag.
  GeneralisedHarveyShack(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         const Light& light, const GhsOptions& options = {});
  /// The same for a pupil that other PSDs use, too. Prefer it for more than one PSD.
  GeneralisedHarveyShack(const RadialPsd& psd, const GhsPupil& pupil);
  ~GeneralisedHarveyShack();
  GeneralisedHarveyShack(GeneralisedHarveyShack&&) noexcept;
  GeneralisedHarveyShack& operator=(GeneralisedHarveyShack&&) noexcept;

  /// The spot in the plane z = f + dz. The wave aberration of the defocus is dz (1 - cos theta)/(1 + dz/f);
  /// the spot grows by 1 + dz/f. Prefer it to the shortcuts below for more than one value in a plane. It
  /// takes milliseconds; pupils without symmetry and planes far out of focus take tenths of a second. Throws
  /// ComputationError where dz is not finite, f + dz is not above zero or the phase is too steep.
  MeanSpot at_plane(double dz) const;  ///< keeps the first hundred planes
  double encircled_energy(double radius, double dz) const { return at_plane(dz).encircled_energy(radius); }
  double encircled_energy_radius(double fraction, double dz) const {
    return at_plane(dz).encircled_energy_radius(fraction);
  }
  /// Full width [m] over dz at which N(z) = encircled_energy(ring_radius, dz) falls to half of its highest
  /// peak. Aberrations move that peak; an annulus may have one on either side of the focus. The peak lies a
  /// little nearer to the mirror, because the image grows with its distance. The width is taken between the
  /// half crossings nearest to the peak, to 1e-9 (1e-6 for pupils without symmetry, 1e-5 with aberrations).
  /// NaN when ring_radius is not positive or |dz| would exceed f/2.
  double ring_fwhm(double ring_radius) const;
  /// Planes dz [m]: `peak`, where the ring holds most, and those with half of that on either side.
  struct RingPlanes {
    double lower, peak, upper;
  };
  RingPlanes ring_planes(double ring_radius) const;
  /// True if the mirror differs from its parabola, so that the two sides of the focus differ.
  bool departs() const;
  /// FWHM [m] of the line spread profile int OTF(nu) cos(2 pi nu x) dnu in the focus. The profile is averaged
  /// over direction and convolved with a Gaussian of standard deviation `bandwidth` [m]. With much specular
  /// energy this is the width of the diffraction pattern.
  double spot_fwhm(double bandwidth) const;
  /// RMS and mean scatter angle [rad] of geometric rays, as GeometricHarveyShack. In wave optics the
  /// mean-square angle diverges logarithmically at every sharp pupil edge, so only the ray value is
  /// comparable. Throw ComputationError when the slope variance is infinite.
  double scatter_rms() const;
  double scatter_mean() const;

  const RadialPsd& psd() const { return whole_; }
  const GhsPupil& pupil() const { return pupil_; }
  /// One prediction per wavelength of a band; empty for one wavelength.
  const std::vector<std::shared_ptr<const GeneralisedHarveyShack>>& lines() const { return lines_; }
  double rms_height() const { return rms_height_; }  ///< RMS height of the whole PSD [m]
  double g() const {
    return g_;
  }  ///< 4 pi sigma/lambda, sigma [m] over the frequencies that scatter; may be infinite
  /// Fraction of the height variance at frequencies above 1/lambda, which do not scatter.
  double cut_share() const { return cut_share_; }
  double core_share() const { return core_; }  ///< specular fraction exp(-g^2), averaged over the aperture
  double tis() const;                          ///< total integrated scatter 1 - core_share
  /// exp(-E) at the pupil shear x >= 0 [m], averaged over the aperture.
  double surface_transfer(double x) const;
  /// The same at ascending shears x [m], averaged over the overlap of the aperture with its copy. For a
  /// mirror without aberrations it is the focal transfer function over the one without roughness.
  Eigen::ArrayXd overlap_transfer(const Eigen::ArrayXd& x) const;
  double transfer(double x, double dz) const;
  /// Largest part of the transfer function that the panels could not resolve; normally 0.
  double unresolved() const;

  /// Any statistic by its description. RmsRadius throws ComputationError: its second moment diverges.
  double operator()(const Statistic& statistic) const;
  /// Many statistics, in their order; each plane is set up once. Prefer it for a whole study. Values and
  /// exceptions are those of single calls, for any number of threads. curve_slope, when given: r dE/dr [1] at
  /// each encircled-energy radius, NaN for other statistics.
  Eigen::VectorXd predict(const std::vector<Statistic>& statistics, int threads = 1,
                          Eigen::VectorXd* curve_slope = nullptr) const;

 private:
  friend class JacobianOfGhs;
  Eigen::ArrayXd exponent(const Eigen::ArrayXd& x) const;
  MeanSpot make_plane(double dz) const;
  MeanSpot empty_plane(double dz) const;
  /// Change of E, and so of all transfer functions, with the parameter p, times `scale`; per wavelength.
  using SurfaceChange = std::vector<internal::ExponentChange>;
  SurfaceChange change_of(const PsdDerivative& derivative, double scale) const;
  internal::ExponentChange change_of_line(const PsdDerivative& derivative, double scale) const;
  /// Change of E at great shears.
  double limit_change(const PsdDerivative& derivative, double scale) const;
  /// Factor of (q1 - q2)^2/2 in E, for a PSD or a change of one. moment: 2 pi int_a^b f^(power + 1) S df.
  double of_uneven_paths(const std::function<double(double power, double a, double b)>& moment) const;
  double core_change(const PsdDerivative& derivative, double scale) const;
  /// The derivative of the part that scatters: the edge at 1/lambda stays where it is.
  PsdDerivative scattering(const PsdDerivative& derivative) const;
  /// A spot whose encircled energies are the changes of those of at_plane(dz).
  MeanSpot change_at_plane(const SurfaceChange& change, double dz) const;
  /// The focal transfer function of a line spread that a Gaussian of standard deviation `bandwidth` smooths.
  internal::RadialTransform line_spread(double bandwidth, const SurfaceChange* change) const;
  double cutoff() const;
  bool is_band() const { return !lines_.empty(); }
  double share(std::size_t line) const;
  double mean_of_lines(const std::function<double(const GeneralisedHarveyShack& line)>& of) const;
  double highest_frequency() const;  ///< highest frequency of the image in the focus [cycles/m]
  /// The weighted sum of the transfer functions of all wavelengths, over the cutoff of the shortest one.
  MeanSpot sum_of_lines(double dz, const std::function<MeanSpot(std::size_t line)>& spot) const;

  GhsPupil pupil_;
  RadialPsd whole_, psd_;  // psd_: the frequencies that scatter
  Mirror mirror_;
  Aperture aperture_;
  double wavelength_ = 0;
  double rms_height_ = 0, slope_ = 0, g_ = 0, core_ = 0, cut_share_ = 0;
  std::unique_ptr<const internal::ExactTransfer> exact_;
  std::vector<std::shared_ptr<const GeneralisedHarveyShack>> lines_;  // one per wavelength of a band
  struct Planes;
  std::unique_ptr<Planes> planes_;
};

}  // namespace aberfit
