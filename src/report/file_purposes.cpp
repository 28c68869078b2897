#include "file_purposes.h"

#include <filesystem>
#include <set>

namespace aberfit::internal {
namespace {

namespace fs = std::filesystem;

struct Known {
  const char* name;  // a trailing / means all files of a folder
  const char* purpose;
};

constexpr Known kKnown[] = {
    {"report.html", "this page"},
    {"summary.txt", "the tables of this page as text"},
    {"result.json", "every number of the result, and the study with all defaults filled in"},
    {"coefficients.csv", "the terms: Zernike, Fourier and spherical coefficients of the surface [m]"},
    {"scatter.csv", "scatter function (BSDF, ARS, ABg) of the roughness that no term carries"},
    {"scatter_psd.csv", "PSD of the roughness that no term carries"},
    {"exports/", "the surface of the terms for other optical programs"},
    {"arrays.npz", "encircled energy, PSF and OTF for numpy.load"},
    {"arrays/", "encircled energy, PSF and OTF as CSV tables"},
    {"psf.fits", "PSF of surface and theory as a FITS image"},
    {"otf.fits", "OTF of surface and theory as a FITS image"},
    {"psd.csv", "PSD bin by bin; a study can read this table"},
    {"bands.csv", "RMS height and slope by band and by octave"},
    {"roughness.json", "fitted PSD model, a block to paste into a study"},
    {"contour.csv", "pairs of the two unknowns that just meet the budgets"},
    {"ceilings.csv", "largest roughness of each octave"},
    {"focus.csv", "measured and fitted energy by radius"},
    {"cases.csv", "values and statistics of each case, one line per case"},
    {"quantiles.csv", "quantiles over the realisations of each combination of values"},
    {"chart.csv", "error and time of each method and setting, one line each"},
    {"plots/", "pictures, each with its gnuplot script and data"}};

bool is_there(const fs::path& folder, const std::string& name) {
  std::error_code none;
  return fs::exists(folder / name, none);
}

}  // namespace

std::vector<NamedPurpose> files_with_purpose(const std::string& folder) {
  std::vector<NamedPurpose> files;
  std::set<std::string> known;
  for (const Known& one : kKnown) {
    known.insert(one.name);
    if (std::string(one.name) == "report.html" || is_there(folder, one.name))
      files.push_back({one.name, one.purpose});
  }
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string() + (entry.is_directory() ? "/" : "");
    if (!known.contains(name) && !name.starts_with('.')) files.push_back({name, ""});
  }
  return files;
}

std::vector<NamedPurpose> uses_of_terms(const std::string& folder) {
  std::vector<NamedPurpose> uses;
  if (!is_there(folder, "coefficients.csv")) return uses;
  const bool scatter = is_there(folder, "scatter.csv");
  const auto from = [&](const std::string& file, const std::string& word) {
    return is_there(folder, "exports/" + file) ? "exports/" + file
                                               : "an export (\"output\": {\"export\": [\"" + word +
                                                     "\"]} in the study writes exports/" + file + ")";
  };
  uses.push_back({"OpticStudio", "Surface: " + from("grid_sag.DAT", "zemax-grid-sag") +
                                     " as a Grid Sag surface with bicubic interpolation." +
                                     (scatter ? " Scatter: enter the ABg numbers in the comments of "
                                                "scatter.csv, or convert its table to a BSDF file."
                                              : "")});
  uses.push_back(
      {"CODE V",
       "Surface: " + from("surface.int", "codev-int") + " as an interferogram of kind SUR on the mirror." +
           (scatter ? " CODE V has no scatter model: take scatter.csv to the stray-light program." : "")});
  if (scatter)
    uses.push_back(
        {"FRED, ASAP, LightTools",
         "Scatter: enter the ABg numbers in the comments of scatter.csv, or its table as a tabulated BSDF."});
  uses.push_back(
      {"prysm",
       "Surface: add up the orthonormal Zernikes, prysm.polynomials.zernike_nm(n, m, rho, theta, norm=True) "
       "times value_m of coefficients.csv. The optical path difference is twice the surface." +
           std::string(scatter ? " Scatter: multiply the OTF by the mean transfer function of "
                                 "scatter_psd.csv."
                               : "")});
  uses.push_back(
      {"POPPY", "Surface: " + from("opd.fits", "fits-opd") +
                    " as the opd of a FITSOpticalElement; it is already twice the surface." +
                    (scatter ? " Scatter: convolve the image with the halo of scatter.csv." : "")});
  return uses;
}

}  // namespace aberfit::internal
