#include "aberfit/study/read_study.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "aberfit/core/errors.h"
#include "aberfit/roughness/random_surface.h"
#include "scratch_folder.h"
#include "study_texts.h"

namespace aberfit {
namespace {

using test::changed;
using test::ScratchFolder;
using test::with_psd;

Study parse(const std::string& text) { return parse_study(text, "study.json"); }

template <typename Model>
Model model_of(const std::string& psd) {
  return std::get<Model>(parse(with_psd(psd)).roughness.value().model);
}

const StatisticRequest& find(const Study& study, const std::string& name, std::size_t skip = 0) {
  for (const StatisticRequest& request : study.target.statistics)
    if (request.name == name && skip-- == 0) return request;
  throw std::runtime_error("no statistic " + name);
}

// The study keeps the radius, whether it is given as radius or diameter, as length or angle.
TEST(ReadStudy, EncircledEnergiesMayBeDiametersAndAngles) {
  const double f = parse_study(changed("/title", "\"x\""), "study.json").mirror.focal_length;
  for (const auto& [key, value, radius] :
       {std::tuple("ee80", R"("0.6 arcsec")", f * 0.6 / 206264.80624709636),
        std::tuple("ee80_diameter", R"("8 um")", 4e-6),
        std::tuple("ee80_diameter", R"("0.6 arcsec")", f * 0.3 / 206264.80624709636),
        std::tuple("hew", R"("3 urad")", f * 1.5e-6), std::tuple("hew", "8e-6", 4e-6)}) {
    const std::string text = changed("/target/statistics", R"({")" + std::string(key) + R"(": {"value": )" +
                                                               value + R"(, "standard_error": "1 um"}})");
    const Study study = parse_study(text, "study.json");
    ASSERT_EQ(study.target.statistics.size(), 1u);
    const StatisticRequest& read = study.target.statistics[0];
    EXPECT_EQ(read.name, std::string(key) == "hew" ? "ee50" : "ee80");
    ASSERT_TRUE(read.value);
    EXPECT_NEAR(*read.value, radius, 1e-12 * radius) << key << value;
    EXPECT_DOUBLE_EQ(read.standard_error, std::string(key) == "ee80" ? 1e-6 : 0.5e-6);
    // The resolved study gives the radius, and reads as the same study.
    const Study again = parse_study(resolved_study(study).dump(), "study.json");
    EXPECT_EQ(again.target.statistics[0].name, read.name);
    EXPECT_DOUBLE_EQ(*again.target.statistics[0].value, *read.value);
  }
}

TEST(ReadStudy, FillsInTheDefaultsOfTheMinimalStudy) {
  const Study study = parse(test::kMinimalStudy);
  EXPECT_EQ(study.path, "study.json");
  EXPECT_EQ(study.mirror.focal_length, 2.8);
  EXPECT_EQ(study.mirror.conic, -1);
  EXPECT_EQ(study.mirror.spherical, (std::array<double, 5>{}));
  EXPECT_EQ(std::get<CircleAperture>(study.aperture).diameter, 0.4);
  EXPECT_EQ(std::get<CircleAperture>(study.aperture).margin, 0);
  EXPECT_EQ(double(study.wavelength), 632.8e-9);
  const auto& psd = std::get<UniformPsd>(study.roughness.value().model);
  EXPECT_EQ(psd.rms, 100e-9);
  EXPECT_EQ(psd.f_min, 2.5);
  EXPECT_EQ(psd.f_max, 39.92);
  EXPECT_EQ(study.target.theory, std::nullopt);
  EXPECT_EQ(study.target.convention, Convention::kPhysical);
  EXPECT_TRUE(study.target.statistics.empty());
  EXPECT_TRUE(study.terms.automatic());
  ASSERT_TRUE(study.terms.zernikes().has_value());  // their order is chosen when the study runs
  EXPECT_EQ(study.terms.zernikes()->n_min, 2);
  EXPECT_FALSE(study.terms.zernikes()->n_max.has_value());
  EXPECT_EQ(study.terms.covariance, CovarianceKind::kFull);
  EXPECT_EQ(layout_of(study.aperture, study.trace.pupil), PupilLayout::kPolar);
  EXPECT_FALSE(study.trace.pupil.rays.has_value());
  EXPECT_EQ(rays_of(study.trace.pupil), 65536);
  EXPECT_EQ(study.trace.pupil.seed, 1u);
  EXPECT_FALSE(study.trace.central_difference_step.has_value());
  EXPECT_EQ(study.trace.centre, Centre::kNominal);
  EXPECT_EQ(study.fit.start, FitStart::kDraw);
  EXPECT_EQ(study.fit.prior, PriorMode::kNearStart);
  EXPECT_EQ(study.fit.max_iterations, 100);
  EXPECT_EQ(study.equivalence.margin, 0.01);
  EXPECT_EQ(study.equivalence.confidence, 0.95);
  EXPECT_EQ(study.output.pictures, PictureFormat::kAuto);
  EXPECT_FALSE(study.verify_draws.has_value());
}

TEST(ReadStudy, ReadsEveryBlock) {
  const Study study = parse(test::kFullStudy);
  EXPECT_EQ(study.title, "every block");
  EXPECT_EQ(study.mirror.spherical, (std::array<double, 5>{1e-9, 0, 0, 0, 2.5}));
  EXPECT_EQ(study.mirror.zernike_radius, 0.21);
  ASSERT_EQ(study.mirror.zernike.size(), 2u);  // of the wavefront: the surface has half
  EXPECT_EQ(study.mirror.zernike[0].mode, (ZernikeMode{2, 0}));
  EXPECT_DOUBLE_EQ(study.mirror.zernike[0].height, 60e-9);
  EXPECT_EQ(study.mirror.zernike[1].mode, (ZernikeMode{3, -1}));
  EXPECT_DOUBLE_EQ(study.mirror.zernike[1].height, -15e-9);
  EXPECT_EQ(std::get<CircleAperture>(study.aperture).margin, 1e-3);
  EXPECT_EQ(study.target.theory, Theory::kRays);
  EXPECT_EQ(study.target.convention, Convention::kPaper);
  ASSERT_EQ(study.target.statistics.size(), 10u);
  EXPECT_EQ(study.target.statistics.front().name, "ee50");  // in the order of the file
  EXPECT_EQ(study.target.statistics.back().name, "rms_height");
  EXPECT_EQ(find(study, "ee50").planes, (std::vector<double>{0, -1e-3}));
  EXPECT_EQ(find(study, "ee50").tolerance, 1e-3);
  EXPECT_EQ(find(study, "ee97.5").tolerance, 2e-3);
  EXPECT_EQ(find(study, "ee97.5").planes, std::vector<double>{0});
  EXPECT_EQ(std::get<std::string>(find(study, "ring_fwhm").ring), "ee90");
  EXPECT_EQ(std::get<std::string>(find(study, "ring_fwhm", 1).ring), "ee50");
  EXPECT_EQ(find(study, "ring_fwhm", 1).tolerance, 3e-3);
  EXPECT_EQ(std::get<double>(find(study, "ring_profile").ring), 76e-6);
  EXPECT_EQ(find(study, "ring_profile").profile_dz, (std::vector<double>{-1e-3, 0, 1e-3}));
  EXPECT_EQ(find(study, "ring_profile").profile_value, (std::vector<double>{0.4, 0.9, 0.4}));
  EXPECT_EQ(find(study, "scatter_rms").value, 36e-6);
  EXPECT_EQ(find(study, "scatter_rms").standard_error, 0.1e-6);
  EXPECT_EQ(find(study, "spot_fwhm").bandwidth, 5e-6);
  EXPECT_EQ(find(study, "rms_radius").value, 60e-6);
  EXPECT_FALSE(find(study, "rms_height").value.has_value());
  EXPECT_EQ(study.terms.zernike->n_min, 1);
  EXPECT_EQ(study.terms.zernike->n_max, 20);
  EXPECT_EQ(study.terms.fourier->count, 400);
  EXPECT_EQ(study.terms.fourier->sampling, FourierSampling::kLog);
  EXPECT_EQ(study.terms.spherical, (std::vector<int>{4, 6}));
  EXPECT_EQ(study.terms.covariance, CovarianceKind::kDiagonal);
  EXPECT_EQ(study.trace.pupil.layout, PupilLayout::kSobol);
  EXPECT_EQ(study.trace.pupil.rays, 10000);
  EXPECT_EQ(study.trace.pupil.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(study.trace.central_difference_step, 1e-6);
  EXPECT_EQ(study.trace.centre, Centre::kCentroid);
  EXPECT_EQ(study.fit.start, FitStart::kZero);
  EXPECT_EQ(study.fit.seed, 7u);
  EXPECT_EQ(study.fit.prior, PriorMode::kZeroMean);
  EXPECT_EQ(study.fit.max_iterations, 50);
  EXPECT_EQ(study.fit.starts, 3);
  EXPECT_EQ(study.fit.spherical_rms, 2e-6);
  EXPECT_EQ(study.fit.bound_sigmas, 4);
  EXPECT_EQ(study.equivalence.confidence, 0.9);
  EXPECT_EQ(study.output.pictures, PictureFormat::kNone);
  EXPECT_EQ(study.verify_draws, 20);
}

// The line of a drawing is A/f^B. In the middle of a wide band, the profile PSD by the integral over the
// surface must be that line.
TEST(ReadStudy, ReadsTheLineOfADrawing) {
  for (const double exponent : {0.7, 1.5, 2.0, 3.3}) {
    const auto m = model_of<PowerLawPsd>(
        R"({"model": "power-law", "profile_psd": {"A": "0.02 nm^2 mm", "f_unit": "1/mm", "B": )" +
        std::to_string(exponent) + R"(}, "f_min": "1 /m", "f_max": "1e9 /m"})");
    EXPECT_FALSE(m.rms.has_value());
    EXPECT_DOUBLE_EQ(m.exponent, exponent + 1);
    const double f = 5000;  // 5 /mm; f_max takes at most (f/f_max)^B from it
    const double line = 0.02e-18 * 1e-3 * std::pow(5, -exponent);
    EXPECT_NEAR(profile_psd(RadialPsd(m), f), line, (2 * std::pow(f / 1e9, exponent) + 1e-8) * line)
        << exponent;
  }
  const auto refused = [](const std::string& keys) {
    try {
      parse(with_psd(R"({"model": "power-law", )" + keys + R"(, "f_min": "1 /m", "f_max": "9 /m"})"));
    } catch (const InputError& error) {
      return error.pointer();
    }
    return std::string();
  };
  const std::string line = R"("profile_psd": {"A": "1 nm^2 mm", "f_unit": "/mm", "B": 2})";
  EXPECT_EQ(refused(line), "");
  EXPECT_EQ(refused(line + R"(, "rms": "1 nm")"), "/roughness/psd/profile_psd");
  EXPECT_EQ(refused(line + R"(, "exponent": 3)"), "/roughness/psd/exponent");
  EXPECT_EQ(refused(R"("rms": "1 nm")"), "/roughness/psd/exponent");
  EXPECT_EQ(refused(R"("profile_psd": {"A": "1 nm^2 mm", "f_unit": "mm", "B": 2})"),
            "/roughness/psd/profile_psd/f_unit");
  EXPECT_EQ(refused(R"("profile_psd": {"A": "1 nm^2", "f_unit": "/mm", "B": 2})"),
            "/roughness/psd/profile_psd/A");
}

TEST(ReadStudy, ReadsEveryPsdModel) {
  const auto k = model_of<KCorrelationPsd>(
      R"({"model": "k-correlation", "rms": "20 nm", "B": "50 mm", "exponent": 3.5, "f_min": "1 /m", "f_max": "1 /mm"})");
  EXPECT_EQ(k.rms, 20e-9);
  EXPECT_EQ(k.correlation, 50e-3);
  EXPECT_EQ(k.exponent, 3.5);
  EXPECT_EQ(k.f_min, 1);
  EXPECT_EQ(k.f_max, 1e3);
  const auto open =
      model_of<KCorrelationPsd>(R"({"model": "k-correlation", "rms": "20 nm", "B": "50 mm", "exponent": 5})");
  EXPECT_EQ(open.f_min, 0);
  EXPECT_TRUE(std::isinf(open.f_max));

  const auto by_rms = model_of<PowerLawPsd>(
      R"({"model": "power-law", "rms": "20 nm", "exponent": 3, "f_min": "1 /m", "f_max": "10 cycles/mm"})");
  EXPECT_EQ(by_rms.rms, 20e-9);
  EXPECT_FALSE(by_rms.amplitude.has_value());
  EXPECT_EQ(by_rms.f_max, 1e4);
  const auto by_amplitude = model_of<PowerLawPsd>(
      R"({"model": "power-law", "amplitude": "3 nm^2 mm^2", "exponent": 5, "f_min": "1 /m"})");
  EXPECT_FALSE(by_amplitude.rms.has_value());
  EXPECT_EQ(by_amplitude.amplitude, 3e-24);
  EXPECT_TRUE(std::isinf(by_amplitude.f_max));

  const auto gaussian =
      model_of<GaussianPsd>(R"({"model": "gaussian", "rms": "5 nm", "correlation_length": "2 cm"})");
  EXPECT_EQ(gaussian.rms, 5e-9);
  EXPECT_EQ(gaussian.correlation_length, 0.02);
}

// With exponent 3 the PSD of the autocorrelation exp(-r/l) has a closed form: 2 pi l^2 sigma^2 (1 + (2 pi l
// f)^2)^(-3/2).
TEST(ReadStudy, CorrelationLengthOfAKCorrelationIsThatOfItsAutocorrelation) {
  const double length = 8e-3, rms = 20e-9;
  const auto k = model_of<KCorrelationPsd>(
      R"({"model": "k-correlation", "rms": "20 nm", "correlation_length": "8 mm", "exponent": 3, "f_max": "1 /mm"})");
  const RadialPsd psd(k);
  const double turn = 2 * std::numbers::pi * length,
               inside = 1 - 1 / std::hypot(1, turn * 1e3);  // of sigma^2
  for (const double f : {0.0, 1.0, 20.0, 300.0}) {
    const double closed =
        2 * std::numbers::pi * std::pow(length * rms, 2) * std::pow(1 + std::pow(turn * f, 2), -1.5) / inside;
    EXPECT_NEAR(psd(f) / closed, 1, 1e-12) << f;
  }
  // Both names give the same PSD to the bit, with and without a band, and the resolved study has B.
  for (const std::string rest :
       {R"("exponent": 5})", R"("exponent": 2.2, "f_min": "1 /m", "f_max": "1 /mm"})"}) {
    const std::string head = R"({"model": "k-correlation", "rms": "20 nm", )";
    const Study by_length = parse(with_psd(head + R"("correlation_length": 0.008, )" + rest));
    const double b = 2 * std::numbers::pi * 0.008;
    const Study by_b = parse(with_psd(head + fmt::format(R"("B": {}, )", b) + rest));
    const RadialPsd one(psd_model(*by_length.roughness)), other(psd_model(*by_b.roughness));
    for (const double f : {1.5, 20.0, 900.0}) EXPECT_EQ(one(f), other(f)) << rest;
    EXPECT_EQ(resolved_study(by_length)["roughness"].dump(), resolved_study(by_b)["roughness"].dump());
  }
}

TEST(ReadStudy, ReadsSumsOfSums) {
  const Study study = parse(with_psd(R"({"model": "sum", "parts": [
      {"model": "gaussian", "rms": "3 nm", "correlation_length": "2 cm"},
      {"model": "sum", "parts": [{"model": "uniform", "rms": "4 nm", "f_min": 1, "f_max": 100}]}]})"));
  const PsdModel model = psd_model(study.roughness.value());
  const auto& sum = std::get<SumPsd>(model);
  ASSERT_EQ(sum.parts.size(), 2u);
  EXPECT_EQ(std::get<GaussianPsd>(sum.parts[0]).rms, 3e-9);
  EXPECT_EQ(std::get<UniformPsd>(std::get<SumPsd>(sum.parts[1]).parts.at(0)).f_max, 100);
  // Independent parts: variances add, 3-4-5. The moments are good to 1e-12.
  EXPECT_NEAR(psd_moments(RadialPsd(model)).rms_height() / 5e-9, 1, 1e-12);
}

TEST(ReadStudy, LoadsTablesRelativeToTheStudyInTheirUnits) {
  const ScratchFolder folder;
  folder.write("psd.csv", "f [1/mm], PSD [nm^2 mm^2]\n0.01, 100\n0.1, 10\n1, 0.01\n");
  const auto read = [&](const std::string& keys) {
    const std::string path =
        folder.write("study.json", with_psd(R"({"model": "table", "file": "psd.csv")" + keys + "}"));
    return read_study(path);
  };
  const std::string units = R"(, "frequency_unit": "1/mm", "psd_unit": "nm^2 mm^2")";
  const double kRounding = 1e-15;

  const Study study = read(units);
  const auto& file = std::get<PsdTableFile>(study.roughness.value().model);
  EXPECT_EQ(file.file, "psd.csv");
  ASSERT_EQ(file.table.psd.frequency.size(), 3u);
  EXPECT_NEAR(file.table.psd.frequency[1] / 100, 1, kRounding);
  EXPECT_NEAR(file.table.psd.psd[1] / 10e-24, 1, kRounding);
  const auto table = std::get<TablePsd>(psd_model(study.roughness.value()));
  EXPECT_EQ(table.psd, file.table.psd.psd);

  // A wavefront is twice the surface height, and a scale of 3 multiplies the PSD by nine.
  const Study wavefront = read(units + R"(, "of": "wavefront", "scale": 3)");
  EXPECT_NEAR(std::get<PsdTableFile>(wavefront.roughness->model).table.psd.psd[1] / 22.5e-24, 1, kRounding);

  const Study cut = read(units + R"(, "f_min": "0.02 /mm", "f_max": "0.5 /mm")");
  const TablePsd& kept = std::get<PsdTableFile>(cut.roughness->model).table.psd;
  EXPECT_NEAR(kept.frequency.front() / 20, 1, kRounding);
  EXPECT_NEAR(kept.frequency.back() / 500, 1, kRounding);
  EXPECT_GT(std::get<PsdTableFile>(cut.roughness->model).table.variance_left_out, 0);
}

TEST(ReadStudy, ReadsProfileTablesInProfileUnits) {
  const ScratchFolder folder;
  folder.write("profile.csv", "f_per_m psd_m3\n1 1e-15\n10 1e-17\n100 1e-19\n1000 1e-21\n");
  const std::string path =
      folder.write("study.json", with_psd(R"({"model": "table", "file": "profile.csv", "kind": "1d"})"));
  const auto file = std::get<PsdTableFile>(read_study(path).roughness.value().model);
  EXPECT_EQ(file.psd_unit, "");  // as in the header
  // S2 = (A/4) f^-3 integrated over y with f^2 + y^2 is (A/2) f^-2: half of the one-sided S1 = A f^-2 of this
  // table. The table goes on as the same power law, so the conversion has no truncation error.
  EXPECT_NEAR(file.table.psd.psd[1] / (1e-15 / 4 * 1e-3), 1, 1e-9);
}

TEST(ReadStudy, LoadsRingProfilesFromFiles) {
  const ScratchFolder folder;
  folder.write("profile.csv", "# measured\r\ndz,share\r\n-1e-3, 0.4\r\n0;0.9\r\n\r\n1e-3\t0.4 # last\r\n");
  const std::string path = folder.write(
      "study.json", changed("/target/statistics/ring_profile", R"({"file": "profile.csv", "ring": "ee50"})"));
  const Study study = read_study(path);
  const StatisticRequest& profile = find(study, "ring_profile");
  EXPECT_EQ(profile.profile_dz, (std::vector<double>{-1e-3, 0, 1e-3}));
  EXPECT_EQ(profile.profile_value, (std::vector<double>{0.4, 0.9, 0.4}));
  for (const char* header : {"dz_mm,share\n", "dz (mm);share\n", "\"dz [mm]\",\"share\"\n"}) {
    folder.write("profile.csv", header + std::string("-1 0.4\n0 0.9\n1 0.4\n"));
    EXPECT_EQ(find(read_study(path), "ring_profile").profile_dz, (std::vector<double>{-1e-3, 0, 1e-3}))
        << header;
  }
  folder.write("profile.csv", "-0,1;0,4\n0;0,9\n");
  EXPECT_THROW(read_study(path), InputError);
}

TEST(ReadStudy, ReadsEveryAperture) {
  const auto aperture = [](const std::string& text) { return parse(changed("/aperture", text)).aperture; };
  const auto annulus = std::get<AnnulusAperture>(
      aperture(R"({"shape": "annulus", "diameter": 0.4, "inner_diameter": "10 cm"})"));
  EXPECT_EQ(annulus.inner_diameter, 0.1);
  const auto rectangle = std::get<RectangleAperture>(
      aperture(R"({"shape": "rectangle", "width": "0.3 m", "height": 0.2, "margin": "1 mm"})"));
  EXPECT_EQ(rectangle.width, 0.3);
  EXPECT_EQ(rectangle.height, 0.2);
  EXPECT_EQ(rectangle.margin, 1e-3);
  const auto polygon = std::get<PolygonAperture>(aperture(
      R"({"shape": "polygon", "vertices": [["-10 cm", 0], [0.1, 0], [0, "0.15 m"], [-0.05, 0.05]]})"));
  ASSERT_EQ(polygon.vertices.size(), 4u);
  EXPECT_EQ(polygon.vertices[0], (std::array<double, 2>{-0.1, 0}));
  EXPECT_EQ(polygon.vertices[2], (std::array<double, 2>{0, 0.15}));
}

TEST(ReadStudy, GivesKnownZernikesTheRadiusOfTheApertureAndTheHeightsOfTheSurface) {
  const std::string noll = R"("noll": {"11": "5 nm", "5": 2e-8})";
  const Study plain = parse(changed("/mirror/zernike", "{" + noll + "}"));
  EXPECT_EQ(plain.mirror.zernike_radius, 0.2);
  ASSERT_EQ(plain.mirror.zernike.size(), 2u);
  EXPECT_EQ(plain.mirror.zernike[0].mode, (ZernikeMode{2, -2}));
  EXPECT_EQ(plain.mirror.zernike[0].height, 2e-8);
  EXPECT_EQ(plain.mirror.zernike[1].mode, (ZernikeMode{4, 0}));
  EXPECT_DOUBLE_EQ(plain.mirror.zernike[1].height, 5e-9);
  const std::string rectangle = changed("/mirror/zernike", "{" + noll + "}");
  const Study corners = parse(changed(
      "/aperture", R"({"shape": "rectangle", "width": "0.3 m", "height": "0.4 m"})", rectangle.c_str()));
  EXPECT_DOUBLE_EQ(corners.mirror.zernike_radius, 0.25);  // to the corners
  const nlohmann::ordered_json resolved = resolved_study(plain);
  EXPECT_EQ(resolved["mirror"]["zernike"].dump(),
            R"({"radius":0.2,"of":"surface","noll":{"5":2e-08,"11":5e-09}})");
}

TEST(ReadStudy, TakesSobolRaysWherePolarOnesDoNotExist) {
  const std::string rectangle = R"({"shape": "rectangle", "width": 0.3, "height": 0.2})";
  const Study wide = parse(changed("/aperture", rectangle));
  EXPECT_EQ(layout_of(wide.aperture, wide.trace.pupil), PupilLayout::kSobol);
  EXPECT_EQ(resolved_study(wide)["trace"]["pupil"], "sobol");
  const std::string annulus = R"({"shape": "annulus", "diameter": 0.4, "inner_diameter": 0.1})";
  const Study ring = parse(changed("/aperture", annulus));
  EXPECT_EQ(layout_of(ring.aperture, ring.trace.pupil), PupilLayout::kPolar);
}

TEST(ReadStudy, NeedsNoRoughnessWhereEveryTargetIsAValue) {
  const Study study = parse(R"({
      "aberfit": 1, "mirror": {"focal_length": 2.8}, "aperture": {"shape": "circle", "diameter": 0.4},
      "light": {"wavelength": 6.328e-7}, "target": {"statistics": {"ee90": {"value": "76 um"}}},
      "terms": {"spherical": ["c12"]}, "fit": {"prior": "zero-mean"}})");
  EXPECT_FALSE(study.roughness.has_value());
  EXPECT_FALSE(study.terms.zernike.has_value());
  EXPECT_EQ(study.terms.spherical, std::vector<int>{12});
}

TEST(ReadStudy, TellsRingWidthsApartByTheirRings) {
  const Study study =
      parse(changed("/target/statistics",
                    R"({"ring_fwhm@ee90": {}, "ring_fwhm": {"ring": "80 um"}, "ring_fwhm@ee50": {}})"));
  EXPECT_EQ(std::get<std::string>(study.target.statistics[0].ring), "ee90");
  EXPECT_EQ(std::get<double>(study.target.statistics[1].ring), 80e-6);
  EXPECT_EQ(std::get<std::string>(study.target.statistics[2].ring), "ee50");
  for (const StatisticRequest& request : study.target.statistics) EXPECT_EQ(request.name, "ring_fwhm");
}

// The resolved study must be a valid study of the same meaning: written, read and written again it stays the
// same to the last digit.
TEST(ResolvedStudy, ReadsBackAsItself) {
  const ScratchFolder folder;
  folder.write_data();
  folder.write("profile.csv", "-1e-3 0.4\n0 0.9\n1e-3 0.4\n");
  const std::vector<std::string> texts = {
      test::kMinimalStudy,
      test::kFullStudy,
      with_psd(R"({"model": "k-correlation", "rms": "20 nm", "B": "0.1 in", "exponent": 4.7})"),
      with_psd(R"({"model": "power-law", "amplitude": "3 nm^2 mm^2", "exponent": 5, "f_min": "1 /m"})"),
      with_psd(R"({"model": "gaussian", "rms": "5 nm", "correlation_length": "2 cm"})"),
      with_psd(
          R"({"model": "table", "file": "psd.csv", "psd_unit": "m^4", "of": "wavefront", "scale": 0.3, "f_min": 2})"),
      with_psd(
          R"({"model": "sum", "parts": [{"model": "gaussian", "rms": "3 nm", "correlation_length": "2 cm"},
                  {"model": "table", "file": "psd.csv", "kind": "1d", "psd_unit": "m^3"}]})"),
      changed("/aperture",
              R"({"shape": "annulus", "diameter": 0.4, "inner_diameter": "1 in", "margin": "1 mm"})"),
      changed("/aperture", R"({"shape": "rectangle", "width": 0.3, "height": "0.2 m"})"),
      changed("/aperture", R"({"shape": "polygon", "vertices": [[0, 0], ["0.1 m", 0], [0, "3 in"]]})"),
      changed(
          "/target/statistics",
          R"({"ring_fwhm@ee90": {}, "ring_fwhm": {"ring": "80 um"}, "ring_fwhm@ee50": {"value": "3 mm"}})"),
      changed("/target/statistics/ring_profile", R"({"file": "profile.csv"})"),
      changed("/terms", R"({"spherical": ["c8", "c4"]})"),
      changed("/target/statistics/scatter_mean", R"({"value": "3.24 arcsec"})"),
  };
  for (const std::string& text : texts) {
    SCOPED_TRACE(text);
    const std::string path = folder.write("study.json", text);
    const Study study = read_study(path);
    const nlohmann::ordered_json resolved = resolved_study(study);
    const Study again = parse_study(resolved.dump(2), path);
    EXPECT_EQ(resolved_study(again).dump(2), resolved.dump(2));
    // Data that were loaded from files are not part of the resolved text.
    for (std::size_t i = 0; i < study.target.statistics.size(); ++i) {
      EXPECT_EQ(again.target.statistics[i].profile_dz, study.target.statistics[i].profile_dz);
      EXPECT_EQ(again.target.statistics[i].name, study.target.statistics[i].name);
      EXPECT_EQ(again.target.statistics[i].ring, study.target.statistics[i].ring);
    }
  }
}

