// Tables and results that the program reads: PSDs, coefficients, charts, CODE V listings.
#include <cmath>
#include <nlohmann/json.hpp>

#include "aberfit/report/exports.h"
#include "aberfit/report/fit_rates.h"
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
  PsdTableOptions plain;
  PsdTableOptions profile;
  profile.kind = PsdTableKind::k1dOneSided, profile.of = PsdTableOf::kWavefront;
  profile.frequency_factor = 1e3, profile.psd_factor = 1e-21, profile.height_factor = 2;
  profile.f_min = 100, profile.f_max = 5000;
  for (const PsdTableOptions& options : {plain, profile})
    read_or_refuse([&] { require_table(read_psd_table(path, options)); });
}

std::vector<std::string> psd_table_seeds() {
  return {"f_per_mm,psd,n\n0.05,15306,12\n0.1,1657,16\n0.2,105,3\n1.5,1.25,1\n",
          "# made\n1 1e-20\n10 1e-22\n2000 1e-27\n", "0.1;3e-5\n1;1e-6\n10;1e-9\n"};
}

void read_coefficients(std::string_view bytes) {
  const std::string path = fuzz_folder().write("coefficients.csv", bytes);
  read_or_refuse([&] {
    TermSet terms;
    const Eigen::VectorXd coefficients = read_coefficients_csv(path, &terms);
    require(coefficients.size() == terms.size() && coefficients.allFinite(), "a number for every term");
    TermSet again;  // what is written of it is the same
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

void read_chart(std::string_view bytes) {
  const std::string path = fuzz_folder().write("chart.json", bytes);
  bool same = false;
  read_or_refuse([&] { read_rates(path, nlohmann::ordered_json::object(), &same); });
}

std::vector<std::string> chart_seeds() {
  nlohmann::ordered_json chart = {{"kind", "chart"}, {"study", nlohmann::ordered_json::object()}};
  chart["rates"] = to_json(FitRates());
  for (const char* size : {"rays", "terms", "fitted", "judged", "threads"}) chart["rates"]["size"][size] = 2;
  return {chart.dump()};
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

}  // namespace

std::vector<FuzzTarget> table_targets() {
  return {{"psd-table", read_psd_tables, psd_table_seeds, 1024},
          {"coefficients", read_coefficients, coefficient_seeds, 4096},
          {"chart", read_chart, chart_seeds, 2048},
          {"codev-zfr", read_listing, listing_seeds, 1024}};
}

}  // namespace aberfit::test
