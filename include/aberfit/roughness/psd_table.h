#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "aberfit/roughness/psd.h"

namespace aberfit {

enum class PsdTableKind {
  k2dTwoSided,  ///< S2 [m^4] of an isotropic surface
  k1dOneSided,  ///< S1 [m^3] of a profile, f > 0 only, int_0^inf S1 df = variance
};
enum class PsdTableOf { kSurface, kWavefront };  ///< a wavefront has twice the height: S is divided by 4

/// The meaning of the columns of a PSD table, and the band to keep.
struct PsdTableOptions {
  /// Factors to SI: column 1 to cycles/m, column 2 to m^4 (2-D) or m^3 (1-D). Absent: those of the header, or
  /// 1.
  std::optional<double> frequency_factor = std::nullopt, psd_factor = std::nullopt;
  PsdTableKind kind = PsdTableKind::k2dTwoSided;
  PsdTableOf of = PsdTableOf::kSurface;
  double height_factor = 1;                                          ///< heights are multiplied by this
  std::optional<double> f_min = std::nullopt, f_max = std::nullopt;  ///< band to keep [cycles/m]
};

/// A PSD table in SI units.
struct PsdTableResult {
  TablePsd psd;                        ///< surface, two-dimensional, two-sided; cut to the band
  double variance_left_out = 0;        ///< fraction of the table's height variance outside the band, 0..1
  double slope_variance_left_out = 0;  ///< the same for the slope variance
  std::size_t not_positive = 0;        ///< points of a 1-D table, where S1 rises, with 2-D PSD <= 0; omitted
  double tail_exponent = 0;            ///< 1-D tables: assumed S1 ~ f^-tail_exponent beyond the last point
};

/// Reads a text file whose first two columns are f and PSD, separated by comma, semicolon, space or tab.
/// Other columns are ignored. '#' starts a comment. Before the numbers there may be one row of names and one
/// of units. The last comment before the numbers also counts as a header. Examples: "f [1/mm], PSD [nm^2
/// mm^2]", "f_per_mm,psd_nm2_mm2". Throws InputError, with the line, for values that are not numbers, not
/// positive or not ascending, for fewer than 2 rows and for a band outside the table. It also throws for
/// units that are missing, contradict the options or belong to the other kind.
PsdTableResult read_psd_table(const std::string& path, const PsdTableOptions& options);

/// The same for columns in memory, in file units. Errors name `source` and the line numbers (may be empty).
PsdTableResult psd_from_table(const std::vector<double>& frequency, const std::vector<double>& psd,
                              const PsdTableOptions& options, const std::string& source,
                              const std::vector<int>& lines = {});

/// S2 [m^4] at the points of a one-sided profile PSD S1 [m^3] of an isotropic surface, by the Abel relation
///   S2(f) = -(1/(2 pi)) int_f^inf S1'(x) / sqrt(x^2 - f^2) dx
/// (Church, Takacs and Leonard 1989; half the two-sided relation). Between points S1 is a power of f and each
/// piece is integrated to 1e-14; beyond the last point S1 goes on as f^-tail_exponent for ever. Values may be
/// negative where S1 rises. frequency: ascending, > 0 [cycles/m].
std::vector<double> abel_1d_to_2d(const std::vector<double>& frequency, const std::vector<double>& psd_1d,
                                  double tail_exponent);

/// Exponent that abel_1d_to_2d should assume beyond the end of a table. It is that of a power law fitted to
/// log S1 over log f in the last octave, at least the last three points (two if there are no more).
double fitted_tail_exponent(const std::vector<double>& frequency, const std::vector<double>& psd_1d);

}  // namespace aberfit