TEST(ResolvedStudy, HoldsEveryDefaultInSiUnits) {
  const nlohmann::ordered_json resolved = resolved_study(parse(test::kMinimalStudy));
  const nlohmann::ordered_json expected = nlohmann::ordered_json::parse(R"({
    "aberfit": 1,
    "mirror": {"focal_length": 2.8, "conic": -1.0, "spherical": {"c4": 0.0, "c6": 0.0, "c8": 0.0, "c10": 0.0, "c12": 0.0}},
    "aperture": {"shape": "circle", "diameter": 0.4, "margin": 0.0, "spiders": []},
    "light": {"wavelength": 6.328e-7},
    "roughness": {"psd": {"model": "uniform", "rms": 1e-7, "f_min": 2.5, "f_max": 39.92}},
    "target": {"theory": "auto", "convention": "physical", "statistics": {}},
    "terms": "auto",
    "trace": {"model": "auto", "pupil": "polar", "rays": "auto", "seed": 1, "normals": "analytic", "centre": "nominal"},
    "fit": {"start": "draw", "seed": 1, "prior": "near-start", "max_iterations": 100, "starts": 1,
            "bound_sigmas": 0.0},
    "equivalence": {"margin": 0.01, "confidence": 0.95},
    "output": {"pictures": "auto", "export": [], "export_grid": 257, "arrays": "none"},
    "verify": {}
  })");
  EXPECT_EQ(resolved.dump(1), expected.dump(1));
}

