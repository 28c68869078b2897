#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
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
  /// Instead of its light: the mean of that at dz and -dz, less half of that in the focus. What it gains,
  /// over half the slope of the light over dz, is what the width of N(z), the light of a fixed ring, gains
  /// where dz is its end. Of a mirror whose light without roughness is the same on both sides of the focus.
  bool is_end_of_width = false;
};

/// A rough mirror whose realisations are to be compared with their mean.
struct SpreadProblem {
  const RadialPsd& psd;                ///< of the whole roughness
  const Mirror& mirror;                ///< its departure from the parabola counts
  const Aperture& aperture;            ///< any
  double wavelength = 0;               ///< > 0 [m]
  const GeneralisedHarveyShack& mean;  ///< of the same psd, mirror, aperture, wavelength and departure
  /// Height [m] at x, y [m] on top of the mirror's own surface; may be empty.
  std::function<double(double, double)> departure = {};
};

/// How much real mirrors differ from each other on account of the roughness above a frequency f_c, the cut:
/// standard deviation of E(r), the share of the light within r, over mirrors that have the same surface below
/// f_c and independent draws of the roughness above it, about their mean, which is the light of the common
/// surface with the mean transfer function of the rest. With k = 4 pi/lambda and F = f_focal + dz,
///   var E(r) = int_{f > f_c} S (|FT[dE/dh]|^2 + M) d2f + (2/area) int_{f > f_c} (S dE/dS)^2 d2f,
///   dE/dS(f) = k^2 [E(disc shifted by lambda F f) - E(disc)].
/// First (PHYSICS 10): light that interferes with the mirror's own wave, linear in the heights; dE/dh of the
/// mirror without roughness, its transfer function times the mean one of the whole roughness. Zero in the
/// focus of a parabola. Last (PHYSICS 10): the periodogram of a draw differs from S, which moves the whole
/// spot. M: pairs of different frequencies, the lower of which spreads light that the higher moves across the
/// edge of the disc, for each f
///   M = (k^2/area) int [K I_h I_h' + (I_c I_h' + I_h I_c')/2] (|p - p'| - |e|)^2 d2q,
/// see ScrambledLight in src/theory. M takes the place of the formula for speckle that PHYSICS 10 has for a g
/// of the rest above 1: it needs no such threshold, conserves light, and holds where the whole roughness is
/// strong and the rest weak, for which the two other terms are up to ten times too small.
///
/// The light that interferes with the wave of a symmetric mirror is odd in dz: it moves N(z) along the axis
/// and takes no part in its width (drawn: 0.0553 of a ring's light in power-law scenes, odd to 0.0551). The
/// periodogram moves both planes alike; pairs at the end of the width and in the focus are taken as
/// correlated by a half, rho = 1/2: 20 drawn widths, of which those without a core have 0.13 to 0.66.
///
/// Measured against 60 draws (aperture 128 cells across; Gaussian, k-correlation, power law and uniform PSDs;
/// g = 0.1, 0.3, 1, 2, 5; circle and annulus; in focus and two waves out of it; cuts of 1.2 to 35 cycles
/// across; radii of 15 to 97 % of the light), where the spread is above a tenth of the tolerance of 1 % in
/// light: predicted over measured is within a factor 1.3 for 93 % of 1541 spreads, within 1.5 for 98 %,
/// median 1.04. Too small it is in the outermost light of strong smooth surfaces: 0.32 (200 draws; cut at 6
/// cycles, Gaussian, g = 5, radius of 97 %: few facets of the mirror send light there). Too large, up to 3.5,
/// at cuts of 1.2 cycles, where the periodogram of so few cycles is not that of the formula. Ratios of 1.7
/// to 2.3 of power laws are those of draws whose cells do not hold the outermost light: 0.98 to 1.34 with
/// cells of half the size.
///
/// Everything that costs is done at construction, for all cuts. Of 20 planes with 8 discs each, one costs 15
/// ms on average where all are within two waves of the focus and 40 ms within ten (one core, a 2.4 m annulus,
/// 480 cycles across), plus the mean spot there. Beyond some 25 waves of defocus the grid of dE/dh, 512 cells
/// across, leaves out its highest frequencies. Results are the same for any number of threads. Const use from
/// many threads.
class RealisationSpread {
 public:
  /// discs: radius > 0, any number. Throws std::invalid_argument for a radius or a wavelength that is not
  /// above zero, ComputationError where dz is not finite or f + dz not above zero, and where all of the
  /// roughness is above 1/wavelength.
  RealisationSpread(const SpreadProblem& problem, const std::vector<FocalDisc>& discs, int threads = 1);
  ~RealisationSpread();
  RealisationSpread(RealisationSpread&&) noexcept;
  RealisationSpread& operator=(RealisationSpread&&) noexcept;

