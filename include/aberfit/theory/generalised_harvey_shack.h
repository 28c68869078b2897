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

/// The ensemble-mean spot in one plane, by its optical transfer function. Cheap to copy; const use from many
/// threads.
class MeanSpot {
 public:
  /// Share of the light within `radius` [m] of the axis: EE(r) = 2 pi r int OTF(nu) J1(2 pi nu r) dnu.
  double encircled_energy(double radius) const;
  /// dEE/dr [1/m] = 2 pi r times the mean irradiance.
  double encircled_energy_slope(double radius) const;
  /// Radius [m] that holds `fraction` of the light: Newton's method inside a bracket, to 1e-12. NaN for
  /// fractions outside (0, 1); infinity when less than `fraction` lies within r = f, where direction cosines
  /// end.
  double encircled_energy_radius(double fraction) const;
  /// Mean irradiance at `radius` >= 0 [m], of all light 1 [1/m^2].
  double irradiance(double radius) const;
  /// Its derivative over the radius [1/m^3].
  double irradiance_slope(double radius) const;
  /// Radius [m] of the highest irradiance of all, of light that is the same in all directions: 0 but for
  /// mirrors of revolution with aberrations of a wave or so. Rings as far out are looked at as there may be
  /// light enough for a higher one.
  double highest_radius() const;
  /// Share of the light in a square of `side` [m] about the axis, whose edge cuts circles at side/(2 cos(t)):
  ///   (4/pi) int_0^(pi/4) EE(side/(2 cos t)) dt,
  /// by Gauss-Legendre with twelve nodes and one for each 2 rad that v turns between the middle of an edge
  /// and a corner (512 at most). The light is symmetric or its mean over direction, which is the same as the
  /// mean over squares turned all ways.
  double ensquared_energy(double side) const;
  /// Its derivative over the side [1/m].
  double ensquared_energy_slope(double side) const;
  /// Full side [m] of the square about the axis that holds `fraction` of the light, to 1e-12: it lies between
  /// sqrt2 and 2 of the encircled energy radius. NaN and infinity as of that.
  double ensquared_side(double fraction) const;
  /// Full width [m] at half maximum of the irradiance: twice the radius at which it first falls to half of
  /// the largest that lies further in, to 1e-12. In the focus of a mirror without aberrations that largest
  /// one is on the axis. It is looked for in steps of a quarter of lambda N or of 1/64 of the spot, whichever
  /// is longer: rings that are finer, far out of focus, may be stepped over. NaN where it never falls so far
  /// within r = f.
  double fwhm() const;
  /// Transfer function at frequency nu >= 0 of the image [cycles/m], as `GeneralisedHarveyShack::transfer`.
  double transfer(double nu) const;
  /// 2 int OTF OTF' OTF_air^2 s ds over s = shear/cutoff in [0, 1] with the transfer function of `other`
  /// light in the same pupil; OTF_air = exp(-3.44 (x/r0)^(5/3)) of shears x [m] in the focus. r0 > 0 [m].
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
  double cutoff_ = 0;  // shear where the transfer function ends [m]
  double guess_ = 0;   // radius of the order of the spot [m]
};

struct GhsOptions {
  int halvings = 0;  ///< further halvings of every quadrature panel: checks convergence
  /// Height [m] at x, y [m] on top of the mirror's own surface; with the mirror's own departure from the
  /// parabola it is the aberration whose spot the roughness spreads. May be empty.
  std::function<double(double, double)> departure = {};
};

/// What predictions of many PSDs share: the scene without its roughness, with what has been computed of it -
/// plane by plane the pupil's autocorrelation, half of the work in the focus and nearly all of it elsewhere.
/// Predictions are to the last bit those of a pupil of their own. Cheap to copy, copies share; const use from
/// many threads.
class GhsPupil {
 public:
  /// Throws as GeneralisedHarveyShack does of mirrors and apertures.
  GhsPupil(const Mirror& mirror, const Aperture& aperture, const Light& light,
           const GhsOptions& options = {});

  const Mirror& mirror() const { return mirror_; }
  const Aperture& aperture() const { return aperture_; }
  double wavelength() const { return wavelength_; }  ///< mean [m]
  const Light& light() const { return light_; }
  /// The same aperture and light with a parabola of that focal length, its segments in their places; what has
  /// been computed is shared where it is one already.
  GhsPupil of_parabola() const;
  /// The same with its segments in their places; shared where they are.
  GhsPupil with_segments_in_place() const;
  /// Whether the light has aberrations and is not the same in all directions, of a mirror or an aperture that
  /// is none of revolution: then its highest irradiance is not known from its mean over direction.
  bool has_uneven_light() const;
  /// What was added to the mirror; may be empty.
  const std::function<double(double, double)>& departure() const { return options_.departure; }

 private:
  friend class GeneralisedHarveyShack;
  Mirror mirror_;
  Aperture aperture_;
  Light light_;
  double wavelength_ = 0;
  GhsOptions options_;
  std::shared_ptr<const internal::PupilMoments> moments_;
  std::vector<GhsPupil> lines_;  // of a band: one for each wavelength
};

