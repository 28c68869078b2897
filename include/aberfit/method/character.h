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

/// A property of one surface beside the same property of random surfaces of the roughness.
struct BesideDraws {
  double value = 0;          ///< of the surface
  double mean = 0;           ///< of the random surfaces
  double low = 0, high = 0;  ///< interval for one more random surface, see `Character`

  bool inside() const { return value >= low && value <= high; }
};

/// PSD of the surface in one bin of frequencies, over the mean PSD of the random surfaces.
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
  double stop = 1;              ///< fraction of the diameter that is left
  std::string obstacle;         ///< why there is no number, a clause; empty: there is one
  double worst = 0;             ///< largest difference of encircled energy, in tolerances
  double fraction = 0;          ///< fraction of the encircled energy that differs most
  double draws = 0;             ///< root mean square of `worst` over the random surfaces
};

/// Tests whether a term surface is typical of the roughness that its terms stand for. Five properties are
/// compared with those of `draws` random surfaces of that roughness, by the same estimators on the same grid.
/// Piston and tilt are removed from all of them, because terms have none.
///
/// The band of a property contains one more realisation with probability `law::kCharacterConfidence`: mean +-
/// t s sqrt(1 + 1/draws), with Student's t, for the cube root of the property. The cube root is used because
/// a PSD estimate has a gamma distribution, whose cube root is close to normal (Wilson & Hilferty 1931).
/// Several bins or zones divide the error probability among them (Bonferroni), so that a realisation has
/// *all* of its bins inside with that probability.
struct Character {
  int draws = 0;
  double f_low = 0, f_high = 0;   ///< compared band [cycles/m]: from 1.5 cycles across to the cut
  std::vector<CharacterBin> psd;  ///< empty: the terms end below 1.5 cycles across
  std::vector<ZoneSlope> zones;   ///< zones that contain part of the aperture
  BesideDraws slope_x_over_y;     ///< ratio of RMS slopes
  /// Two properties of the image in the focus, computed from the heights of the terms alone because mean
  /// scatter adds the same to every surface. length_over_width: root of the ratio of the principal second
  /// moments inside the image's ee90. bright_share: fraction of the energy between ee35 and ee90 that falls
  /// on the brightest hundredth of that area (pixels of half of lambda f/D).
  std::optional<BesideDraws> length_over_width, bright_share;
  std::string light_obstacle;      ///< why there is no image, a clause; empty: there is one
  std::vector<OtherLight> others;  ///< empty: the scene has no mean irradiance to compare with

  /// The property farthest outside its band, a clause: "PSD 3.1 times at 12 /m". Empty: all are inside.
  std::string fault() const;
};

/// Compares the surface of `terms` with random surfaces, which follow from `task.fit.seed`. terms: with
/// Zernikes or plane waves, whose specification `ground` has; coefficients [m]. Cost: some 40 transforms of a
/// grid with six grid cells per cycle of the cut.
Character character_of(const Task& task, const Groundwork& ground, const TermSet& terms,
                       const Eigen::VectorXd& coefficients, const RunContext& context);

}  // namespace aberfit