const char* const kVanes =
    R"("spiders": [{"width": "10 mm", "angle": "45 deg"}, {"width": "10 mm", "angle": "3 rad"}])";

Study with_aperture(const std::string& aperture) { return parse(changed("/aperture", aperture)); }
std::string refusal_of(const std::string& aperture) {
  try {
    with_aperture(aperture);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing refused";
}

// The resolved study keeps shape and spiders apart, and reading it gives the same clear area.
TEST(ReadStudy, SegmentsAndSpidersAreWhatIsClear) {
  const std::string hexagons =
      R"({"shape": "segments", "hexagons": {"rings": 1, "flat_to_flat": "0.1 m", "gap": "2 mm"})";
  const Study segments = with_aperture(hexagons + "}");
  EXPECT_NEAR(aperture_area(segments.aperture), 6 * 0.5 * std::sqrt(3.0) * 0.01, 1e-15);
  const Study covered = with_aperture(hexagons + ", " + kVanes + "}");
  EXPECT_LT(aperture_area(covered.aperture), aperture_area(segments.aperture));
  const Study ring = with_aperture(
      R"({"shape": "annulus", "diameter": "0.4 m", "inner_diameter": "0.1 m", )" + std::string(kVanes) + "}");
  EXPECT_NEAR(aperture_area(ring.aperture) / (0.25 * std::numbers::pi * 0.15 - 2 * 0.01 * 0.15), 1, 1e-3);
  for (const Study& study : {segments, covered, ring}) {
    const nlohmann::ordered_json resolved = resolved_study(study);
    const Study again = parse_study(resolved.dump(), "study.json");
    EXPECT_TRUE(again.aperture == study.aperture);
    EXPECT_EQ(resolved_study(again), resolved);
  }
  const Study erring = with_aperture(hexagons + R"(, "piston": "30 nm", "tip_tilt": "0.1 arcsec"})");
  const auto& errors = std::get<SegmentedAperture>(erring.aperture);
  EXPECT_DOUBLE_EQ(errors.piston, 30e-9);
  EXPECT_NEAR(errors.tip_tilt, 4.848e-7, 1e-10);
  EXPECT_TRUE(parse_study(resolved_study(erring).dump(), "study.json").aperture == erring.aperture);
  const std::string triangle = R"({"vertices": [["0 m", "0 m"], ["0.1 m", "0 m"], ["0 m", "0.1 m"]]})",
                    inside = R"({"vertices": [["10 mm", "10 mm"], ["10 mm", "20 mm"], ["20 mm", "10 mm"]]})",
                    beside = R"({"vertices": [["0.1 m", "0.1 m"], ["0.1 m", "0 m"], ["0 m", "0.1 m"]]})";
  const auto polygons = [](const std::string& list) {
    return R"({"shape": "segments", "polygons": [)" + list + "]}";
  };
  EXPECT_NEAR(aperture_area(with_aperture(polygons(triangle + ", " + beside)).aperture), 0.01, 1e-15);
  EXPECT_NE(refusal_of(polygons(triangle + ", " + inside)).find("segments side by side"), std::string::npos);
  EXPECT_NE(refusal_of(R"({"shape": "segments"})").find("neither hexagons nor polygons"), std::string::npos);
  EXPECT_NE(refusal_of(R"({"shape": "circle", "diameter": "0.4 m", "spiders": [)"
                       R"({"width": "1 m", "angle": 0}, {"width": "1 m", "angle": "180 deg"}]})")
                .find("vanes that leave a part of it clear"),
            std::string::npos);
}

TEST(ReadStudy, AMaskIsItsOutline) {
  const ScratchFolder folder;
  std::string rows;
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 40; ++column)
      rows += std::hypot(row - 19.5, column - 19.5) < 18 && std::hypot(row - 19.5, column - 19.5) > 5 ? "1 "
                                                                                                      : "0 ";
    rows += "\n";
  }
  folder.write("pupil.txt", rows);
  const auto read = [&](const std::string& more) {
    return read_study(
        folder.write("study.json", changed("/aperture", R"({"shape": "mask", "file": "pupil.txt", )"
                                                        R"("pitch": "10 mm")" +
                                                            more + "}")));
  };
  const Study mask = read("");
  EXPECT_NEAR(aperture_area(mask.aperture) / (std::numbers::pi * (0.18 * 0.18 - 0.05 * 0.05)), 1, 0.02);
  EXPECT_LT(aperture_area(read(std::string(", ") + kVanes).aperture), 0.99 * aperture_area(mask.aperture));
  EXPECT_TRUE(completed(mask).aperture == mask.aperture);
  Study made = mask;  // a program names shape and vanes, and leaves the aperture alone
  made.aperture = Aperture{};
  made.obstructed = ApertureSpec{AnnulusAperture{0.36, 0.1}, {{0.01, 0.5}}};
  EXPECT_TRUE(completed(made).aperture == Aperture(obstructed(AnnulusAperture{0.36, 0.1}, {{0.01, 0.5}})));
  folder.write("pupil.txt", "0.2 0.3\n0.1 0.2\n");
  EXPECT_THROW(read(""), InputError);
}

