// A study that a program fills in gives the same result, to the bit, as a file with the same content.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "aberfit/commands/run.h"
#include "aberfit/core/errors.h"
#include "aberfit/report/documents.h"
#include "aberfit/report/result.h"
#include "aberfit/study/read_study.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;
using test::read_file;
using test::ScratchFolder;

// Removes times and other values that differ between any two runs.
void take_times_off(ordered_json* node) {
  if (node->is_object()) {
    node->erase("provenance");
    for (const char* key : {"seconds", "solve_seconds", "fit_seconds"}) node->erase(key);
  }
  if (!node->is_structured()) return;
  for (auto& item : node->items()) take_times_off(&item.value());
}

class FilledStudy : public testing::Test {
 protected:
  const ScratchFolder folder_;

  // result.json as the program writes it.
  std::string written(const Study& study) const {
    RunOptions options;
    options.output_directory = folder_.file("out");
    options.pictures = PictureFormat::kNone;
    options.threads = 2;
    run_fit(study, options);
    ordered_json result = ordered_json::parse(read_file(folder_.file("out/result.json")));
    take_times_off(&result);
    return result.dump(1);
  }
  void expect_same(const Study& filled, const std::string& text) const {
    const std::string by_file = written(read_study(folder_.write("study.json", text)));
    EXPECT_EQ(written(filled), by_file);
    EXPECT_GT(by_file.size(), 1000u);
  }
};

Study scene(double focal_length, const Aperture& aperture, double wavelength) {
  Study study;
  study.mirror.focal_length = focal_length;
  study.aperture = aperture;
  study.wavelength = wavelength;
  return study;
}

StatisticRequest request(const std::string& name) {
  StatisticRequest one;
  one.name = name;
  return one;
}

// Only the four required blocks are given: theory, statistics, terms, rays and verdict must be those of a
// file.
TEST_F(FilledStudy, OfACircleWithNothingElseSaid) {
  Study study = scene(2, CircleAperture{0.2}, 633e-9);
  study.psd = UniformPsd{20e-9, 10, 20};
  expect_same(study, R"({"aberfit": 1, "mirror": {"focal_length": 2},
    "aperture": {"shape": "circle", "diameter": 0.2}, "light": {"wavelength": 633e-9},
    "roughness": {"psd": {"model": "uniform", "rms": 20e-9, "f_min": 10, "f_max": 20}}})");
}

TEST_F(FilledStudy, OfARoughCircleByTheGeometricTheory) {
  Study study = scene(2.8, CircleAperture{0.4}, 632.8e-9);
  study.psd = UniformPsd{100e-9, 2.5, 6};
  study.target.theory = Theory::kGeometric;
  study.target.statistics = {request("ee50")};
  expect_same(study, R"({"aberfit": 1, "mirror": {"focal_length": 2.8},
    "aperture": {"shape": "circle", "diameter": 0.4}, "light": {"wavelength": 632.8e-9},
    "roughness": {"psd": {"model": "uniform", "rms": 100e-9, "f_min": 2.5, "f_max": 6}},
    "target": {"theory": "geometric", "statistics": {"ee50": {}}}})");
}

// The known Zernikes use the disc of the aperture by default; the power law has no upper band limit.
TEST_F(FilledStudy, OfAnAnnulusWithKnownZernikesAndAPowerLaw) {
  Study study = scene(3, AnnulusAperture{0.3, 0.1}, 500e-9);
  study.mirror.zernike = {{ZernikeMode{2, 0}, 20e-9}, {ZernikeMode{4, 0}, 30e-9}};
  study.psd = PowerLawPsd{.rms = 80e-9, .amplitude = {}, .exponent = 5, .f_min = 4};
  study.target.theory = Theory::kGeometric;
  study.target.statistics = {request("ee80"), request("ring_fwhm")};
  study.terms.zernike = ZernikeSpec{2, 6};
  study.trace.pupil.rays = 4096;
  expect_same(study, R"({"aberfit": 1,
    "mirror": {"focal_length": 3, "zernike": {"noll": {"4": 20e-9, "11": 30e-9}}},
    "aperture": {"shape": "annulus", "diameter": 0.3, "inner_diameter": 0.1}, "light": {"wavelength": 500e-9},
    "roughness": {"psd": {"model": "power-law", "rms": 80e-9, "exponent": 5, "f_min": 4}},
    "target": {"theory": "geometric", "statistics": {"ee80": {}, "ring_fwhm": {}}},
    "terms": {"zernike": {"n_max": 6}}, "trace": {"rays": 4096}})");
}

// A rectangle has Sobol rays; a circle has polar ones.
TEST_F(FilledStudy, OfARectangleWithAKCorrelation) {
  Study study = scene(2.5, RectangleAperture{0.3, 0.2}, 600e-9);
  study.psd = KCorrelationPsd{120e-9, 0.2, 4.5, 3, 12};
  study.target.theory = Theory::kGeometric;
  study.target.statistics = {request("ee50"), request("scatter_rms"), request("rms_height")};
  study.terms.fourier = FourierSpec{60, FourierSampling::kLog};
  study.trace.pupil.rays = 4096;
  expect_same(study, R"({"aberfit": 1, "mirror": {"focal_length": 2.5},
    "aperture": {"shape": "rectangle", "width": 0.3, "height": 0.2}, "light": {"wavelength": 600e-9},
    "roughness": {"psd": {"model": "k-correlation", "rms": 120e-9, "B": 0.2, "exponent": 4.5, "f_min": 3,
                          "f_max": 12}},
    "target": {"theory": "geometric", "statistics": {"ee50": {}, "scatter_rms": {}, "rms_height": {}}},
    "terms": {"fourier": {"count": 60}}, "trace": {"rays": 4096}})");
}

