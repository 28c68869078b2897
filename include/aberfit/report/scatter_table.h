#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/theory/abg_fit.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// What leaves the program for the part of the roughness that no term carries.
struct ScatterExport {
  std::string title;  ///< for people, one line
  ScatterTable table;
  std::vector<AbgFit> abg;       ///< none, or several, with different ranges or least b
  std::optional<PsdModel> rest;  ///< the PSD of that part (psd_in_band); empty when there is none
  bool has_terms = true;         ///< false where no terms go with it and the whole PSD is scatter
};

/// What takes the place of the numbers of an ABg fit that does not describe its function: the range, by how
/// much the nearest model is off, and what to use. No full stop.
std::string no_abg(const AbgFit& fit);

/// scatter.csv: columns theta_rad,asf_per_sr,bsdf_per_sr,tis_within, after comment lines ('#') that say of
/// what wavelength, band, RMS height, slope and TIS the table is, what its columns are, every ABg fit that
/// describes it with its range and errors, the parameters of the PSD where it has some, and how it goes
/// together with the terms. SI units and radians.
std::string scatter_csv(const ScatterExport& scatter);

/// The PSD of the rest as a table for any program: comment lines, the names frequency_per_m,psd_2d_m4, and
/// rows at which log-log interpolation is within 1e-3 of S, up to 1/wavelength; a jump inside the band lies
/// between two rows 2e-9 of their frequency apart, and where S is less than 1e-290 m^4 that stands there.
/// read_psd_table reads it. A band that starts at 0 begins at a thousandth of the lowest breakpoint.
std::string scatter_psd_csv(const PsdModel& rest, double wavelength);

}  // namespace aberfit