/// Generalised Harvey-Shack prediction of the ensemble-mean spot of a rough mirror (PHYSICS 6; Krywonos,
/// Harvey and Choi 2011 at normal incidence), exact for a stationary Gaussian surface in scalar diffraction
/// at small scatter angles. In its aperture-exact form, the default, with P the position in the pupil and x =
/// lambda (f + dz) nu the shear, both f times a direction cosine [m],
///   OTF(x) = int A(P + x/2) A*(P - x/2) H(P, x) d2P / int |A|^2 d2P,
///   H = exp(-(4 pi/lambda)^2 (q1 q2 (C(0) - C(dr)) + (q1 - q2)^2 V/2)),  q = 1/(1 + t^2), t = r/2f,
/// at the two points; see ExactTransfer in src/theory for A, dr and V. Every aperture and every mirror: the
/// pupil field A holds conic, spherical terms, `departure` and the defocus; planes and centre are those of
/// the nominal focus f. Of pupils without symmetry the real part, averaged over azimuth. The physical law of
/// reflection: for convention `paper` give it the PSD of half the heights. Frequencies above 1/lambda do not
/// scatter and are cut off. Where the height variance diverges towards f = 0 (power laws) the structure
/// function takes the place of the autocorrelation, and no specular core is left. Error of encircled
/// energies: below 1e-9 of circles and annuli with rotational symmetry (interpolation of H over the aperture:
/// 2e-6 of it; H of pairs of points: 3e-5 from f/1.5 on, 1.2e-4 at f/1, 1.3e-3 at f/0.5), below 1e-4 of all
/// others, beside the error of the theory itself, see `theory_error`. Phases whose slope takes more
/// than 2 GB of cells, some 1000 waves over the aperture, are refused (20,000 of round pupils). Where f_max x
/// exceeds 100 cycles within the aperture the band edge is softened by 1 %: at such shears the
/// autocorrelation is that of S cos^4(pi f / (2 f_max)). Const use from many threads.
class GeneralisedHarveyShack {
 public:
  /// Of a band all light is the sum of its lines' by their shares; what is no property of light in the focal
  /// plane (g, cut_share, surface_transfer, overlap_transfer) is of the mean wavelength. Throws
  /// ComputationError where the structure function is infinite (PSDs as steep as
  /// f^-4 at f = 0), where the aperture reaches 45 degrees on the mirror or the mirror has no sag; in the
  /// paraxial form for mirrors that are not parabolas.
  GeneralisedHarveyShack(const RadialPsd& psd, const Mirror& mirror, const Aperture& aperture,
                         const Light& light, const GhsOptions& options = {});
  /// The same of a scene that other PSDs have been predicted of; prefer it for more than one.
  GeneralisedHarveyShack(const RadialPsd& psd, const GhsPupil& pupil);
  ~GeneralisedHarveyShack();
  GeneralisedHarveyShack(GeneralisedHarveyShack&&) noexcept;
  GeneralisedHarveyShack& operator=(GeneralisedHarveyShack&&) noexcept;

  /// The spot in the plane z = f + dz. Wave aberration of the defocus: dz (1 - cos theta)/(1 + dz/f), and the
  /// spot grows by 1 + dz/f. Prefer it to the shortcuts below for more than one value in a plane; it costs
  /// milliseconds, tenths of a second for a pupil without symmetry and far out of focus. Throws
  /// ComputationError where dz is not finite or f + dz is not above zero, as does all that asks for such a
  /// plane, and where the phase is too steep.
  MeanSpot at_plane(double dz) const;  ///< remembers the first hundred planes
  double encircled_energy(double radius, double dz) const { return at_plane(dz).encircled_energy(radius); }
  double encircled_energy_radius(double fraction, double dz) const {
    return at_plane(dz).encircled_energy_radius(fraction);
  }
  /// Full width [m] over dz at which N(z) = encircled_energy(ring_radius, dz) falls to half of its peak, the
  /// highest wherever it lies: where aberrations put it, of annuli on both sides of the focus, and a little
  /// nearer to the mirror than that, as the image grows with its distance. Between the crossings nearest to
  /// it, to 1e-9 (1e-6 of pupils without symmetry, 1e-5 with aberrations). NaN when ring_radius is not
  /// positive, or |dz| would exceed f/2.
  double ring_fwhm(double ring_radius) const;
  /// The plane dz where a ring holds most, and those on either side where it holds half of that [m].
  struct RingPlanes {
    double lower, peak, upper;
  };
  RingPlanes ring_planes(double ring_radius) const;
  /// Whether the mirror is another than its parabola, so that one side of the focus is not as the other.
  bool departs() const;
  /// FWHM [m] of the line spread profile int OTF(nu) cos(2 pi nu x) dnu in the focus, averaged over direction
  /// and convolved with a Gaussian of standard deviation `bandwidth` [m]. With much specular light this is
  /// the width of the diffraction pattern.
  double spot_fwhm(double bandwidth) const;
  /// Geometric RMS and mean scatter angle [rad], as GeometricHarveyShack: the mean-square angle of waves
  /// diverges logarithmically at every sharp pupil edge, so the second moment of the rays is what the two
  /// have in common. Throw ComputationError when the slope variance is infinite.
  double scatter_rms() const;
  double scatter_mean() const;