TEST_F(FilledStudy, OfASumWithNamedStatisticsAndValues) {
  Study study = scene(2, CircleAperture{0.3}, 550e-9);
  study.psd = SumPsd{{UniformPsd{60e-9, 4, 8}, GaussianPsd{50e-9, 0.08}}};
  study.target.theory = Theory::kGeometric;
  study.target.statistics = {request("ee50"), request("ee90"), request("rms_height")};
  study.target.statistics[0].planes = {0, -1e-3};
  study.target.statistics[1].tolerance = 2e-3;
  study.terms.zernike = ZernikeSpec{2, 8};
  study.terms.spherical = {4};
  study.trace.pupil.rays = 4096;
  study.fit.seed = 3;
  expect_same(study, R"({"aberfit": 1, "mirror": {"focal_length": 2},
    "aperture": {"shape": "circle", "diameter": 0.3}, "light": {"wavelength": 550e-9},
    "roughness": {"psd": {"model": "sum", "parts": [
      {"model": "uniform", "rms": 60e-9, "f_min": 4, "f_max": 8},
      {"model": "gaussian", "rms": 50e-9, "correlation_length": 0.08}]}},
    "target": {"theory": "geometric", "statistics": {"ee50": {"planes": [0, -1e-3]},
               "ee90": {"tolerance": 2e-3}, "rms_height": {}}},
    "terms": {"zernike": {"n_max": 8}, "spherical": ["c4"]}, "trace": {"rays": 4096}, "fit": {"seed": 3}})");
}

// A file that the struct names is read when it is needed.
TEST_F(FilledStudy, OfATableFile) {
  folder_.write("psd.csv", "frequency,psd\n4,1e-16\n6,6e-17\n9,2e-17\n12,4e-18\n");
  Study study = scene(2.8, CircleAperture{0.4}, 632.8e-9);
  study.path = folder_.file("study.json");
  PsdTableFile table;
  table.file = "psd.csv";
  table.frequency_unit = "/m";
  table.psd_unit = "m^4";
  table.f_max = 10;
  study.roughness = RoughnessModel{table};
  study.target.theory = Theory::kGeometric;
  study.target.statistics = {request("ee50")};
  study.terms.zernike = ZernikeSpec{2, 6};
  study.trace.pupil.rays = 4096;
  expect_same(study, R"({"aberfit": 1, "mirror": {"focal_length": 2.8},
    "aperture": {"shape": "circle", "diameter": 0.4}, "light": {"wavelength": 632.8e-9},
    "roughness": {"psd": {"model": "table", "file": "psd.csv", "frequency_unit": "/m", "psd_unit": "m^4",
                          "f_max": 10}},
    "target": {"theory": "geometric", "statistics": {"ee50": {}}},
    "terms": {"zernike": {"n_max": 6}}, "trace": {"rays": 4096}})");
}

TEST_F(FilledStudy, IsTheOneOfAFileForOtherCommandsToo) {
  Study study = scene(2.5, RectangleAperture{0.3, 0.2}, 600e-9);
  study.psd = UniformPsd{100e-9, 4, 9};
  study.target.theory = Theory::kGeometric;
  study.terms.zernike = ZernikeSpec{2, 6};
  study.trace.pupil.rays = 4096;
  const Study read = parse_study(R"({"aberfit": 1, "mirror": {"focal_length": 2.5},
    "aperture": {"shape": "rectangle", "width": 0.3, "height": 0.2}, "light": {"wavelength": 600e-9},
    "roughness": {"psd": {"model": "uniform", "rms": 100e-9, "f_min": 4, "f_max": 9}},
    "target": {"theory": "geometric"}, "terms": {"zernike": {"n_max": 6}}, "trace": {"rays": 4096}})",
                                 "study.json");
  EXPECT_EQ(resolved_study(study).dump(), resolved_study(read).dump());
  EXPECT_EQ(to_json(run_trace(study, {}), resolved_study(study)).dump(),
            to_json(run_trace(read, {}), resolved_study(read)).dump());
  EXPECT_EQ(run_check(study, {}).rays, run_check(read, {}).rays);
}

// A study file must give these fields, but a program may leave them out.
TEST_F(FilledStudy, WithoutWhatHasNoDefaultIsRefusedByItsKey) {
  const auto refusal = [](const Study& study) -> std::string {
    try {
      run_fit(study, {});
    } catch (const InputError& error) {
      return error.pointer();
    }
    return "";
  };
  Study study;
  EXPECT_EQ(refusal(study), "/mirror/focal_length");
  study.mirror.focal_length = 1;
  EXPECT_EQ(refusal(study), "/aperture");
  study.aperture = CircleAperture{0.2};
  EXPECT_EQ(refusal(study), "/light/wavelength");
  study.wavelength = 500e-9;
  EXPECT_EQ(refusal(study), "/roughness");
  study.psd = UniformPsd{0, 1, 2};
  EXPECT_EQ(refusal(study), "/roughness/psd");
  study.psd = UniformPsd{1e-8, 10, 20};
  study.aperture = PolygonAperture{{{-0.1, -0.1}, {0.1, -0.1}, {0, 0.1}}};
  study.trace.pupil.layout = PupilLayout::kPolar;
  EXPECT_EQ(refusal(study), "/trace/pupil");
}

}  // namespace
}  // namespace aberfit
