#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/groundwork.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/task.h"
#include "aberfit/terms/term_set.h"

namespace aberfit {

/// A number of one surface beside the same number of draws of the roughness.
struct BesideDraws {
  double value = 0;          ///< of the surface
  double mean = 0;           ///< of the draws
  double low = 0, high = 0;  ///< what one more draw lies in, see `Character`

  bool inside() const { return value >= low && value <= high; }
};

/// PSD of the surface in one bin of frequencies, over the mean of draws.
struct CharacterBin {
  double low = 0, high = 0;  ///< edges [cycles/m]
  double specification = 0;  ///< mean of S over the ring of frequencies [m^4]
  BesideDraws ratio;         ///< `mean` is 1

  double middle() const;  ///< geometric mean of the edges [cycles/m]
};

/// RMS slope in a zone of the aperture over that of the whole aperture.
struct ZoneSlope {
  double rho_min = 0, rho_max = 0;  ///< edges as fractions of the aperture radius
  BesideDraws ratio;
};

/// The same surface at another wavelength, or behind a smaller stop.
struct OtherLight {
  double wavelength = 0;        ///< [m]
  double wavelength_ratio = 1;  ///< over that of the study
  double stop = 1;              ///< of the diameter that is left
  std::string obstacle;         ///< why there is no number, a clause; empty: there is
  double worst = 0;             ///< largest of the differences of encircled energy, in tolerances
  double fraction = 0;          ///< of which encircled energy
  double draws = 0;             ///< root mean square of the draws' own `worst`
};

/// Whether a term surface is one of the roughness that its terms stand for: five properties of it beside
/// those of `draws` random surfaces of that roughness, by the same estimators on the same grid. Piston and
/// tilt are off them all, as terms have none.
///
/// A band holds one more draw with `law::kCharacterConfidence`: mean +- t s sqrt(1 + 1/draws) with Student's
/// t, of the cube root of the property, because a PSD estimate has a gamma distribution, of which the cube
/// root is close to normal (Wilson & Hilferty 1931). Of several bins or zones at once each has its share of
/// what is left out (Bonferroni), so that a draw has *all* of its bins inside with that confidence.
struct Character {
  int draws = 0;
  double f_low = 0, f_high = 0;   ///< what is looked at [cycles/m]: 1.5 cycles across to the cut
  std::vector<CharacterBin> psd;  ///< empty: the terms end below 1.5 cycles across
  std::vector<ZoneSlope> zones;   ///< those that the aperture has
  BesideDraws slope_x_over_y;     ///< RMS slopes
  /// Of the image in the focus: root of the ratio of its principal second moments inside its ee90, and the
  /// share of the light between ee35 and ee90 that lies in the brightest hundredth of the area there (pixels
  /// of half of lambda f/D). Of the terms' heights alone: what the rest scatters adds the same to every
  /// surface.
  std::optional<BesideDraws> length_over_width, bright_share;
  std::string light_obstacle;      ///< why there is no image, a clause; empty: there is
  std::vector<OtherLight> others;  ///< empty: the scene has no mean light to compare with

  /// What is farthest outside its band, a clause: "PSD 3.1 times at 12 /m". Empty: nothing is.
  std::string fault() const;
};

/// terms: with Zernikes or plane waves, whose specification `ground` has; coefficients [m]. The random
/// surfaces follow from `task.fit.seed`. Cost: some 40 transforms of a grid with six cells a cycle of the
/// cut.
Character character_of(const Task& task, const Groundwork& ground, const TermSet& terms,
                       const Eigen::VectorXd& coefficients, const RunContext& context);

}  // namespace aberfit
