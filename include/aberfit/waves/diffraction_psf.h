#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/core/warning.h"
#include "aberfit/focus/statistic.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/light.h"
#include "aberfit/scene/pupil.h"

namespace aberfit {

/// In place of a focal length: pupil grids and phases to first order in the aperture.
inline constexpr double kParaxial = std::numeric_limits<double>::infinity();

/// Cells of an aperture, squares in P = f (direction cosine) = r/(1 + t^2), t = r/2f: equal steps of P are
/// what a transform to the focal plane needs, exactly, where equal steps on the mirror are off by t^2 at the
/// rim (PHYSICS 6). A surface is known where the light of their centres meets the mirror; light passes
/// through the clear part of each. In a paraxial pupil P is the place on the mirror.
struct DiffractionPupil {
  /// Points on the mirror of the cells that let light through (`structure` is a DirectionGrid, in a paraxial
  /// pupil a CartesianGrid), so that a SurfaceOperator or a trace works on the same points; weight: share of
  /// the mirror's clear area. Centres of edge cells may lie up to 0.71 pitch outside the aperture.
  PupilSample sample;
  Eigen::ArrayXd cover;  ///< clear share of each of these cells, in (0, 1]
  /// What a cell adds to a sum that stands for an integral over P: `cover`, corrected at edges so that the
  /// sum is right to third order in the pitch (edge cells may come out slightly negative), times the root of
  /// d2r/d2P = (1 + t^2)^3/(1 - t^2), so that the energy of a cell is its area on the mirror.
  Eigen::ArrayXd amplitude;
  Eigen::ArrayXd obliquity;         ///< 1/(1 + t^2): a height h is a path of 2h times this
  double total = 0;                 ///< clear area of the mirror, in cells: all light
  double pitch_x = 0, pitch_y = 0;  ///< of P [m]
  double missing = 0;  ///< share of the aperture's area where a map has no heights: taken as opaque
};

/// Cells a side of a pupil grid, at most.
inline constexpr int kMostCells = 16384;

/// Square cells of side `pitch` [m], centred on the bounding box of the aperture as P has it, for a parabola
/// of this focal length [m] or kParaxial. The clear share of a cell is its common area with the aperture
/// there (margin not taken off: light passes there, too): exact for circles and annuli; straight edges, which
/// are arcs of ellipses in P, as chords of a quarter of a cell. Relative error of EE50, EE80 and EE90 of a
/// full circle N cells across, against the Airy pattern:
///   N =  32  2e-7, 2e-6, 1.4e-5 with `amplitude`;  2e-4, 2e-3, 7e-3 with `cover`;  5e-3 with cells in or out
///   N = 128  8e-10, 3e-8, 2.3e-7;                  2e-5, 1.2e-4, 5e-4;              1e-3
/// falling as N^-4, N^-2 and erratically. Throws ComputationError for a pitch that gives more than 16384
/// cells a side, and for an aperture radius of 1.9 focal lengths or more (light from 87 degrees).
/// shift: of all cells along x and y, in cells, each up to a half: another sample of the same pupil.
DiffractionPupil diffraction_pupil(const Aperture& aperture, double focal_length, double pitch,
                                   std::array<double, 2> shift = {0, 0});

/// The cells of a measured map inside `aperture` (about the map's origin), and their heights [m] in the order
/// of the points. Paraxial, since the cells are those of the map: radii are off by 1/(32 N^2), N the
/// f-number: 0.06 % at f/7, 0.35 % at f/3. Cells without a value are opaque. Throws ComputationError when
/// nothing is left or the map has no pitch.
DiffractionPupil diffraction_pupil(const HeightMap& map, const Aperture& aperture, Eigen::ArrayXd* height);

/// What sampling a scene needs.
struct DiffractionSampling {
  double pitch = 0;    ///< of the pupil's cells [m]
  int samples = 0;     ///< cells across 2 aperture_radius
  std::string reason;  ///< one sentence
};

/// Largest pitch that keeps a spot of radius `radius` [m] (all the light that matters: 1.5 times the largest
/// EE radius asked for, or 5 sigma_f) in planes up to `dz` [m] inside half of the field of view wavelength
/// f/pitch, with at least `least_samples` cells across for the edge of the aperture (128: Airy radii to
/// 3e-5). The same condition in the pupil: 2 slope pitch/wavelength < 1/2, slope including that of defocus.
DiffractionSampling diffraction_sampling(const Aperture& aperture, double focal_length, double wavelength,
                                         double radius, double dz, int least_samples = 64);
/// Distance from the focus [m] within which `samples` cells across hold the cone of light by
/// diffraction_sampling, on either side, of a spot that is much smaller than the cone there.
double farthest_plane(const Aperture& aperture, double focal_length, double wavelength, int samples);

/// Roughness that no height of a pupil stands for, by its ensemble mean (PHYSICS 10): parts of a roughness
/// that are independent multiply the transfer function. Const use from many threads. Belongs to one mirror,
/// aperture and wavelength.
class MeanScatter {
 public:
  virtual ~MeanScatter() = default;
  /// H at pupil shears [m], ascending from 0: the factor on the transfer function. 1 at 0.
  virtual Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const = 0;
  /// The same of the whole roughness: of this part and of the mean over what the heights stand for.
  virtual Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const = 0;
  /// Share of the light inside `radius` [m] in the focus of the mirror with all its roughness, in the
  /// ensemble mean, and its derivative [1/m].
  virtual double encircled_energy(double radius) const = 0;
  virtual double encircled_energy_slope(double radius) const = 0;
  /// Share of the light inside a radius, and its derivative [1/m].
  struct Encircled {
    double energy = 0, slope = 0;
  };
  /// The same of that mean spot in the plane f + dz; nothing where it is known in the focus alone.
  virtual std::optional<Encircled> in_plane(double /*radius*/, double /*dz*/) const { return std::nullopt; }
  /// Of that mean spot: irradiance on the axis, of all light 1 [1/m^2], and the transfer function at a
  /// frequency of the image [cycles/m].
  virtual double irradiance() const = 0;
  virtual double image_transfer(double frequency) const = 0;
  /// Of this part: RMS height [m], RMS slope in each axis, and RMS scatter angle [rad]. They add to those of
  /// the heights in squares.
  virtual double rms_height() const = 0;
  virtual double rms_slope_per_axis() const = 0;
  virtual double scatter_rms() const = 0;
  /// The same at the k-th wavelength of a band. Throws ComputationError where it is known at one alone.
  virtual std::shared_ptr<const MeanScatter> of_line(std::size_t k) const;
};

/// See DiffractionProblem::aliased_limit.
inline constexpr double kMostAliased = 1e-3;

/// What the statistics are functions of: the pupil focused by a parabola.
///
/// Field in the plane z = f + dz (PHYSICS 6; t = r/2f, cos theta = (1 - t^2)/(1 + t^2)):
///   U(X) = sum_k amplitude_k exp(-i [4 pi h_k/(lambda (1 + t_k^2)) + 2 pi/lambda f dz/(f+dz) (1 - cos
///   theta_k)]) exp(-2 pi i P_k.X/(lambda (f+dz)))
/// Signs and scale are those of the rays, exact in the aperture and of first order in the slope: positive dz
/// further from the mirror, (dz/f) r/(1 - t^2) from the axis without roughness. Out of focus the growth of
/// the spread is that of rays to first order in t^2 dz/f. In a paraxial pupil (Fresnel; Goodman, Introduction
/// to Fourier Optics, 4.2 and 5.2.2) t = 0 and 1 - cos theta = rho^2/2f^2: errors of order t^2, 0.06 % of a
/// radius at f/7, 2 % at f/1.25.
///
/// Encircled energy comes from the optical transfer function, the autocorrelation C_m of the pupil field:
///   EE(r) = u^2 sum_m C_m r J1(2 pi r u |m|)/(u |m|) / total,  u = pitch/(lambda (f+dz)),
/// the exact integral of the PSF over the disc: no pixels, no interpolation of an image, and no dependence on
/// padding. Shares are of all light that passes the aperture; light beyond the field of view lambda f/pitch
/// (for a sharp edge about 0.3/N) is not inside any radius.
struct DiffractionProblem {
  const DiffractionPupil& pupil;
  double focal_length = 0;  ///< [m], > 0
  Light wavelength = {};    ///< [m], > 0; of a band: evaluate_diffraction alone, all else is of its mean
  /// Share of neighbouring cells whose phases may differ by more than pi (their light lands in the wrong
  /// place) before a result is refused.
  double aliased_limit = kMostAliased;
  /// Roughness on top of the heights; null: none. With it the transfer function is C_m H(x_m), and what the
  /// cells cannot see of it, its halo beyond the field of view and all that moves within a lag, comes from
  /// the mean spot E of the whole roughness:
  ///   EE(r) = E(r; dz) + u^2 sum_m (C_m(dz) H(x_m) - C_m^0(dz) H_whole(x_m)) r J1(2 pi r u |m|)/(u |m|)
  /// with C_m^0 of the nominal heights: in the mean over surfaces with the other part of the roughness that
  /// is E itself, in the focus exactly. Where E beyond the field of view is that of the focus, grown with f +
  /// dz, to 1e-6 of the light, or is known in the focus alone, and for more than a hundred planes at once, E
  /// and C_m^0 are those of the focus. A ring's planes are looked for: what E and C_m^0 of a plane differ
  /// there from those of the focus is interpolated between planes that all surfaces share (1.5e-3 of the
  /// width). Radii are not limited by the field of view: beyond it the curve goes on as E does. An image
  /// lacks what the rest scatters beyond the field of view, which comes back into it from the other side.
  std::shared_ptr<const MeanScatter> scatter = {};
  /// Heights of the mirror without roughness at the pupil points [m]; null: 0. Looked at with `scatter`.
  const Eigen::ArrayXd* nominal = nullptr;
  /// Focal fields and kernels in single precision: half of their memory, 0.5 to 0.7 of the time on 400 cells
  /// across and more, and errors of 2e-7 of all light.
  bool single_precision = false;
};

// Every function of a problem throws std::invalid_argument for a pupil without cells, for heights of another
// number than its points and for lengths that are not positive; and, unless said otherwise, for heights that
// are not finite. A plane exists where dz is finite and f + dz > 0.

/// Memory and transform plans that evaluations reuse. One per caller: not to be shared between evaluations
/// that run at the same time. May be used for different problems in turn. Keeps the planes (up to 512 MB of
/// them) and the ring searches of the surface that was evaluated last, so that gradients at the heights of
/// the values before them cost no more than what is new in them; not a bit of a result depends on it.
class DiffractionWorkspace {
 public:
  DiffractionWorkspace();
  ~DiffractionWorkspace();
  DiffractionWorkspace(DiffractionWorkspace&&) noexcept;
  DiffractionWorkspace& operator=(DiffractionWorkspace&&) noexcept;
  /// From now on RingFwhm of one surface after the other is looked for near where it was: a fifth of the
  /// planes of a search. For surfaces, or grids of one, whose light differs little; the last bits of a width
  /// then depend on what was asked for before.
  void follow_rings();
  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

/// What is looked at in more planes than these has, beyond the cells, the mean spot of the focus in all of
/// them: theory remembers as many, and each takes several planes' time.
inline constexpr std::size_t kMostPlanesOfTheirOwn = 100;

/// Makes less of a gradient over the heights, from several threads.
using GradientReduction = std::function<Eigen::ArrayXd(const Eigen::ArrayXd& d_height)>;

/// Statistics of the diffraction PSF about the nominal focus X = 0, and their exact gradients over the
/// heights (adjoint: one inverse transform per statistic and plane). height: one per pupil point [m]. values:
/// one per statistic, NaN where it does not exist; d_height, when given: one array per statistic, d value/d
/// height, one entry per pupil point; multiply by L^T for coefficients. workspace may be null. reduce: what
/// it makes takes the place of each gradient as soon as that is there, so that not all of them need the
/// memory of a grid at once; may be empty.
///   EncircledEnergyRadius, RingThrough: from EE(r) above.
///   RingFwhm: N(z) searched from a scan of planes; the half crossings nearest to the highest peak. Costs
///   about 50 planes, an encircled-energy radius one.
///   SpotFwhm: from the transfer function along x and y; bandwidth 0 is allowed. Outermost half crossings.
///   RmsHeight: of the surface, weighted by area.
///   ScatterRms, ScatterMean, RmsRadius: always NaN. A sharp edge scatters light as 1/r^3, so these second
///   moments have no finite value for waves; take them from traced rays.
/// False when any value or gradient does not exist: no such plane, heights that are not finite, no root
/// inside the field of view, more aliased cells than the limit, a radius in a dark ring, ... Results do not
/// depend on `threads`, to the last bit.
bool evaluate_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                          const std::vector<Statistic>& statistics, int threads,
                          DiffractionWorkspace* workspace, Eigen::VectorXd* values,
                          std::vector<Eigen::ArrayXd>* d_height, const GradientReduction& reduce = {});

/// How well the grid carries a surface in one plane.
struct DiffractionCheck {
  double energy_outside = 0;  ///< share of the light beyond the field of view, by Parseval
  double field_of_view = 0;   ///< wavelength (f+dz)/pitch, the smaller of x and y [m]
  double largest_step = 0;    ///< largest phase difference of neighbouring cells [rad]
  double aliased_share = 0;   ///< share of neighbouring cells whose phases differ by more than pi
  Warnings warnings;
};
/// Heights that are not finite: NaN for the steps and a warning. Throws std::invalid_argument where the plane
/// does not exist.
DiffractionCheck check_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                   double dz);

