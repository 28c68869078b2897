#include "aberfit/report/exports.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>

#include "aberfit/core/random.h"
#include "aberfit/focus/evaluate.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/scene/pupil.h"
#include "aberfit/scene/zernike.h"
#include "aberfit/terms/modal_covariance.h"
#include "aberfit/terms/surface_operator.h"
#include "aberfit/trace/ray_bundle.h"
#include "bicubic_reader.h"

namespace aberfit {
namespace {

using test::evaluate;
using test::Interpolation;
using test::parse_sag_file;
using test::SagFile;
using test::SagPoint;

constexpr double kWavelength = 632.8e-9;

// A term surface over an aperture.
struct Part {
  TermSet terms;
  Eigen::VectorXd coefficients;
  Aperture aperture;

  Part(Aperture where, std::vector<ZernikeMode> modes) : aperture(std::move(where)) {
    terms.radius = aperture_radius(aperture);
    terms.zernike = std::move(modes);
    coefficients = Eigen::VectorXd::Zero(terms.size());
  }
  ExportInput input(int grid_size = 257) const {
    return {terms, coefficients, aperture, kWavelength, grid_size, "part"};
  }
  std::string text(ExportFormat format, int grid_size = 257) const {
    return export_file(format, input(grid_size)).second;
  }
  // Height mode by mode, without the fast kernels.
  double height(double x, double y) const {
    double h = 0;
    for (std::size_t i = 0; i < terms.zernike.size(); ++i)
      h +=
          coefficients[Eigen::Index(i)] * zernike(terms.zernike[i], x / terms.radius, y / terms.radius).value;
    for (std::size_t k = 0; k < terms.fourier.size(); ++k) {
      const double phase = 2 * std::numbers::pi * (terms.fourier[k].fx * x + terms.fourier[k].fy * y);
      const Eigen::Index at = terms.fourier_begin() + 2 * Eigen::Index(k);
      h += coefficients[at] * std::cos(phase) + coefficients[at + 1] * std::sin(phase);
    }
    return h;
  }
};

// A part without any symmetry: tilt towards +x+y, coma along x with a sine trefoil, a plane wave.
Part asymmetric(Aperture aperture, double offset = 0) {
  Part part(std::move(aperture), {{0, 0}, {1, -1}, {1, 1}, {3, 1}, {3, -3}});
  part.terms.fourier = {{11, -7}};
  part.coefficients.resize(part.terms.size());
  part.coefficients << offset, 60e-9, 90e-9, 50e-9, 20e-9, 8e-9, -5e-9;
  return part;
}

const std::map<std::string, Aperture>& apertures() {
  static const std::map<std::string, Aperture> all = {
      {"circle", CircleAperture{0.4, 0.01}},  // the margin is for rays, not for surfaces
      {"annulus", AnnulusAperture{0.4, 0.12, 0}},
      {"rectangle", RectangleAperture{0.3, 0.14, 0}},
      {"polygon", PolygonAperture{{{{0.02, -0.1}}, {{0.2, 0.0}}, {{0.1, 0.12}}, {{0.05, 0.02}}}, 0}}};
  return all;
}

// Clearly inside or outside, by 1 nm from every edge; on the rim itself rounding decides.
bool surely_inside(const Aperture& aperture, double x, double y) {
  return aperture_contains(aperture, x, y, 1e-9);
}
bool surely_outside(const Aperture& aperture, double x, double y) {
  for (const double dx : {-1e-9, 0.0, 1e-9})
    for (const double dy : {-1e-9, 0.0, 1e-9})
      if (aperture_contains(aperture, x + dx, y + dy, 0)) return false;
  return true;
}

// Middle and side of the square that each export covers.
std::array<double, 3> square_of(const std::string& name) {
  if (name == "rectangle") return {0, 0, 0.3};
  if (name == "polygon") return {0.11, 0.01, 0.22};
  return {0, 0, 0.4};
}

// A surface as a fit gives it: a realisation with n <= 20 from the PSD of the paper's stand-in scene.
Part fit_like_draw() {
  Part part(CircleAperture{0.4, 0}, zernike_modes(2, 20));
  const CoefficientPrior prior =
      make_prior(part.terms, RadialPsd(UniformPsd{100e-9, 2.5, 19.96}), CovarianceKind::kFull);
  part.coefficients = prior.colour(draw_white(prior.size(), 1));
  return part;
}

// Plane waves up to 39.9 /m, the band that the paper's convention needs.
Part waves() {
  Part part(CircleAperture{0.4, 0}, {});
  const RadialPsd psd(UniformPsd{100e-9, 2.5, 39.92});
  part.terms.fourier = fourier_modes(psd, 200, 1);
  const CoefficientPrior prior = make_prior(part.terms, psd, CovarianceKind::kFull);
  part.coefficients = prior.colour(draw_white(prior.size(), 2));
  return part;
}

Part low_orders() {
  Part part(CircleAperture{0.4, 0}, zernike_modes(2, 4));
  const RandomStream random(11, "low-orders");
  for (Eigen::Index i = 0; i < part.coefficients.size(); ++i)
    part.coefficients[i] = 80e-9 * random.normal(std::uint64_t(i));
  return part;
}

// The surface at points, by the operator or from a file.
SurfaceField field_of(const Part& part, const PupilSample& pupil) {
  SurfaceField field;
  SurfaceOperator(part.terms, pupil.x, pupil.y).apply(part.coefficients, &field);
  return field;
}

SurfaceField field_of(const SagFile& file, const PupilSample& pupil, Interpolation how) {
  SurfaceField field;
  field.resize(pupil.size());
  for (Eigen::Index i = 0; i < pupil.size(); ++i) {
    const SagPoint point = evaluate(file, pupil.x[i], pupil.y[i], how);
    EXPECT_TRUE(point.valid) << pupil.x[i] << " " << pupil.y[i];
    field.height[i] = point.z, field.slope_x[i] = point.zx, field.slope_y[i] = point.zy;
  }
  return field;
}

double ee90(const PupilSample& pupil, const SurfaceField& field) {
  Mirror mirror;
  mirror.focal_length = 2.8;
  const RayBundle rays = trace(mirror, pupil, field), nominal = trace_nominal(mirror, pupil);
  return evaluate_exact({rays, nominal, field.height}, {EncircledEnergyRadius{0.9, 0}}, 1)[0];
}

double rms(const PupilSample& pupil, const Eigen::ArrayXd& values) {
  return std::sqrt((pupil.weight * values.square()).sum() / pupil.weight.sum());
}

double slope_error(const PupilSample& pupil, const SurfaceField& a, const SurfaceField& b) {
  return std::hypot(rms(pupil, a.slope_x - b.slope_x), rms(pupil, a.slope_y - b.slope_y)) /
         std::hypot(rms(pupil, b.slope_x), rms(pupil, b.slope_y));
}

}  // namespace

TEST(SampleSurface, CoversTheSquareAroundTheAperture) {
  for (const auto& [name, aperture] : apertures()) {
    SCOPED_TRACE(name);
    const Part part = asymmetric(aperture);
    const HeightMap map = sample_surface(part.input(65)).map;
    const auto [x, y, side] = square_of(name);
    EXPECT_EQ(map.rows(), 65);
    EXPECT_EQ(map.columns(), 65);
    EXPECT_NEAR(map.x(0), x - side / 2, 1e-15);
    EXPECT_NEAR(map.x(64), x + side / 2, 1e-15);
    EXPECT_NEAR(map.y(0), y - side / 2, 1e-15);
    EXPECT_NEAR(map.y(64), y + side / 2, 1e-15);
  }
}

TEST(SampleSurface, HoldsHeightSlopesAndCrossDerivativeOfTheSurface) {
  // Central differences of the plain implementation with steps of 1e-4 (1e-3) of the radius. The error is
  // u^2/6 of a slope (u^2/3 of the cross derivative), u = 2 pi 13 /m times the step, with smaller rounding.
  constexpr double kStep = 2e-5, kCrossStep = 2e-4;
  for (const auto& [name, aperture] : apertures()) {
    SCOPED_TRACE(name);
    const Part part = asymmetric(aperture);
    const GridSag sag = sample_surface(part.input(33));
    const auto h = [&](double x, double y) { return part.height(x, y); };
    for (Eigen::Index r = 0; r < 33; ++r)
      for (Eigen::Index c = 0; c < 33; ++c) {
        if (!std::isfinite(sag.map.height(r, c))) continue;
        const double x = sag.map.x(c), y = sag.map.y(r), d = kStep, e = kCrossStep;
        EXPECT_NEAR(sag.map.height(r, c), h(x, y), 1e-20);
        EXPECT_NEAR(sag.dx(r, c), (h(x + d, y) - h(x - d, y)) / (2 * d), 1e-11);
        EXPECT_NEAR(sag.dy(r, c), (h(x, y + d) - h(x, y - d)) / (2 * d), 1e-11);
        EXPECT_NEAR(sag.dxdy(r, c),
                    (h(x + e, y + e) - h(x - e, y + e) - h(x + e, y - e) + h(x - e, y - e)) / (4 * e * e),
                    1e-8);
      }
  }
}

TEST(SampleSurface, EveryCellOfTheApertureHasFourCornersAndLittleElseHasAny) {
  for (const auto& [name, aperture] : apertures())
    for (const int size : {33, 64, 257}) {
      SCOPED_TRACE(name + " " + std::to_string(size));
      const Part part = asymmetric(aperture);
      const HeightMap map = sample_surface(part.input(size)).map;
      const RandomStream random(17, "cells-of-the-aperture");
      int inside = 0;
      for (std::uint64_t i = 0; i < 20000; ++i) {
        const auto [u, v] = random.uniform_pair(i);
        const double x = map.x0 + u * map.pitch_x * (size - 1), y = map.y0 + v * map.pitch_y * (size - 1);
        const Eigen::Index c = Eigen::Index(u * (size - 1)), r = Eigen::Index(v * (size - 1));
        if (!aperture_contains(aperture, x, y, 0)) continue;
        ++inside;
        EXPECT_TRUE(map.height.block(r, c, 2, 2).isFinite().all()) << x << " " << y;
      }
      EXPECT_GT(inside, 2000);
      for (Eigen::Index r = 0; r < size; ++r)
        for (Eigen::Index c = 0; c < size; ++c) {
          bool near = false;
          for (int i = -2; i <= 2; ++i)
            for (int j = -2; j <= 2; ++j)
              near = near || aperture_contains(aperture, map.x(c + i), map.y(r + j), 0);
          EXPECT_EQ(std::isfinite(map.height(r, c)), near);
        }
    }
}

TEST(SampleSurface, LeavesOutWhatBlowsUpBeyondTheRim) {
  // Two grid steps beyond the rim of a coarse grid, rho^300 is 1.2^300 = 1e24 times its value at the rim.
  Part part(CircleAperture{0.4, 0}, {{300, 300}});
  part.coefficients << 1e-9;
  const GridSag sag = sample_surface(part.input(17));
  double largest = 0;
  for (const double h : sag.map.height.reshaped())
    if (std::isfinite(h)) largest = std::max(largest, std::abs(h));
  EXPECT_LE(largest, 1e3 * std::sqrt(602.0) * 1e-9);
  const std::string text = part.text(ExportFormat::kZemaxGridSag, 17);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
}

TEST(ExportedGridSag, StandsUprightWithHolesAndOffset) {
  for (const auto& [name, aperture] : apertures())
    for (const double offset : {-1e-6, 0.0, 1e-6}) {
      SCOPED_TRACE(name + " " + std::to_string(offset));
      const Part part = asymmetric(aperture, offset);
      const SagFile file = parse_sag_file(part.text(ExportFormat::kZemaxGridSag, 65));
      const auto [x, y, side] = square_of(name);
      EXPECT_EQ(file.nx, 65);
      EXPECT_EQ(file.ny, 65);
      EXPECT_NEAR(file.step_x, side / 64, 1e-15);
      EXPECT_NEAR(file.x_middle, x, 1e-15);
      EXPECT_NEAR(file.y_middle, y, 1e-15);
      int valid = 0;
      for (int r = 0; r < 65; ++r)
        for (int c = 0; c < 65; ++c) {
          const SagFile::Node& node = file.node(r, c);
          if (!node.valid) {
            EXPECT_EQ(node.z, 0);
            EXPECT_FALSE(aperture_contains(aperture, file.x(c), file.y(r), 0));
            continue;
          }
          ++valid;
          EXPECT_NEAR(node.z, part.height(file.x(c), file.y(r)), 1e-17);  // 12 digits of 2 um
        }
      EXPECT_GT(valid, 400);
      EXPECT_LT(valid, 65 * 65);
    }
}

TEST(ExportedGridSag, BicubicReaderFindsTheSurface) {
  constexpr double kOfRms = 1e-4;  // RMS error over RMS height, n <= 20 at 257 points; largest seen 4.2e-5
  // The largest error is at the outermost points: pitch^4 / 384 times the fourth derivative. For a pure
  // Z_20^0 of unit RMS that is sqrt(21) 256 P_10''''(1) = 3.7e8 at the rim. Seen 9e-4.
  constexpr double kLargest = 3.6e-3;
  for (const Part& part : {fit_like_draw(), low_orders(), waves()}) {
    const SagFile file = parse_sag_file(part.text(ExportFormat::kZemaxGridSag));
    const PupilSample pupil = make_pupil(part.aperture, {PupilLayout::kSobol, 20000, 3});
    const SurfaceField truth = field_of(part, pupil), read = field_of(file, pupil, Interpolation::kBicubic);
    const double scale = rms(pupil, truth.height);
    const Eigen::ArrayXd error = (read.height - truth.height).abs();
    std::cout << "bicubic, " << part.terms.size() << " terms: RMS error " << rms(pupil, error) / scale
              << ", largest " << error.maxCoeff() / scale << " of the RMS height; slope error "
              << slope_error(pupil, read, truth) << "\n";
    EXPECT_LT(rms(pupil, error) / scale, kOfRms);
    EXPECT_LT(error.maxCoeff() / scale, kLargest);
  }
}

TEST(ExportedGridSag, TracesLikeTheTermsWhenReadWithItsDerivatives) {
  constexpr double kEe90 = 1e-3;
  for (const Part& part : {fit_like_draw(), low_orders(), waves()}) {
    const SagFile file = parse_sag_file(part.text(ExportFormat::kZemaxGridSag));
    const PupilSample pupil = make_pupil(part.aperture, {PupilLayout::kPolar, 65536, 1});
    const SurfaceField truth = field_of(part, pupil);
    const double exact = ee90(pupil, truth);
    const double read = ee90(pupil, field_of(file, pupil, Interpolation::kBicubic));
    std::cout << "EE90, " << part.terms.size() << " terms: " << exact * 1e6 << " um, grid sag "
              << read / exact - 1 << " off\n";
    EXPECT_GT(exact, 1e-6);
    EXPECT_NEAR(read / exact, 1, kEe90);
  }
}

TEST(ExportedGridSag, MisleadsRaysWhenReadWithoutItsDerivatives) {
  // Between the nodes of a bilinear grid the normals jump. Its slope error falls with the pitch, not with its
  // cube, so the spot is wrong although the surface looks right.
  constexpr double kEe90 = 1e-3;  // what the bicubic reader keeps
  const Part part = fit_like_draw();
  const PupilSample pupil = make_pupil(part.aperture, {PupilLayout::kPolar, 65536, 1});
  const SurfaceField truth = field_of(part, pupil);
  const double exact = ee90(pupil, truth);
  std::map<int, double> bicubic_error, bilinear_error;
  for (const int size : {129, 257}) {
    const SagFile file = parse_sag_file(part.text(ExportFormat::kZemaxGridSag, size));
    const SurfaceField bicubic = field_of(file, pupil, Interpolation::kBicubic);
    const SurfaceField bilinear = field_of(file, pupil, Interpolation::kBilinear);
    bicubic_error[size] = slope_error(pupil, bicubic, truth);
    bilinear_error[size] = slope_error(pupil, bilinear, truth);
    std::cout << size << " points: slope error bicubic " << bicubic_error[size] << ", bilinear "
              << bilinear_error[size] << "; EE90 bicubic " << ee90(pupil, bicubic) / exact - 1
              << ", bilinear " << ee90(pupil, bilinear) / exact - 1 << "\n";
    EXPECT_GT(std::abs(ee90(pupil, bilinear) / exact - 1), kEe90);
    EXPECT_LT(std::abs(ee90(pupil, bicubic) / exact - 1), kEe90);
    EXPECT_GT(bilinear_error[size], 50 * bicubic_error[size]);
  }
  EXPECT_NEAR(std::log2(bicubic_error[129] / bicubic_error[257]), 3, 0.3);
  EXPECT_NEAR(std::log2(bilinear_error[129] / bilinear_error[257]), 1, 0.3);
}

TEST(ExportedInt, HoldsTheSurfaceWithinHalfACount) {
  for (const auto& [name, aperture] : apertures())
    for (const double offset : {-1e-6, 0.0, 1e-6}) {  // below zero throughout, mixed, above
      SCOPED_TRACE(name + " " + std::to_string(offset));
      const Part part = asymmetric(aperture, offset);
      const std::string text = part.text(ExportFormat::kCodeVInt, 48);
      std::istringstream lines(text);
      std::string line, word, kind;
      do {
        ASSERT_TRUE(std::getline(lines, line));
        EXPECT_LE(line.size(), 81u);
      } while (line[0] == '!');
      EXPECT_NE(line.find("part (side "), std::string::npos);  // no lateral size elsewhere
      int nx = 0, ny = 0;
      lines >> word >> nx >> ny >> kind;
      EXPECT_EQ(word + kind, "GRDSUR");
      EXPECT_EQ(nx, 48);
      EXPECT_EQ(ny, 48);
      double wvl = 0, ssz = 0;
      int no_data = 32767;
      std::getline(lines, line);
      std::istringstream rest(line);
      while (rest >> word) {
        if (word == "WVL") rest >> wvl;
        if (word == "SSZ") rest >> ssz;
        if (word == "NDA") rest >> no_data;
      }
      EXPECT_NEAR(wvl, 0.6328, 1e-12);
      const auto [x0, y0, side] = square_of(name);
      const double metres = wvl * 1e-6 / ssz, step = side / 47;
      int most = 0, valid = 0;
      for (int r = 0; r < 48; ++r)
        for (int c = 0; c < 48; ++c) {
          int count = 0;
          ASSERT_TRUE(lines >> count);
          const double x = x0 - side / 2 + c * step, y = y0 + side / 2 - r * step;  // top row first
          EXPECT_FALSE(surely_inside(aperture, x, y) && count == no_data) << x << " " << y;
          EXPECT_FALSE(surely_outside(aperture, x, y) && count != no_data) << x << " " << y;
          if (count == no_data) continue;
          ++valid;
          most = std::max(most, std::abs(count));
          EXPECT_NEAR(count * metres, part.height(x, y), 0.501 * metres);
        }
      EXPECT_FALSE(lines >> word);
      EXPECT_GT(valid, 200);
      EXPECT_GT(most, 32000);  // the range is used
      EXPECT_LE(most, 32767);
    }
}

TEST(ExportedFits, IsTheSquareOpdPoppyWants) {
  for (const auto& [name, aperture] : apertures()) {
    SCOPED_TRACE(name);
    const Part part = asymmetric(aperture);
    const std::string bytes = part.text(ExportFormat::kFitsOpd, 50);
    // Cards of 80 characters in blocks of 2880 bytes, then big-endian doubles (FITS standard 4.0).
    ASSERT_EQ(bytes.size() % 2880, 0u);
    std::map<std::string, std::string> cards;
    std::size_t at = 0;
    for (bool end = false; !end; at += 80) {
      ASSERT_LE(at + 80, bytes.size());
      const std::string card = bytes.substr(at, 80);
      std::string key = card.substr(0, 8);
      key.erase(key.find_last_not_of(' ') + 1);
      end = key == "END";
      if (card.substr(8, 2) == "= ") cards[key] = card.substr(10, card.find(" /", 10) - 10);
    }
    at = (at + 2879) / 2880 * 2880;
    EXPECT_NE(cards["SIMPLE"].find('T'), std::string::npos);
    EXPECT_EQ(std::stoi(cards.at("BITPIX")), -64);
    EXPECT_EQ(std::stoi(cards.at("NAXIS")), 2);
    EXPECT_EQ(std::stoi(cards.at("NAXIS1")), 50);
    EXPECT_EQ(std::stoi(cards.at("NAXIS2")), 50);
    const std::string unit = cards.at("BUNIT");
    EXPECT_TRUE(unit.find("'meter") != std::string::npos || unit.find("'m ") != std::string::npos ||
                unit.find("'m'") != std::string::npos)
        << unit;
    const auto [x0, y0, side] = square_of(name);
    EXPECT_NEAR(std::stod(cards.at("PIXELSCL")), side / 49, 1e-12);
    ASSERT_GE(bytes.size(), at + 50 * 50 * 8);
    for (int r = 0; r < 50; ++r)  // first row at the lowest y
      for (int c = 0; c < 50; ++c, at += 8) {
        std::uint64_t bits = 0;
        for (std::size_t k = 0; k < 8; ++k) bits = bits << 8 | static_cast<unsigned char>(bytes[at + k]);
        const double opd = std::bit_cast<double>(bits);
        const double x = x0 - side / 2 + c * side / 49, y = y0 - side / 2 + r * side / 49;
        if (surely_outside(aperture, x, y) || opd == 0) {
          EXPECT_EQ(opd, 0);
          EXPECT_FALSE(surely_inside(aperture, x, y)) << x << " " << y;
        } else {
          EXPECT_NEAR(opd, 2 * part.height(x, y), 1e-20);
        }
      }
  }
}

TEST(ExportedCsv, ListsThePointsOfTheAperture) {
  for (const auto& [name, aperture] : apertures()) {
    SCOPED_TRACE(name);
    const Part part = asymmetric(aperture, 1e-6);
    std::istringstream lines(part.text(ExportFormat::kCsv, 40));
    int rows = 0, least = 0, most = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line[0] == '#' || std::isalpha(static_cast<unsigned char>(line[0]))) continue;
      double x = 0, y = 0, h = 0;
      ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &x, &y, &h), 3) << line;
      EXPECT_FALSE(surely_outside(aperture, x, y)) << line;
      EXPECT_NEAR(h, part.height(x, y), 1e-20);
      ++rows;
    }
    const auto [x0, y0, side] = square_of(name);
    for (int r = 0; r < 40; ++r)
      for (int c = 0; c < 40; ++c) {
        const double x = x0 + side * (c / 39.0 - 0.5), y = y0 + side * (r / 39.0 - 0.5);
        least += surely_inside(aperture, x, y);
        most += !surely_outside(aperture, x, y);
      }
    EXPECT_GT(least, 100);
    EXPECT_GE(rows, least);
    EXPECT_LE(rows, most);
  }
}

