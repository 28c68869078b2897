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

/// Use this instead of a focal length for pupil grids and phases to first order in the aperture.
inline constexpr double kParaxial = std::numeric_limits<double>::infinity();

/// The aperture on a grid of square cells in P = f (direction cosine) = r/(1 + t^2), t = r/2f. A Fourier
/// transform to the focal plane needs equal steps of P exactly; equal steps on the mirror differ from them by
/// t^2 at the rim (PHYSICS 6). The surface is sampled where the rays of the cell centres meet the mirror.
/// Light passes through the clear part of each cell. In a paraxial pupil, P is the position on the mirror.
struct DiffractionPupil {
  /// Points on the mirror of the grid cells that transmit, so that a SurfaceOperator or a trace can use the
  /// same points. `structure` is a DirectionGrid, or a CartesianGrid in a paraxial pupil. weight: fraction of
  /// the mirror's clear area. Centres of edge cells may lie up to 0.71 pitch outside the aperture.
  PupilSample sample;
  Eigen::ArrayXd cover;  ///< clear fraction of each of these cells, in (0, 1]
  /// Weight of a cell in a sum that approximates an integral over P. It is `cover`, corrected at edges so
  /// that the sum is right to third order in the pitch, times the root of d2r/d2P = (1 + t^2)^3/(1 - t^2).
  /// The energy of a cell is then its area on the mirror. Edge cells may be slightly negative.
  Eigen::ArrayXd amplitude;
  Eigen::ArrayXd obliquity;         ///< 1/(1 + t^2); the optical path of a height h is 2h times this
  double total = 0;                 ///< clear area of the mirror in grid cells; represents the total energy
  double pitch_x = 0, pitch_y = 0;  ///< pitch of P [m]
  double missing = 0;  ///< fraction of the aperture's area without measured heights, which is opaque
};

/// Largest number of cells along a side of a pupil grid.
inline constexpr int kMostCells = 16384;

/// Makes a grid of cells of side `pitch` [m], centred on the bounding box of the aperture in P, for a
/// parabola of this focal length [m] or kParaxial. shift: displacement of all cells along x and y, in cells,
/// each at most one half.
/// The clear fraction of a cell is exact for circles and annuli. Straight edges are arcs of ellipses in P,
/// approximated by chords of a quarter of a cell. The margin is not subtracted, because light passes there
/// too.
/// Relative error of EE50, EE80 and EE90 of a full circle, N cells across, against the Airy pattern:
///   N =  32  2e-7, 2e-6, 1.4e-5 with `amplitude`;  2e-4, 2e-3, 7e-3 with `cover`;  5e-3 with whole cells
///   N = 128  8e-10, 3e-8, 2.3e-7;                  2e-5, 1.2e-4, 5e-4;              1e-3
/// It falls as N^-4, as N^-2 and irregularly. Throws ComputationError for more than 16384 cells a side, and
/// for an aperture radius of 1.9 focal lengths or more (an angle of 87 degrees).
DiffractionPupil diffraction_pupil(const Aperture& aperture, double focal_length, double pitch,
                                   std::array<double, 2> shift = {0, 0});

/// The grid cells of a measured map inside `aperture` (about the map's origin), and their heights [m] in the
/// order of the points. Cells without a value are opaque. The pupil is paraxial, because it uses the cells of
/// the map. Radii are wrong by 1/(32 N^2), N the f-number: 0.06 % at f/7, 0.35 % at f/3. Throws
/// ComputationError when nothing is left or the map has no pitch.
DiffractionPupil diffraction_pupil(const HeightMap& map, const Aperture& aperture, Eigen::ArrayXd* height);

/// The sampling that a scene needs.
struct DiffractionSampling {
  double pitch = 0;    ///< pitch of the pupil grid [m]
  int samples = 0;     ///< grid cells across 2 aperture_radius
  std::string reason;  ///< one sentence
};

/// Largest pitch that keeps a spot within half of the field of view wavelength f/pitch, in planes up to `dz`
/// [m]. radius: radius of the spot [m], 1.5 times the largest encircled-energy radius of interest or 5
/// sigma_f. least_samples: minimum number of cells across the aperture (128 gives Airy radii to 3e-5). The
/// same condition in the pupil is 2 slope pitch/wavelength < 1/2, with the slope of defocus included.
DiffractionSampling diffraction_sampling(const Aperture& aperture, double focal_length, double wavelength,
                                         double radius, double dz, int least_samples = 64);
/// Largest distance from the focus [m], on either side, at which diffraction_sampling needs no more than
/// `samples` cells across for the cone of rays. The spot must be much smaller than the cone there.
double farthest_plane(const Aperture& aperture, double focal_length, double wavelength, int samples);

