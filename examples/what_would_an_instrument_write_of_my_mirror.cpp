// What would an instrument write of my mirror? This program writes files of three mirrors whose truth is
// known: two profiles of slopes in the format of DABAM and an interferogram in that of Zygo MetroPro. Read
// them with `aberfit psd` or a study (fits/measured-smooth, measured-turning-lines, map-zygo) and compare the
// result.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "aberfit/core/random.h"
#include "aberfit/roughness/random_surface.h"
#include "aberfit/scene/zernike.h"

namespace {

using std::numbers::pi;

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

Eigen::ArrayXd positions(Eigen::Index points, double pitch) {
  return Eigen::ArrayXd::LinSpaced(points, -0.5, 0.5) * pitch * double(points - 1);
}

// Random slopes [rad] at x on a line over a surface with this PSD. They are a sum of plane waves with normal
// amplitudes, every eighth of 1/length up to half the sampling rate, and exact for that sum.
Eigen::ArrayXd drawn_slopes(const aberfit::RadialPsd& psd, const Eigen::ArrayXd& x, const char* name) {
  const aberfit::RandomStream stream(1, name);
  const double step = 1 / (8 * (x[x.size() - 1] - x[0]));
  Eigen::ArrayXd slopes = Eigen::ArrayXd::Zero(x.size());
  for (Eigen::Index wave = 0; wave < 4 * x.size(); ++wave) {
    const double f = (double(wave) + 0.5) * step, k = 2 * pi * f;
    const auto [a, b] = stream.normal_pair(std::uint64_t(wave));
    slopes += k * std::sqrt(aberfit::profile_psd(psd, f) * step) * (b * (k * x).cos() - a * (k * x).sin());
  }
  return slopes;
}

// Slope at x of an ellipse with these arms and grazing angle; the pole is at x = 0. The normal halves the
// angle between the rays to the foci. Newton's method finds the height, in extended precision because the
// rays nearly cancel.
double ellipse_slope(double p, double q, double theta, double at) {
  using Real = long double;
  const Real c = std::cos(Real(theta)), s = std::sin(Real(theta)), x = at;
  Real z = 0, ex = 0, ez = 1;
  for (int step = 0; step < 20; ++step) {
    const Real d1 = std::sqrt((x + p * c) * (x + p * c) + (z - p * s) * (z - p * s)),
               d2 = std::sqrt((x - q * c) * (x - q * c) + (z - q * s) * (z - q * s));
    ex = (x + p * c) / d1 + (x - q * c) / d2;
    ez = (z - p * s) / d1 + (z - q * s) / d2;
    z -= (d1 + d2 - Real(p) - Real(q)) / ez;
  }
  return double(-ex / ez);
}

// Writes a DABAM pair, FILE_FORMAT 1: positions in mm, slopes in urad.
void write_dabam(const std::filesystem::path& folder, const std::string& name, const std::string& what,
                 const Eigen::ArrayXd& x, const Eigen::ArrayXd& slopes) {
  write(folder / (name + ".txt"),
        fmt::format("{{\n  \"FILE_FORMAT\": 1,\n  \"FILE_HEADER_LINES\": 2,\n  \"X1_FACTOR\": 0.001,\n"
                    "  \"Y1_FACTOR\": 1e-06,\n  \"FACILITY\": \"none: made by a program\",\n"
                    "  \"USER_REFERENCE\": \"{}\",\n  \"LENGTH\": {:.3f}\n}}\n",
                    what, x[x.size() - 1] - x[0]));
  std::string data = fmt::format("{}\nx(mm)\tslope(urad)\n", what);
  for (Eigen::Index i = 0; i < x.size(); ++i)
    data += fmt::format("{:.2f}\t{:.4f}\n", 1e3 * x[i] + 0.0, 1e6 * slopes[i]);
  write(folder / (name + ".dat"), data);
}

// For fits/measured-smooth, this is an elliptical mirror of 350 mm with the roughness that the polish left.
void write_smooth(const std::filesystem::path& folder) {
  const aberfit::PowerLawPsd truth{
      .rms = {}, .amplitude = 2.5e-17, .exponent = 4.5, .f_min = 1, .f_max = 1e5};
  const Eigen::ArrayXd x = positions(1401, 0.25e-3);
  Eigen::ArrayXd slopes = drawn_slopes(aberfit::RadialPsd(truth), x, "smooth");
  for (Eigen::Index i = 0; i < x.size(); ++i) slopes[i] += ellipse_slope(30, 3, 4e-3, x[i]);
  write_dabam(folder, "smooth", "ellipse, arms 30 m and 3 m, 4 mrad, smooth", x, slopes);
  fmt::print("smooth: 2-D PSD {:.3g} m^4 (f m)^-{:g}\n", *truth.amplitude, truth.exponent);
}

// For fits/measured-turning-lines, this is one metre of a flat that was turned and then polished.
void write_turned(const std::filesystem::path& folder) {
  const aberfit::PowerLawPsd truth{.rms = {}, .amplitude = 4e-18, .exponent = 3, .f_min = 1, .f_max = 1e5};
  const double line_rms = 0.3e-9, line_frequency = 125;
  const Eigen::ArrayXd x = positions(1001, 1e-3);
  const double k = 2 * pi * line_frequency;
  const Eigen::ArrayXd slopes = drawn_slopes(aberfit::RadialPsd(truth), x, "turned") +
                                std::sqrt(2.0) * line_rms * k * (k * x + 0.7).cos();
  write_dabam(folder, "turned", "flat with turning marks every 8 mm", x, slopes);
  fmt::print("turned: 2-D PSD {:.3g} m^4 (f m)^-{:g}, a line of {:.2f} nm RMS at {:g} /m\n", *truth.amplitude,
             truth.exponent, 1e9 * line_rms, line_frequency);
}

void put(std::string* bytes, std::size_t at, std::uint32_t value, int width) {
  for (int i = 0; i < width; ++i) (*bytes)[at + std::size_t(i)] = char(value >> (8 * (width - 1 - i)));
}

// A MetroPro .dat file, header format 2, big-endian, without intensity; the top row comes first. One wave has
// 32,768 counts, and heights have the interferometric scale 1/2. Points without a height have an invalid
// code.
std::string metropro(const aberfit::HeightMap& map, const std::string& comment) {
  constexpr float kScale = 0.5f, kWavelength = 6.328e-7f;
  const Eigen::Index rows = map.rows(), columns = map.columns();
  std::string bytes(std::size_t(834 + 4 * rows * columns), '\0');
  put(&bytes, 0, 0x881B0370, 4);
  put(&bytes, 6, 834, 4);
  put(&bytes, 68, std::uint32_t(columns), 2);
  put(&bytes, 70, std::uint32_t(rows), 2);
  put(&bytes, 72, std::uint32_t(4 * rows * columns), 4);
  bytes.replace(80, comment.size(), comment);
  const std::pair<std::size_t, float> numbers[] = {
      {164, kScale}, {168, kWavelength}, {176, 1.0f}, {184, float(map.pitch_x)}};
  for (const auto& [at, value] : numbers) put(&bytes, at, std::bit_cast<std::uint32_t>(value), 4);
  put(&bytes, 218, 1, 2);
  const double unit = double(kScale) * double(kWavelength) / 32768;
  std::size_t at = 834;
  for (Eigen::Index row = rows - 1; row >= 0; --row)
    for (Eigen::Index column = 0; column < columns; ++column, at += 4) {
      const double height = map.height(row, column);
      put(&bytes, at, std::isnan(height) ? 2147483640u : std::uint32_t(std::lround(height / unit)), 4);
    }
  return bytes;
}

// For fits/map-zygo, this is a part of 51 mm whose terms are known over its clear aperture of 48.4 mm. Its
// rim is turned down by 300 nm and has gaps, and the map has dropouts.
void write_interferogram(const std::filesystem::path& folder) {
  const std::pair<int, double> terms[] = {{4, 12e-9}, {5, -18e-9}, {6, 22e-9},  {7, 9e-9}, {8, -6e-9},
                                          {9, 4e-9},  {10, -5e-9}, {11, 10e-9}, {22, 4e-9}};
  const double clear = 24.2e-3, edge = 25.5e-3, pitch = double(0.38e-3f);
  const aberfit::UniformPsd truth{.rms = 8e-9, .f_min = 300, .f_max = 1000};
  aberfit::HeightMap map = aberfit::random_surface(aberfit::RadialPsd(truth), 137, 136, pitch, {.seed = 5});
  const aberfit::RandomStream dropouts(1, "dropouts");
  for (Eigen::Index row = 0; row < map.rows(); ++row)
    for (Eigen::Index column = 0; column < map.columns(); ++column) {
      const double x = map.x(column), y = map.y(row), r = std::hypot(x, y);
      double& height = map.height(row, column);
      for (const auto& [noll, value] : terms)
        height += value * aberfit::zernike(aberfit::zernike_from_noll(noll), x / clear, y / clear).value;
      if (r > clear) height -= 300e-9 * std::pow((r - clear) / (edge - clear), 2);
      const bool bite = std::hypot(x - 24e-3, y - 8e-3) < 2e-3 || std::hypot(x + 10e-3, y + 23e-3) < 2.5e-3;
      if (r > edge || bite || dropouts.uniform(std::uint64_t(row * map.columns() + column)) < 0.003)
        height = std::nan("");
    }
  write(folder / "interferogram.dat", metropro(map, "made by a program"));
  fmt::print("interferogram: {} terms over {:.1f} mm, roughness of {:.1f} nm RMS from {:g} to {:g} /m\n",
             std::size(terms), 2e3 * clear, 1e9 * truth.rms, truth.f_min, truth.f_max);
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "measured_files";
  std::filesystem::create_directories(folder);
  write_smooth(folder);
  write_turned(folder);
  write_interferogram(folder);
  fmt::print("written to {}\n", folder.string());
}