/// Encircled energy [1] at the given radii [m], each up to half the field of view; NaN beyond, and where
/// the plane does not exist.
Eigen::ArrayXd diffraction_encircled_energy(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                            double dz, const Eigen::ArrayXd& radius);

/// Part of a PSF: share of the light per area [1/m^2] at X = first + column pitch, Y = first + row pitch.
struct PsfImage {
  Grid intensity;
  double first = 0;  ///< [m]
  double pitch = 0;  ///< [m]
  double dz = 0;     ///< plane, offset from z = f [m]
  enum class Method { kTransform, kMatrix } method = Method::kTransform;
};
struct PsfWindow {
  double half_width = 0;  ///< [m]; 0: the whole field of view
  double pitch = 0;       ///< largest pitch wanted [m]; 0: a quarter of wavelength (f+dz)/(2 aperture_radius)
  double dz = 0;          ///< plane, offset from z = f [m]
};
/// The PSF in a window about the nominal focus, which is a sample. Over the whole field of view, the sum
/// times pitch^2 is 1 less the light outside. A padded transform gives all of the field of view, two matrix
/// products (a matrix Fourier transform; Soummer et al. 2007) only the window: whichever costs less by count
/// of operations. Pitch at most the wanted one. Throws ComputationError where cells are not square, where the
/// plane does not exist, and for more than 16384 samples a side.
PsfImage diffraction_psf(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                         const PsfWindow& window);

}  // namespace aberfit
