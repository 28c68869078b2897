#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"
#include "aberfit/theory/abg_fit.h"
#include "aberfit/theory/scatter_function.h"

namespace aberfit {

/// Export of the part of the roughness that no term carries.
struct ScatterExport {
  std::string title;  ///< for people, one line
  ScatterTable table;
  std::vector<AbgFit> abg;       ///< none, or several with different ranges or smallest b
  std::optional<PsdModel> rest;  ///< the PSD of that part (psd_in_band); empty when there is none
  bool has_terms = true;         ///< false if there are no terms and the whole PSD scatters
};

/// Text in place of the numbers of an ABg fit that does not describe its function: the range, the error of
/// the nearest model, and an alternative. It has no full stop.
std::string no_abg(const AbgFit& fit);

/// scatter.csv: columns theta_rad,asf_per_sr,bsdf_per_sr,tis_within in SI units and radians. Comment lines
/// ('#') before them give wavelength, band, RMS height, slope and TIS, the meaning of the columns, every ABg
/// fit that describes the table with its range and errors, the parameters of the PSD if it has some, and the
/// use together with the terms.
std::string scatter_csv(const ScatterExport& scatter);

/// The PSD of the rest as a table for any program: comment lines, the names frequency_per_m,psd_2d_m4, and
/// rows up to 1/wavelength. Log-log interpolation between rows is within 1e-3 of S. A jump inside the band
/// lies between two rows 2e-9 of their frequency apart; S below 1e-290 m^4 is replaced by that value. A band
/// from 0 begins at a thousandth of the lowest breakpoint. read_psd_table reads the table.
std::string scatter_psd_csv(const PsdModel& rest, double wavelength);

}  // namespace aberfit
