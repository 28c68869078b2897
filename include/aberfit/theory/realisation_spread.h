#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/scene/aperture.h"
#include "aberfit/scene/mirror.h"
#include "aberfit/theory/generalised_harvey_shack.h"

namespace aberfit {

/// A disc about the axis in the plane z = f + dz.
struct FocalDisc {
  double radius = 0;  ///< [m]
  double dz = 0;      ///< [m]
  /// Replaces the energy of the disc by the mean of those at dz and -dz, less half of that in the focus.
  /// Divided by half the slope of the energy over dz, it is the change of the width of N(z), the energy of a
  /// fixed ring, that ends at dz. Needs a spot without roughness that is the same on both sides of the focus.
  bool is_end_of_width = false;
};

/// The disc whose energy decides a statistic to first order.
struct DecidingDisc {
  FocalDisc disc;
  double unit = 0;  ///< > 0: energy in the disc for a relative difference of 1
};
/// The disc that decides an aim (`aim_of`). Returns nothing for properties of the surface or of rays, or if
/// no disc decides.
std::optional<DecidingDisc> deciding_disc(const Target& aim, const GeneralisedHarveyShack& mean);

/// A rough mirror whose realisations are compared with their mean.
struct SpreadProblem {
  const RadialPsd& psd;      ///< of all the roughness
  const Mirror& mirror;      ///< its departure from the parabola counts
  const Aperture& aperture;  ///< any aperture
  double wavelength = 0;     ///< > 0 [m]
  const GeneralisedHarveyShack&
      mean;  ///< mean spot of the same psd, mirror, aperture, wavelength and departure
  /// Height [m] at x, y [m] on top of the mirror's own surface; may be empty.
  std::function<double(double, double)> departure = {};
};

/// Differences between mirrors because of the roughness above a frequency f_c, the cut. They are
/// given as the standard deviation of E(r), the energy within r, over mirrors with the same surface below f_c
/// and independent realisations of the roughness above it. The mean is the spot of the common surface with
/// the mean transfer function of the rest. With k = 4 pi/lambda and F = f_focal + dz,
///   var E(r) = int_{f > f_c} S (|FT[dE/dh]|^2 + M) d2f + (2/area) int_{f > f_c} (S dE/dS)^2 d2f,
///   dE/dS(f) = k^2 [E(disc shifted by lambda F f) - E(disc)].
///
/// First term (PHYSICS 10): scattered waves interfere with the mirror's own wave; it is linear in the
/// heights. dE/dh is that of the mirror without roughness, its transfer function times the mean one of all
/// the roughness. It is zero in the focus of a parabola. Last term (PHYSICS 10): the periodogram of a
/// realisation differs from S, which moves the whole spot. M: pairs of different frequencies. The lower one
/// scatters energy that the higher one moves across the edge of the disc; for each f
///   M = (k^2/area) int [K I_h I_h' + (I_c I_h' + I_h I_c')/2] (|p - p'| - |e|)^2 d2q,
/// see ScrambledLight in src/theory. The formula for fully developed speckle needs a g of the rest above 1. M
/// needs no threshold, conserves energy, and also holds where all the roughness is strong and the rest weak.
///
/// The wave that interferes with a symmetric mirror's own is odd in dz. It moves N(z) along the axis and does
/// not change its width. The periodogram moves both planes alike. Pairs at the end of the width and in the
/// focus count as correlated with rho = 1/2, a measured value; widths without a core have 0.13 to 0.66.
///
/// The error was measured with realisations (tests/theory/drawn_mirrors.h) of Gaussian, k-correlation,
/// power-law and uniform PSDs (g = 0.1 to 5, circle and annulus, up to two waves of defocus, 15 to 97 % of
/// the energy). Of spreads above 0.1 % of the energy, 93 % are predicted within a factor 1.3 and 98 % within
/// 1.5. The median of predicted over measured is 1.04. The prediction is too small, down to a factor 0.32, in
/// the outermost energy of strong smooth surfaces: few facets of the mirror send energy there. It is too
/// large, up to 3.5, at cuts near one cycle across: the periodogram of so few cycles differs from that of the
/// formula.
///
/// The constructor does all the costly work, for all cuts. A plane takes tens of milliseconds, plus its mean
/// spot. Beyond about 25 waves of defocus the grid of dE/dh, 512 points across, leaves out its highest
/// frequencies. Results do not depend on the number of threads. Const use from many threads is safe.
class RealisationSpread {
 public:
  /// discs: radius > 0, any number. Throws std::invalid_argument for a radius or wavelength <= 0.
  /// ComputationError where dz is not finite, f + dz <= 0 or all roughness is above 1/wavelength.
  RealisationSpread(const SpreadProblem& problem, const std::vector<FocalDisc>& discs, int threads = 1);
  ~RealisationSpread();
  RealisationSpread(RealisationSpread&&) noexcept;
  RealisationSpread& operator=(RealisationSpread&&) noexcept;