// The resolved study gives a band by its lines, which read as the same.
TEST(ReadStudy, LightMayBeABand) {
  const auto with_light = [](const std::string& light) { return parse(changed("/light", light)); };
  const Study filter = with_light(R"({"band": {"from": "500 nm", "to": "600 nm", "count": 4}})");
  ASSERT_EQ(filter.wavelength.lines().size(), 4u);
  EXPECT_NEAR(filter.wavelength.shortest(), 512.5e-9, 1e-20);
  const Study lines =
      with_light(R"({"band": {"lines": [{"wavelength": "500 nm"}, {"wavelength": "600 nm", "share": 3}]}})");
  EXPECT_NEAR(lines.wavelength, 575e-9, 1e-20);
  for (const Study& study : {filter, lines})
    EXPECT_TRUE(parse_study(resolved_study(study).dump(), "study.json").wavelength == study.wavelength);
  for (const auto& [light, fragment] :
       {std::pair{R"({"band": {"from": "500 nm"}})", "from and to, or lines"},
        {R"({"band": {"from": "600 nm", "to": "500 nm"}})", "a wavelength above from"},
        {R"({"wavelength": "500 nm", "band": {"from": "500 nm", "to": "600 nm"}})",
         "a wavelength, or a band"},
        {"{}", "missing; light needs \"wavelength\": \"632.8 nm\", or a \"band\""}}) {
    try {
      with_light(light);
      ADD_FAILURE() << light;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(fragment), std::string::npos) << error.what();
    }
  }
  nlohmann::json with_ring =
      nlohmann::json::parse(changed("/light", R"({"band": {"from": "500 nm", "to": "600 nm"}})"));
  with_ring["target"]["statistics"] = {{"ring_fwhm", nlohmann::json::object()}};
  EXPECT_THROW(parse(with_ring.dump()), InputError);
}

}  // namespace
}  // namespace aberfit
