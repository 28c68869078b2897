#pragma once
#include <map>
#include <string>
#include <vector>

#include "aberfit/measured/clear_aperture.h"
#include "aberfit/method/outcome.h"

namespace aberfit {

/// Origin of a result, so that it can be reproduced.
struct Provenance {
  std::string version;  ///< version of aberfit
  std::string commit;   ///< commit of its source; empty if unknown
  std::uint64_t seed = 0;
  int threads = 1;
  std::map<std::string, std::string> libraries;  ///< name -> version, the compiler among them
  struct Input {
    std::string file, sha256;
  };
  std::vector<Input> inputs;  ///< the study and its data files
};

/// The processor of this machine and the number of its threads.
std::string this_machine();

/// Version of this library, its compiler and the libraries the report room can see (Eigen, Boost,
/// nlohmann-json, fmt). A room with a library of its own (Ceres in fit) adds that entry itself.
Provenance make_provenance(std::uint64_t seed, int threads);

/// The result of a fit.
struct ResultDocument : FitOutcome {
  std::string title;  ///< title of the study
  Provenance provenance;
  ClearRegion clear;  ///< clear part of a fitted map, in mirror coordinates
};

/// Zernike, Fourier and spherical coefficients, one per row, in the order of `terms`, after a commented
/// header with units, signs and conventions. Columns: kind (zernike, cos, sin, spherical), n (radial order;
/// power of rho), m, noll, fx_per_m, fy_per_m, value_m, std_m. Numbers carry the fewest digits that read back
/// to the same bits. `std`: standard deviations [m]; empty: the column has no values.
std::string coefficients_csv(const TermSet& terms, const Eigen::VectorXd& coefficients,
                             const Eigen::VectorXd& std);

/// Coefficients [m] from a file of coefficients_csv, in the order of `terms`; terms missing in the file are
/// 0. An empty set becomes the set of the file, radius included. Fourier frequencies match within 1e-9 of
/// their length. Throws InputError with file and line for an unreadable file, a missing or different
/// normalisation radius, an unknown kind, a term not in the set, a repeated term, or a value that is not a
/// finite number.
Eigen::VectorXd read_coefficients_csv(const std::string& path, TermSet* terms);

/// Writes `text` to `path` completely or not at all: into a file beside it, which is then renamed. Creates
/// the folder. Throws InputError on failure and then leaves nothing behind.
void write_file(const std::string& path, const std::string& text);

}  // namespace aberfit
