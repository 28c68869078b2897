// Study files. A study that was read, written out with its defaults, must be a study with the same meaning.
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "aberfit/study/read_study.h"
#include "harness.h"
#include "measured/synthetic_files.h"
#include "study/study_texts.h"
#include "targets.h"

namespace aberfit::test {
namespace {

// Writes small files under the names that the studies of fits/ use, so that these can be read to the end.
void write_data_of_studies() {
  DabamFile line;
  for (int i = 0; i < 64; ++i)
    line.rows.push_back(
        {double(i), std::sin(0.9 * i) + 0.3 * std::sin(2.1 * i * i) + 0.1 * std::cos(0.2 * i)});
  for (const char* name : {"smooth", "turned"}) line.write(fuzz_folder(), name);
  MetroProFile map;
  map.columns = map.rows = 8;
  map.count = [](std::uint32_t r, std::uint32_t c) { return std::int32_t((r * 73 + c * 151) % 997); };
  fuzz_folder().write("interferogram.dat", map.bytes());
  const std::string table = "f,psd\n0.06,15306\n0.1,1250\n0.2,105\n1.5,1.25\n3,0.1\n";
  for (const char* name : {"prysm_zygo_radial_psd.csv", "psd.csv"}) fuzz_folder().write(name, table);
  fuzz_folder().write("ee.csv", "radius_um,share\n1,0.4\n3,0.8\n9,0.95\n");
  fuzz_folder().write("ring_through.csv", "dz, share\n-0.001, 0.1\n0, 0.8\n0.001, 0.2\n");
}

void read_study_text(std::string_view bytes) {
  static const bool written = (write_data_of_studies(), true);
  require(written, "the files are there");
  const std::string path = fuzz_folder().path("study.json");
  Study study;
  if (!read_or_refuse([&] { study = parse_study(std::string(bytes), path); })) return;
  const std::string once = resolved_study(study).dump();
  try {
    require(resolved_study(parse_study(once, path)).dump() == once, "a resolved study says the same");
  } catch (const InputError& error) {
    require(false, std::string("a resolved study can be read: ") + error.what());
  }
}

std::vector<std::string> study_seeds() {
  std::vector<std::string> seeds = {kMinimalStudy, kFullStudy};
  for (const auto& [block, asked] : {
           std::pair{"/solve",
                     R"({"for": ["/roughness/psd/rms"], "so_that": {"ee80_diameter": "<= 0.6 arcsec",
          "pssn@0.2m": ">= 0.9", "rms_height@10/m-30/m": "<= lambda/20"}, "with": {"jitter": "0.1 arcsec",
          "surfaces": [{"name": "flat", "footprint": 0.4, "incidence": "0.1 rad",
                        "psd": {"model": "uniform", "rms": "5 nm", "f_min": "10 /m", "f_max": "40 /m"}}]}})"},
           std::pair{"/solve", R"({"for": ["/roughness/psd/rms"], "focus": {"file": "ee.csv", "of": "mean",
          "pixel": "2 um", "reach": "4 arcsec", "noise": 0.01}})"},
           std::pair{"/solve", R"({"ceilings": {"f_max": "1 /mm"}, "so_that": {"strehl": ">= 0.8"}})"},
           std::pair{"/vary", R"({"over": {"/roughness/psd/rms": {"from": "5 nm", "to": "40 nm", "count": 3,
          "spacing": "log"}, "/light/wavelength": ["0.4 um", "1 um"]}, "realisations": 2, "run": "trace"})"},
           std::pair{"/vary",
                     R"({"over": {"/roughness/psd/rms": {"from": "5 nm", "to": "40 nm"}}, "design": "sobol",
          "cases": 4, "seed": 3})"},
       })
    seeds.push_back(changed(block, asked));
  for (const auto& folder :
       std::filesystem::directory_iterator(std::filesystem::path(ABERFIT_SOURCE_DIR) / "fits"))
    if (const auto file = folder.path() / "study.json"; std::filesystem::exists(file))
      seeds.push_back(bytes_of(file));
  return seeds;
}

}  // namespace

std::vector<FuzzTarget> study_targets() { return {{"study", read_study_text, study_seeds, 8192}}; }

}  // namespace aberfit::test