TEST(ExportFile, NamesItsFilesAndFormats) {
  EXPECT_EQ(export_names(), (std::vector<std::string>{"zemax-grid-sag", "zernike-noll", "codev-int",
                                                      "codev-zfr", "fits-opd", "csv"}));
  Part part(CircleAperture{0.4, 0}, zernike_modes(2, 4));
  part.coefficients.setConstant(1e-8);
  const std::vector<std::string> files = {
      "grid_sag.DAT", "zernike_standard.txt", "surface.int", "zernike_fringe.int", "opd.fits", "surface.csv"};
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto [name, text] = export_file(ExportFormat(i), part.input(33));
    EXPECT_EQ(name, files[i]);
    EXPECT_FALSE(text.empty());
  }
}

TEST(ExportFile, TakesAnyTitle) {
  Part part(CircleAperture{0.4, 0}, zernike_modes(2, 4));
  part.coefficients.setConstant(1e-8);
  for (const std::string& title : {std::string(), std::string("!GRD\n5 5 SUR\r\nZFR 1 SUR"),
                                   std::string(500, 'x'), std::string("\xCE\xBB/20")}) {
    ExportInput input = part.input(9);
    input.title = title;
    EXPECT_NO_THROW(parse_sag_file(export_file(ExportFormat::kZemaxGridSag, input).second));
    const std::string int_text = export_file(ExportFormat::kCodeVInt, input).second;
    EXPECT_EQ(std::count(int_text.begin(), int_text.begin() + long(int_text.find("GRD 9 9")), '\n'), 1);
    const std::string zfr = export_file(ExportFormat::kCodeVZfr, input).second;
    EXPECT_EQ(std::count(zfr.begin(), zfr.begin() + long(zfr.find("\nZFR ")), '\n'), 3);
    for (const ExportFormat format : {ExportFormat::kZernikeNoll, ExportFormat::kCsv}) {
      const std::string text = export_file(format, input).second;
      EXPECT_TRUE(std::all_of(text.begin(), text.end(),
                              [](char c) { return c == '\n' || c == '\t' || (c >= ' ' && c <= '~'); }));
    }
  }
}

TEST(ExportFile, RefusesWhatMakesNoFile) {
  Part part(CircleAperture{0.4, 0}, zernike_modes(2, 4));
  part.coefficients.setConstant(1e-8);
  for (std::size_t i = 0; i < export_names().size(); ++i) {
    const auto format = ExportFormat(i);
    ExportInput input = part.input(33);
    for (const double wavelength : {0.0, -1e-6, std::numeric_limits<double>::infinity()}) {
      input.wavelength = wavelength;
      EXPECT_THROW(export_file(format, input), std::invalid_argument) << export_names()[i];
    }
    EXPECT_THROW(export_file(format, part.input(4)), std::invalid_argument);
    Part bad = part;
    bad.coefficients[3] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(export_file(format, bad.input(33)), std::invalid_argument);
    bad.coefficients.resize(3);
    EXPECT_THROW(export_file(format, bad.input(33)), std::invalid_argument);
  }
}

}  // namespace aberfit