  const RadialPsd& psd() const { return whole_; }
  const GhsPupil& pupil() const { return pupil_; }
  /// The same at each wavelength of a band; empty for one wavelength.
  const std::vector<std::shared_ptr<const GeneralisedHarveyShack>>& lines() const { return lines_; }
  double rms_height() const { return rms_height_; }  ///< of the whole PSD [m]
  double g() const {
    return g_;
  }  ///< 4 pi sigma/lambda, sigma of the frequencies that scatter; may be infinite
  /// Share of the height variance at frequencies above 1/lambda, which do not scatter.
  double cut_share() const { return cut_share_; }
  double core_share() const { return core_; }  ///< specular light: exp(-g^2), averaged over the aperture
  double tis() const;                          ///< total integrated scatter 1 - core_share
  /// Angle-spread function: scattered light (without the specular core) per unit of direction-cosine area at
  /// angle theta [rad] from the specular direction, in the focus [1/sr]; times cos(theta) it is per solid
  /// angle. Its integral 2 pi int ASF sin d(sin) is `tis`. Direction cosines keep it shift-invariant beyond
  /// 10 degrees; the obliquity factor and polarisation are left out, which limits it to some 30 degrees and g
  /// theta^2 << 1.
  double angle_spread(double theta) const;
  /// exp(-E) at pupil shear x >= 0 [m], averaged over the aperture, and the transfer function in a plane.
  double surface_transfer(double x) const;
  /// The same at many x, ascending, averaged over the part of the aperture that overlaps its copy: of a
  /// mirror without aberrations the transfer function in the focus over that without roughness.
  Eigen::ArrayXd overlap_transfer(const Eigen::ArrayXd& x) const;
  double transfer(double x, double dz) const;
  /// Largest part of the transfer function that the panels could not resolve; 0 as a rule.
  double unresolved() const;

  /// Any statistic by its description. RmsRadius throws ComputationError: the second moment of the
  /// diffraction pattern diverges.
  double operator()(const Statistic& statistic) const;
  /// Many statistics in their order, each plane set up once; prefer it for a whole study. The same values as
  /// one by one, whatever the number of threads. Throws as one by one.
  /// curve_slope, when given: r dE/dr [1] at each encircled-energy radius, NaN for other statistics.
  Eigen::VectorXd predict(const std::vector<Statistic>& statistics, int threads = 1,
                          Eigen::VectorXd* curve_slope = nullptr) const;

 private:
  friend class JacobianOfGhs;
  Eigen::ArrayXd exponent(const Eigen::ArrayXd& x) const;
  MeanSpot make_plane(double dz) const;
  MeanSpot empty_plane(double dz) const;
  /// What E, and with it every transfer function, changes by with p, times `scale`: of each line of a band.
  using SurfaceChange = std::vector<internal::ExponentChange>;
  SurfaceChange change_of(const PsdDerivative& derivative, double scale) const;
  internal::ExponentChange change_of_line(const PsdDerivative& derivative, double scale) const;
  /// What E at great shears changes by.
  double limit_change(const PsdDerivative& derivative, double scale) const;
  /// What (q1 - q2)^2/2 is multiplied by, of a PSD or a change of one. moment: 2 pi int_a^b f^(power + 1) S
  /// df.
  double of_uneven_paths(const std::function<double(double power, double a, double b)>& moment) const;
  /// What the specular share changes by.
  double core_change(const PsdDerivative& derivative, double scale) const;
  /// Of what scatters: the edge at 1/lambda stays where it is.
  PsdDerivative scattering(const PsdDerivative& derivative) const;
  /// Its encircled energies are the changes of those of at_plane(dz).
  MeanSpot change_at_plane(const SurfaceChange& change, double dz) const;
  /// The focal transfer function of a line spread smoothed by a Gaussian of standard deviation `bandwidth`.
  internal::RadialTransform line_spread(double bandwidth, const SurfaceChange* change) const;
  double cutoff() const;
  bool is_band() const { return !lines_.empty(); }
  double share(std::size_t line) const;
  double mean_of_lines(const std::function<double(const GeneralisedHarveyShack& line)>& of) const;
  double highest_frequency() const;  ///< of the image in the focus [cycles/m]
  /// The sum of the lines' transfer functions by their shares, over that of the shortest one's cutoff.
  MeanSpot sum_of_lines(double dz, const std::function<MeanSpot(std::size_t line)>& spot) const;

  GhsPupil pupil_;
  RadialPsd whole_, psd_;  // psd_: of the frequencies that scatter
  Mirror mirror_;
  Aperture aperture_;
  double wavelength_ = 0;
  double rms_height_ = 0, slope_ = 0, g_ = 0, core_ = 0, cut_share_ = 0;
  std::unique_ptr<const internal::ExactTransfer> exact_;
  std::vector<std::shared_ptr<const GeneralisedHarveyShack>> lines_;  // of a band
  struct Planes;
  std::unique_ptr<Planes> planes_;
};

}  // namespace aberfit
