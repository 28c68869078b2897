#pragma once
#include "aberfit/measured/height_map.h"
#include "aberfit/method/attempt.h"
#include "aberfit/method/band_choice.h"

namespace aberfit {

/// Where the terms of a measured part end and the specification takes over.
struct PartBand {
  double terms = 0;    ///< highest frequency that the terms resolve, see terms_end [cycles/m]
  double nyquist = 0;  ///< of the map [cycles/m]
  double cut = 0;      ///< [cycles/m]
  bool named = false;  ///< by the study
};

/// The highest frequency [cycles/m] that terms of degree n on a disc of radius R resolve: (n + 1)/(2 pi R),
/// where the spectrum of a Zernike, J_{n+1}(2 pi R f)/f, has its first maximum to first order in n. 0 without
/// Zernikes and spherical powers.
double terms_end(const TermSet& terms);
/// Highest order whose terms_end is not above `cut` [cycles/m], at least 2.
int order_below(double cut, double radius);

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

/// Pitch [m] of the grid that the part is judged on, and where that would be too fine, of kMostJudgedCells.
double part_pitch(const FitCase& of, const FitOutcome& result);

}  // namespace aberfit