  /// Covariance over mirrors of the energy in discs of one plane, discs x discs, for realisations of all the
  /// roughness. Each of the three terms has the product of the responses of two discs in place of the square
  /// of one. There is no correlation length: a frequency that carries energy across both edges moves both
  /// discs alike. The roots of the diagonal are `light` at `lowest`, to rounding. Throws as the constructor,
  /// and std::invalid_argument for discs of more than one plane.
  static Eigen::MatrixXd covariance(const SpreadProblem& problem, const std::vector<FocalDisc>& discs);

  /// Standard deviation of the energy in each disc [1]. cut: [cycles/m]; at least `lowest`; 0 from `highest`
  /// on.
  Eigen::ArrayXd light(double cut) const;
  /// Standard deviations of the RMS height and the RMS slope of a realisation over the aperture, relative to
  /// those of all the roughness. Only frequencies above the cut vary: var(sigma^2) = (2/area) int S^2 d2f;
  /// slopes have (2 pi f)^2 S in place of S. 0 where the RMS of all the roughness is infinite.
  double rms_height(double cut) const;
  double rms_slope(double cut) const;
  /// That of a moment of the surface, to first order; NaN for other statistics.
  double of_moment(const Statistic& moment, double cut) const;

  /// Lowest frequency [cycles/m]: f_min, at least 1/20 of a cycle across. Longer waves only tilt the mirror.
  double lowest() const;
  /// Highest frequency that scatters [cycles/m]: f_max of the PSD, at most 1/wavelength.
  double highest() const;
  /// The finest difference of frequencies that the aperture resolves, 1/diameter [cycles/m].
  double resolution() const;
  /// Cuts between which every spread is smooth, ascending from `lowest` to `highest` [cycles/m].
  const std::vector<double>& edges() const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

/// The smallest cut that keeps the limits; result of `smallest_cut`.
struct SmallestCut {
  double frequency = 0;     ///< [cycles/m]
  bool whole_band = false;  ///< all roughness may lie above the cut: no terms are needed
  /// Largest ratio of spread and limit; 1 unless `whole_band` or less than a `resolution` from the end.
  double share_of_limit = 0;
  int disc = -1;  ///< index of the disc with the largest ratio; -1 without discs
};
/// The smallest cut at and above which every spread is within its limit, to 1e-12 in the logarithm of the
/// frequency. It is continuous in the specification and the limits. `whole_band`, with the frequency at
/// `lowest`, where all limits hold there. limits: largest allowed standard deviation, one per disc, > 0. A
/// rest narrower than one `resolution` is no independent part, and its spread may exceed the formula (1.7
/// times for a strong narrow uniform band). Between a width of one `resolution` and a half, the cut therefore
/// goes on to `highest`, twice as fast, and stays there. Throws std::invalid_argument where the number of
/// limits is not that of the discs or a limit is not above zero.
SmallestCut smallest_cut(const RealisationSpread& spread, const Eigen::ArrayXd& limits);

}  // namespace aberfit
