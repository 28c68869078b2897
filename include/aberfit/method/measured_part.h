#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"

namespace aberfit {

/// Where the terms of a measured part end and the specification takes over.
struct PartBand {
  double terms = 0;    ///< where the terms end, see terms_end [cycles/m]
  double nyquist = 0;  ///< of the map [cycles/m]
  double cut = 0;      ///< [cycles/m]
  bool named = false;  ///< by the study
};

/// Where terms of degree n on a disc end [cycles/m]: above, the specification has as much height variance as
/// they leave of it, so that nothing counts twice and nothing is lost. They leave what piston, tilt and all
/// Zernikes up to n do, in the mean over the disc. It lies above (n + 1)/(2 pi R), where the spectrum of a
/// Zernike, J_{n+1}(2 pi R f)/f, has its maximum to first order in n: by 23 % for n = 20 and a 2-D PSD that
/// falls as f^-2.6, where a cut there makes the scatter 12 % too strong, and the light of ten drawn parts 1.7
/// standard deviations of the spread of the rest too weak in the mean (with this cut 0.4 too strong).
/// (n + 1)/(2 pi R) itself where the band ends below it.
double terms_end(const RadialPsd& psd, int degree, double radius);
/// Highest degree from 2 on whose terms_end is not above `cut` [cycles/m]; most + 1 where that is above
/// `most`.
int degree_below(const RadialPsd& psd, double cut, double radius, int most);

/// `terms.band` where it is a frequency; else terms_end, at most the map's Nyquist frequency 1/(2 pitch): the
/// terms are fitted, whatever a mirror drawn from the specification would need.
PartBand part_band(const Task& task, const TermSet& terms, const HeightMap& map);

/// The specification of a measured part laid out: targets by generalised Harvey-Shack of all of it, and what
/// lies above the cut as scatter. In `shares` also where there is none. Throws FieldError for a task that
/// light cannot judge. task.psd is there.
Layout lay_out_part(const Task& task, const TermSet& terms, const PartBand& band, int threads);

/// Judges a measured part: the light of `result`'s fitted terms times the scatter of the rest against the
/// specification's. result: with terms, fit and map; everything else that a fit's outcome has is filled in.
/// Undecided where the points of the map do not determine the terms.
void judge_part(const FitCase& of, const PartBand& band, FitOutcome* result);

/// Pitch [m] of the grid that the part is judged on, and where that would be too fine, of law::kMostCells.
double part_pitch(const FitCase& of, const FitOutcome& result);

}  // namespace aberfit