  /// Covariance over mirrors of the light in discs of one plane, of draws of the whole roughness: each of the
  /// three terms with the answers of two discs in place of the square of one. It has no length of its own: a
  /// frequency that carries light across both edges moves both shares alike, and a mirror has no more
  /// independent departures than frequencies that move light. discs x discs; the roots of the diagonal are
  /// `light` at `lowest`, to rounding. Throws as the constructor, and std::invalid_argument for discs of more
  /// than one plane.
  static Eigen::MatrixXd covariance(const SpreadProblem& problem, const std::vector<FocalDisc>& discs);

  /// Standard deviation of the light in each disc [1]. cut: [cycles/m]; below `lowest` that at `lowest`; 0
  /// from `highest` on.
  Eigen::ArrayXd light(double cut) const;
  /// Standard deviation of the sample RMS height and RMS slope over the aperture relative to the RMS of the
  /// whole roughness, from the frequencies above the cut: var(sigma^2) = (2/area) int S^2 d2f, and for slopes
  /// (2 pi f)^2 S in place of S. 0 where the RMS of the whole is infinite.
  double rms_height(double cut) const;
  double rms_slope(double cut) const;

  /// Where the band begins: f_min of the PSD, or 1/20 of a cycle across the aperture where it begins below,
  /// since what is longer tilts the mirror and no more [cycles/m].
  double lowest() const;
  /// Where the band ends for light: f_max of the PSD, at most 1/wavelength [cycles/m].
  double highest() const;
  /// The finest difference of frequencies that the aperture tells apart: a cycle across, 1/diameter
  /// [cycles/m].
  double resolution() const;
  /// Cuts between which every spread is smooth, ascending from `lowest` to `highest` [cycles/m].
  const std::vector<double>& edges() const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

/// The smallest cut that keeps the limits.
struct SmallestCut {
  double frequency = 0;     ///< [cycles/m]
  bool whole_band = false;  ///< the limits hold with all of the roughness above the cut: no terms are needed
  /// The largest spread over its limit there; 1 unless `whole_band` or less than a `resolution` from the end.
  double share_of_limit = 0;
  int disc = -1;  ///< index of the disc that has it; -1 without discs
};
/// The smallest cut at and above which every spread is within its limit, solved to 1e-12 in the logarithm of
/// the frequency, so that it is continuous in specification and limits. `whole_band` with the frequency at
/// `lowest` where all limits hold there. A rest narrower than the aperture resolves is no part of its own,
/// and the spread of strong narrow bands there is more than the formula has (1.7 times: uniform, g = 5, 0.008
/// cycles across wide): from a width of one `resolution` down to a half the cut goes on to `highest`, twice
/// as fast, and stays there. Throws std::invalid_argument where the number of limits is not that of the discs
/// or a limit is not above zero. limits: largest standard deviation that is allowed, one per disc, > 0.
SmallestCut smallest_cut(const RealisationSpread& spread, const Eigen::ArrayXd& limits);

}  // namespace aberfit
