// Tables and results that the program reads: PSDs, coefficients, CODE V listings, curves of a focus, records
// of a sweep.
#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/cases/case_record.h"
#include "aberfit/measured/focal_data.h"
#include "aberfit/report/exports.h"
#include "aberfit/report/result.h"
#include "aberfit/roughness/psd_table.h"
#include "harness.h"
#include "targets.h"

namespace aberfit::test {
namespace {

void require_table(const PsdTableResult& result) {
  const TablePsd& table = result.psd;
  require(table.frequency.size() >= 2 && table.frequency.size() == table.psd.size(),
          "a table has two rows or more");
  for (std::size_t i = 0; i < table.frequency.size(); ++i)
    require(std::isfinite(table.frequency[i]) && table.frequency[i] > 0 && std::isfinite(table.psd[i]) &&
                table.psd[i] > 0,
            "numbers of a table are positive and finite");
}

void read_psd_tables(std::string_view bytes) {
  const std::string path = fuzz_folder().write("table.csv", bytes);
  const PsdTableOptions by_header;
  PsdTableOptions plain;
  plain.frequency_factor = 1, plain.psd_factor = 1;
  PsdTableOptions profile;
  profile.kind = PsdTableKind::k1dOneSided, profile.of = PsdTableOf::kWavefront;
  profile.frequency_factor = 1e3, profile.psd_factor = 1e-21, profile.height_factor = 2;
  profile.f_min = 100, profile.f_max = 5000;
  for (const PsdTableOptions& options : {plain, profile, by_header})
    read_or_refuse([&] { require_table(read_psd_table(path, options)); });
}

std::vector<std::string> psd_table_seeds() {
  return {"f_per_mm,psd,n\n0.05,15306,12\n0.1,1657,16\n0.2,105,3\n1.5,1.25,1\n",
          "# made\n1 1e-20\n10 1e-22\n2000 1e-27\n", "0.1;3e-5\n1;1e-6\n10;1e-9\n",
          "f (cycles/mm);S [nm^2/(cycles/mm)^2]\n1;2\n2;1\n"};
}

void read_coefficients(std::string_view bytes) {
  const std::string path = fuzz_folder().write("coefficients.csv", bytes);
  read_or_refuse([&] {
    TermSet terms;
    const Eigen::VectorXd coefficients = read_coefficients_csv(path, &terms);
    require(coefficients.size() == terms.size() && coefficients.allFinite(), "a number for every term");
    TermSet again;  // the rewritten terms are the same
    const std::string copy = fuzz_folder().write("again.csv", coefficients_csv(terms, coefficients, {}));
    require((read_coefficients_csv(copy, &again).array() == coefficients.array()).all(),
            "coefficients survive a round trip");
  });
}

std::vector<std::string> coefficient_seeds() {
  TermSet terms;
  terms.radius = 0.2;
  terms.zernike = zernike_modes(2, 4);
  terms.fourier = {{2.5, 1}, {-3, 7}};
  terms.spherical = {4, 6};
  return {coefficients_csv(terms, Eigen::VectorXd::LinSpaced(terms.size(), -1e-9, 2e-9), {})};
}

void read_listing(std::string_view bytes) {
  const std::string path = fuzz_folder().write("terms.int", bytes);
  read_or_refuse([&] {
    for (const double c : read_codev_zfr(path)) require(std::isfinite(c), "coefficients are finite");
  });
}

std::vector<std::string> listing_seeds() {
  return {"title\nZFR 9 SUR WVL 0.6328\n0 0.1 -0.2 0.3 1e-2\n0 0 0.5 0\n", "t\nZFR 1 WFR WVL 1\n0.25\n"};
}

void read_focus(std::string_view bytes) {
  const std::string path = fuzz_folder().write("focus", bytes);
  read_or_refuse([&] { is_focal_image(path); });
  for (const char* unit : {"", "um", "arcsec"})
    read_or_refuse([&] {
      const EncircledCurve curve = read_encircled_curve(path, unit);
      require(curve.radius.size() == curve.share.size(), "a share for every radius");
      require(curve.noise.size() == 0 || curve.noise.size() == curve.radius.size(), "noise of all or none");
      for (Eigen::Index k = 0; k < curve.radius.size(); ++k)
        require(curve.radius[k] > (k > 0 ? curve.radius[k - 1] : 0) && std::isfinite(curve.share[k]),
                "radii ascend from above zero");
    });
  read_or_refuse([&] {
    const FocalImage image = read_focal_image(path);
    require(std::size_t(image.light.size()) <= bytes.size(), "an image fits in its file");
    require(image.pixel >= 0, "a pixel has a side");
  });
}

std::vector<std::string> focus_seeds() {
  return {"radius_um,share,noise\n0,0,0\n1,0.3,0.01\n2.5,0.71,0.01\n9,0.98,0.02\n",
          "# star\ndiameter [arcsec] ee [%]\n0.2 40\n0.6 81\n", "1;2;3;4\n2;9;8;4\n2;8;9;3\n1;2;nan;1\n"};
}

// A record that was read from a line must say the same when it is written again.
void read_case_record(std::string_view bytes) {
  const std::optional<CaseRecord> record = record_of(std::string(bytes));
  if (!record) return;
  const std::string once = to_line(*record);
  const std::optional<CaseRecord> again = record_of(once);
  require(again && to_line(*again) == once, "a record survives a round trip");
}

std::vector<std::string> case_record_seeds() {
  CaseRecord record;
  record.id = "0f5b", record.base = "eead", record.index = 3;
  record.at = {{"/roughness/psd/rms", "\"10 nm\""}, {"/mirror/conic", "-0.9"}};
  record.values = {{"ee80_radius_m", 5.4e-6}, {"ring_fwhm_m", std::nan("")}};
  CaseRecord failed = record;
  failed.error = "the theory has no value", failed.verdict = "different", failed.warnings = {"few-modes"};
  return {to_line(record), to_line(failed)};
}

}  // namespace

std::vector<FuzzTarget> table_targets() {
  return {{"psd-table", read_psd_tables, psd_table_seeds, 1024},
          {"coefficients", read_coefficients, coefficient_seeds, 4096},
          {"codev-zfr", read_listing, listing_seeds, 1024},
          {"focus", read_focus, focus_seeds, 2048},
          {"case-record", read_case_record, case_record_seeds, 2048}};
}

}  // namespace aberfit::test