/// Ensemble mean of roughness that is not part of the heights (PHYSICS 10), for one mirror, aperture and
/// wavelength. Independent parts of a roughness multiply the transfer function. Many threads may use a const
/// object.
class MeanScatter {
 public:
  virtual ~MeanScatter() = default;
  /// H at pupil shears [m], ascending from 0: the factor on the transfer function. It is 1 at 0.
  virtual Eigen::ArrayXd transfer(const Eigen::ArrayXd& shear) const = 0;
  /// The same factor for the whole roughness, i.e. for this part and the part that the heights represent.
  virtual Eigen::ArrayXd whole_transfer(const Eigen::ArrayXd& shear) const = 0;
  /// Ensemble mean of the encircled energy (a fraction) of `radius` [m] in the focus, with the whole
  /// roughness, and its derivative [1/m].
  virtual double encircled_energy(double radius) const = 0;
  virtual double encircled_energy_slope(double radius) const = 0;
  /// Encircled energy as a fraction, and its derivative with respect to the radius [1/m].
  struct Encircled {
    double energy = 0, slope = 0;
  };
  /// The same for the plane f + dz; nothing when it is known in the focus alone.
  virtual std::optional<Encircled> in_plane(double /*radius*/, double /*dz*/) const { return std::nullopt; }
  /// Mean spot: axial irradiance for a total energy of 1 [1/m^2], and transfer function at a spatial
  /// frequency of the image [cycles/m].
  virtual double irradiance() const = 0;
  virtual double image_transfer(double frequency) const = 0;
  /// RMS height [m], RMS slope per axis and RMS scatter angle [rad] of this part. They add in squares.
  virtual double rms_height() const = 0;
  virtual double rms_slope_per_axis() const = 0;
  virtual double scatter_rms() const = 0;
  /// The same scatter at the k-th wavelength. Throws ComputationError when only one wavelength is known.
  virtual std::shared_ptr<const MeanScatter> of_line(std::size_t k) const;
};

/// See DiffractionProblem::aliased_limit.
inline constexpr double kMostAliased = 1e-3;

/// Input of the diffraction statistics: a pupil focused by a parabola.
///
/// Field in the plane z = f + dz (PHYSICS 6; t = r/2f, cos theta = (1 - t^2)/(1 + t^2)):
///   U(X) = sum_k amplitude_k exp(-i [4 pi h_k/(lambda (1 + t_k^2)) + 2 pi/lambda f dz/(f+dz) (1 - cos
///   theta_k)]) exp(-2 pi i P_k.X/(lambda (f+dz)))
/// Signs and scale are those of rays, exact in the aperture and to first order in the slope. Positive dz is
/// farther from the mirror; without roughness a ray is (dz/f) r/(1 - t^2) from the axis. The defocused spread
/// is that of rays to first order in t^2 dz/f. In a paraxial pupil (Fresnel; Goodman, Introduction to Fourier
/// Optics, 4.2 and 5.2.2) t = 0 and 1 - cos theta = rho^2/2f^2. The errors are of order t^2: 0.06 % of a
/// radius at f/7, 2 % at f/1.25.
///
/// Encircled energy comes from the optical transfer function, the autocorrelation C_m of the pupil field:
///   EE(r) = u^2 sum_m C_m r J1(2 pi r u |m|)/(u |m|) / total,  u = pitch/(lambda (f+dz)).
/// This is the exact integral of the PSF over the disc, without pixels, image interpolation or padding.
/// Fractions refer to all energy that passes the aperture. Energy beyond the field of view lambda f/pitch
/// (about 0.3/N for a sharp edge) lies inside no radius.
struct DiffractionProblem {
  const DiffractionPupil& pupil;
  double focal_length = 0;  ///< [m], > 0
  /// [m], > 0. Only evaluate_diffraction treats a band; all other functions use the mean wavelength.
  Light wavelength = {};
  /// Largest fraction of neighbouring grid cells whose phases may differ by more than pi. Their energy falls
  /// in the wrong place, so a result above this fraction is refused.
  double aliased_limit = kMostAliased;
  /// Roughness in addition to the heights; null: none. The transfer function becomes C_m H(x_m). The mean
  /// spot E of the whole roughness supplies the rest, i.e. the halo beyond the field of view and changes
  /// within a lag:
  ///   EE(r) = E(r; dz) + u^2 sum_m (C_m(dz) H(x_m) - C_m^0(dz) H_whole(x_m)) r J1(2 pi r u |m|)/(u |m|)
  /// with C_m^0 of the nominal heights. In the focus, the ensemble mean over the other part of the roughness
  /// is exactly E. E and C_m^0 are those of the focus in three cases: beyond the field of view, E is that of
  /// the focus scaled by f + dz to 1e-6 of the energy; E is known only in the focus; or there are more than a
  /// hundred planes. For ring widths, the difference from E and C_m^0 of the focus is interpolated between
  /// planes that all surfaces share (1.5e-3 of the width). Radii may exceed the field of view, where the
  /// curve continues as E. An image has no such supplement: energy scattered beyond the field of view returns
  /// from the opposite side.
  std::shared_ptr<const MeanScatter> scatter = {};
  /// Heights of the mirror without roughness at the pupil points [m]; null: 0. Used only with `scatter`.
  const Eigen::ArrayXd* nominal = nullptr;
  /// Computes focal fields and kernels in single precision: half the memory, 0.5 to 0.7 of the time for 400
  /// cells across or more, and errors of 2e-7 of the total energy.
  bool single_precision = false;
};

