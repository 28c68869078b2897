#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"

namespace aberfit {

/// The frequency where the terms of a measured part end and the specification takes over.
struct PartBand {
  double terms = 0;    ///< end of the terms, see terms_end [cycles/m]
  double nyquist = 0;  ///< of the map [cycles/m]
  double cut = 0;      ///< [cycles/m]
  bool named = false;  ///< by the study
};

/// Frequency where terms of degree n on a disc end [cycles/m]. Above it, the specification has as much height
/// variance as the terms leave of it, so that no variance counts twice or is lost. The residual is what
/// piston, tilt and all Zernikes up to n leave, in the mean over the disc. The result lies above (n + 1)/(2
/// pi R), where the spectrum of a Zernike, J_{n+1}(2 pi R f)/f, has its maximum to first order in n: by 23 %
/// for n = 20 and a 2-D PSD that falls as f^-2.6. A cut at (n + 1)/(2 pi R) would make that scatter 12 % too
/// strong. Returns (n + 1)/(2 pi R) where the band ends below it.
double terms_end(const RadialPsd& psd, int degree, double radius);
/// Highest degree from 2 on with terms_end not above `cut` [cycles/m]; most + 1 where that is above `most`.
int degree_below(const RadialPsd& psd, double cut, double radius, int most);

/// Returns the band with its cut: `terms.band` where that is a frequency; else terms_end, at most the map's
/// Nyquist frequency 1/(2 pitch). The terms are those of the fit; a realisation of the specification may need
/// others.
PartBand part_band(const Task& task, const TermSet& terms, const HeightMap& map);

/// Layout of a measured part: targets by generalised Harvey-Shack of the whole specification, and scatter
/// above the cut. `shares` is filled even without scatter. task.psd must be present. Throws FieldError for a
/// task that wave optics cannot judge.
Layout lay_out_part(const Task& task, const TermSet& terms, const PartBand& band, int threads);

/// Judges a measured part: the fitted terms with the scatter of the rest against the specification. result:
/// with terms, fit and map; all other members of a fit's outcome are filled in. Undecided where the points of
/// the map do not determine the terms.
void judge_part(const FitCase& of, const PartBand& band, FitOutcome* result);

/// Pitch [m] of the grid that judges the part; where it would be too fine, that of law::kMostCells.
double part_pitch(const FitCase& of, const FitOutcome& result);

}  // namespace aberfit