// Every function of a problem throws std::invalid_argument for a pupil without cells, a wrong number of
// heights, lengths that are not positive and, unless stated otherwise, heights that are not finite. A plane
// exists when dz is finite and f + dz > 0.

/// Memory and transform plans that evaluations reuse. Simultaneous evaluations need one workspace each.
/// Different problems may use one in turn. It keeps the planes (up to 512 MB) and ring searches of the last
/// surface, so gradients at the same heights cost little extra. This changes no bit of a result.
class DiffractionWorkspace {
 public:
  DiffractionWorkspace();
  ~DiffractionWorkspace();
  DiffractionWorkspace(DiffractionWorkspace&&) noexcept;
  DiffractionWorkspace& operator=(DiffractionWorkspace&&) noexcept;
  /// Makes every later search for RingFwhm start from the width of the previous surface, which needs a fifth
  /// of the planes. Use it for surfaces, or grids, with similar irradiance. The last bits of a width then
  /// depend on earlier evaluations.
  void follow_rings();
  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

/// With more planes than this, all planes use the mean spot of the focus beyond the grid. `theory` stores
/// that many mean spots, and each one takes several planes' time.
inline constexpr std::size_t kMostPlanesOfTheirOwn = 100;

/// Reduces a gradient over the heights to something smaller; several threads call it.
using GradientReduction = std::function<Eigen::ArrayXd(const Eigen::ArrayXd& d_height)>;

/// Statistics of the diffraction PSF about the nominal focus X = 0, and their exact gradients over the
/// heights (adjoint: one inverse transform per statistic and plane).
/// height: one per pupil point [m]. values: one per statistic, NaN where it does not exist.
/// d_height, when given: d value/d height, one array per statistic with one entry per pupil point. Multiply
/// by L^T for coefficients.
/// workspace: may be null. reduce: replaces each gradient by its result at once, so that not all gradients
/// need the memory of a grid; may be empty.
///   EncircledEnergyRadius, RingThrough: from EE(r) above.
///   RingFwhm: between the half crossings nearest to the highest peak of N(z). It costs about 50 planes; an
///   encircled-energy radius costs one.
///   SpotFwhm: from the transfer function along x and y, between the outermost half crossings; bandwidth 0 is
///   allowed.
///   RmsRadius and moments of the surface: always NaN. A sharp edge scatters as 1/r^3, whose second moment
///   diverges. Use traced rays for them.
/// Returns false when any value or gradient does not exist: no such plane, heights that are not finite, no
/// root inside the field of view, too many aliased cells, a radius in a dark ring. Results do not depend on
/// `threads`, to the last bit.
bool evaluate_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                          const std::vector<Statistic>& statistics, int threads,
                          DiffractionWorkspace* workspace, Eigen::VectorXd* values,
                          std::vector<Eigen::ArrayXd>* d_height, const GradientReduction& reduce = {});

/// Quality of the sampling of a surface in one plane.
struct DiffractionCheck {
  double energy_outside = 0;  ///< fraction of the energy beyond the field of view, by Parseval's theorem
  double field_of_view = 0;   ///< wavelength (f+dz)/pitch, the smaller of x and y [m]
  double largest_step = 0;    ///< largest phase difference of neighbouring grid cells [rad]
  double aliased_share = 0;   ///< fraction of neighbouring cells whose phases differ by more than pi
  Warnings warnings;
};
/// Checks the sampling. Heights that are not finite give NaN for the phase steps and a warning. Throws
/// std::invalid_argument when the plane does not exist.
DiffractionCheck check_diffraction(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                   double dz);

/// Encircled energy as a fraction at the given radii [m], each up to half the field of view. NaN beyond that,
/// and when the plane does not exist.
Eigen::ArrayXd diffraction_encircled_energy(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                                            double dz, const Eigen::ArrayXd& radius);

/// Part of a PSF: energy fraction per area [1/m^2] at X = first + column pitch, Y = first + row pitch.
struct PsfImage {
  Grid intensity;
  double first = 0;  ///< [m]
  double pitch = 0;  ///< [m]
  double dz = 0;     ///< plane, offset from z = f [m]
  enum class Method { kTransform, kMatrix } method = Method::kTransform;
};
struct PsfWindow {
  double half_width = 0;  ///< [m]; 0: the whole field of view
  double pitch = 0;  ///< largest allowed pitch [m]; 0: a quarter of wavelength (f+dz)/(2 aperture_radius)
  double dz = 0;     ///< plane, offset from z = f [m]
};
/// The PSF in a window about the nominal focus, which is one of the samples. Over the whole field of view,
/// the sum times pitch^2 is 1 minus the energy outside. The method is a padded transform over the field of
/// view or two matrix products over the window (matrix Fourier transform; Soummer et al. 2007), whichever
/// needs less time. Throws ComputationError when cells are not square, when the plane does not exist, and for
/// more than 16384 samples a side.
PsfImage diffraction_psf(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                         const PsfWindow& window);

}  // namespace aberfit
