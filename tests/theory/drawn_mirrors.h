#pragma once
#include <fftw3.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "aberfit/roughness/psd.h"

// Differences between realisations of a mirror, by independent test code. It uses Fourier sums of Gaussian
// noise on a periodic square of twice the aperture and Fraunhofer patterns of a paraxial pupil, whose
// autocorrelation is summed exactly over discs.

namespace aberfit::testing_draws {

using Complex = std::complex<double>;

struct DrawnScene {
  RadialPsd psd;
  double focal_length, diameter, inner_diameter, wavelength;
  int cells;  // grid points across the aperture
  /// For a fast parabola, diameters and grid points are f times a direction cosine, 2 f tan(theta/2) on the
  /// mirror. A height counts by (1 + cos theta)/2.
  bool is_fast = false;
};

class DrawnMirrors {
 public:
  /// cuts: ascending [cycles/m].
  DrawnMirrors(const DrawnScene& scene, std::vector<double> cuts)
      : scene_(scene), cuts_(std::move(cuts)), side_(2 * scene.cells), pitch_(scene.diameter / scene.cells) {
    data_.resize(std::size_t(side_) * std::size_t(side_));
    auto* raw = reinterpret_cast<fftw_complex*>(data_.data());
    plan_ = fftw_plan_dft_2d(side_, side_, raw, raw, FFTW_FORWARD, FFTW_ESTIMATE);
    set_cover();
    set_amplitudes();
    const double wave = 4 * std::numbers::pi / scene.wavelength;
    for (const double cut : cuts_) {
      const Eigen::ArrayXd x =
          Eigen::ArrayXd::LinSpaced(8 * scene.cells + 1, 0, 8.0 * scene.cells) * (pitch_ / 8);
      const RadialPsd rest = scene.psd.band(cut, std::min(scene.psd.f_max(), 0.5 / pitch_));
      transfer_.push_back((-wave * wave * structure_function(rest, x)).exp());
    }
  }
  DrawnMirrors(const DrawnMirrors&) = delete;
  DrawnMirrors& operator=(const DrawnMirrors&) = delete;
  ~DrawnMirrors() { fftw_destroy_plan(plan_); }

  struct Discs {
    double dz;
    std::vector<double> radius;
    std::vector<double> frequency = {};  ///< of the image: transfer functions, in rows after the discs
    bool has_axis = false;               ///< adds a last row: axial irradiance over a flat mirror's
  };
  /// Standard deviation over the realisations of the energy in a disc, less that of the same mirror cut off
  /// times H_rest: one matrix (radius x cut) per plane. means, when given: means of the same differences.
  std::vector<Eigen::ArrayXXd> spread(const std::vector<Discs>& planes, int draws, std::uint64_t seed,
                                      std::vector<Eigen::ArrayXXd>* means = nullptr) {
    const auto count = Eigen::Index(cuts_.size());
    std::vector<std::vector<Eigen::ArrayXd>> kernels;  // per plane and radius: values x (cuts + whole)
    std::vector<Eigen::ArrayXXd> sum, squares;
    for (const Discs& plane : planes) {
      kernels.push_back(kernels_of(plane));
      sum.push_back(Eigen::ArrayXXd::Zero(Eigen::Index(kernels.back().size()), count));
      squares.push_back(sum.back());
    }
    std::mt19937_64 random(seed);
    for (int draw = 0; draw < draws; draw += 2) {  // a complex sum gives two mirrors
      const std::vector<std::vector<Complex>> shells = shell_heights(&random);
      for (const bool second : {false, true})
        for (std::size_t p = 0; p < planes.size(); ++p) {
          std::vector<double> height(data_.size());
          Eigen::ArrayXXd low(sum[p].rows(), count);
          Eigen::ArrayXd whole;
          for (std::size_t j = 0; j <= cuts_.size(); ++j) {
            for (std::size_t k = 0; k < height.size(); ++k)
              height[k] += second ? shells[j][k].imag() : shells[j][k].real();
            const Eigen::ArrayXd light = shares(height, planes[p].dz, kernels[p], j);
            if (j < cuts_.size())
              low.col(Eigen::Index(j)) = light;
            else
              whole = light;
          }
          const Eigen::ArrayXXd difference = (-low).colwise() + whole;
          sum[p] += difference;
          squares[p] += difference.square();
        }
    }
    for (std::size_t p = 0; p < planes.size(); ++p) {
      sum[p] /= draws;
      squares[p] = ((squares[p] / draws - sum[p].square()) * draws / (draws - 1.0)).max(0.0).sqrt();
    }
    if (means) *means = sum;
    return squares;
  }

  /// Energy in the discs of whole mirrors, discs x realisations.
  Eigen::ArrayXXd light(const Discs& discs, int draws, std::uint64_t seed) {
    const std::vector<Eigen::ArrayXd> kernels = kernels_of(discs);
    Eigen::ArrayXXd result(Eigen::Index(kernels.size()), draws);
    std::mt19937_64 random(seed);
    for (int draw = 0; draw < draws; ++draw) {
      std::vector<double> height(data_.size());
      for (const std::vector<Complex>& shell : shell_heights(&random))
        for (std::size_t k = 0; k < height.size(); ++k) height[k] += shell[k].real();
      result.col(draw) = shares(height, discs.dz, kernels, cuts_.size());
    }
    return result;
  }

 private:
  void set_cover() {
    constexpr int kParts = 8;
    cover_.assign(std::size_t(scene_.cells) * std::size_t(scene_.cells), 0);
    const auto at = [&](double cell) { return (cell - 0.5 * scene_.cells) * pitch_; };
    for (int row = 0; row < scene_.cells; ++row)
      for (int column = 0; column < scene_.cells; ++column) {
        double& cover = cover_[std::size_t(row) * std::size_t(scene_.cells) + std::size_t(column)];
        for (int i = 0; i < kParts; ++i)
          for (int j = 0; j < kParts; ++j) {
            const double r = std::hypot(at(row + (i + 0.5) / kParts), at(column + (j + 0.5) / kParts));
            cover +=
                (r <= 0.5 * scene_.diameter && r >= 0.5 * scene_.inner_diameter) / double(kParts * kParts);
          }
      }
  }

  // Root of the PSD's integral over the grid cell of each frequency, for each shell between cuts.
  void set_amplitudes() {
    constexpr int kParts = 5;
    const double step = 1 / (side_ * pitch_);
    amplitude_.assign(cuts_.size() + 1, std::vector<double>(data_.size()));
    for (int i = 0; i < side_; ++i)
      for (int j = 0; j < side_; ++j)
        for (int a = 0; a < kParts; ++a)
          for (int b = 0; b < kParts; ++b) {
            const double u = (i < scene_.cells ? i : i - side_) + (a + 0.5) / kParts - 0.5;
            const double v = (j < scene_.cells ? j : j - side_) + (b + 0.5) / kParts - 0.5;
            const double f = std::hypot(u, v) * step;
            if (f > 0.5 / pitch_) continue;
            const auto shell = std::size_t(std::upper_bound(cuts_.begin(), cuts_.end(), f) - cuts_.begin());
            amplitude_[shell][std::size_t(i) * std::size_t(side_) + std::size_t(j)] +=
                scene_.psd(f) * step * step / (kParts * kParts);
          }
    for (auto& shell : amplitude_)
      for (double& value : shell) value = std::sqrt(value);
  }

  std::vector<std::vector<Complex>> shell_heights(std::mt19937_64* random) {
    std::normal_distribution<double> normal;
    std::vector<std::vector<Complex>> result;
    for (const auto& amplitude : amplitude_) {
      for (std::size_t k = 0; k < data_.size(); ++k) {
        const double a = normal(*random), b = normal(*random);
        data_[k] = amplitude[k] * Complex(a, b);
      }
      fftw_execute(plan_);
      result.push_back(data_);
    }
    return result;
  }

  // Weight of a lag of i^2 + j^2 grid cells^2 in the energy of a disc.
  Eigen::ArrayXd disc_kernel(double radius, double dz) const {
    const double scale = pitch_ / (scene_.wavelength * (scene_.focal_length + dz));
    Eigen::ArrayXd result(scene_.cells * scene_.cells + 1);
    for (Eigen::Index s = 0; s < result.size(); ++s) {
      const double nu = scale * std::sqrt(double(s)), z = 2 * std::numbers::pi * radius * nu;
      result[s] = scale * scale *
                  (s == 0 ? std::numbers::pi * radius * radius : radius * std::cyl_bessel_j(1.0, z) / nu);
    }
    return result;
  }

  // The transfer function of the irradiance in the field of view: int I J0(2 pi nu r) d2r.
  Eigen::ArrayXd transfer_kernel(double frequency, double dz) const {
    const double scale = pitch_ / (scene_.wavelength * (scene_.focal_length + dz)), lag = frequency / scale;
    constexpr int kRadii = 512;
    Eigen::ArrayXd own(kRadii), result(scene_.cells * scene_.cells + 1);
    const auto q = [](int k) { return 0.5 * (k + 0.5) / kRadii; };
    const auto phase = [&](int k, double s) { return 2 * std::numbers::pi * q(k) * s; };
    for (int k = 0; k < kRadii; ++k)
      own[k] = std::numbers::pi * q(k) / kRadii * std::cyl_bessel_j(0.0, phase(k, lag));
    for (Eigen::Index s = 0; s < result.size(); ++s) {
      double sum = 0;
      if (is_sum_of_squares(int(s)))
        for (int k = 0; k < kRadii; ++k)
          sum += own[k] * std::cyl_bessel_j(0.0, phase(k, std::sqrt(double(s))));
      result[s] = sum;
    }
    return result;
  }
  static bool is_sum_of_squares(int s) {
    for (int a = 0; a * a <= s; ++a) {
      const int b = int(std::lround(std::sqrt(double(s - a * a))));
      if (a * a + b * b == s) return true;
    }
    return false;
  }

  // All lags have the same weight: the square of the field's sum over that of a flat mirror.
  Eigen::ArrayXd axis_kernel() const {
    double sum = 0, squares = 0;
    for (const double cover : cover_) sum += cover, squares += cover * cover;
    return Eigen::ArrayXd::Constant(scene_.cells * scene_.cells + 1, squares / (sum * sum));
  }

  std::vector<Eigen::ArrayXd> kernels_of(const Discs& plane) const {
    std::vector<Eigen::ArrayXd> kernels;
    for (const double radius : plane.radius) kernels.push_back(disc_kernel(radius, plane.dz));
    for (const double frequency : plane.frequency) kernels.push_back(transfer_kernel(frequency, plane.dz));
    if (plane.has_axis) kernels.push_back(axis_kernel());
    return kernels;
  }

  // Energy in discs; a cut below cuts_.size() multiplies by its H_rest.
  Eigen::ArrayXd shares(const std::vector<double>& height, double dz,
                        const std::vector<Eigen::ArrayXd>& kernels, std::size_t cut) {
    const int cells = scene_.cells;
    const double wave = 4 * std::numbers::pi / scene_.wavelength;
    const double defocus =
        std::numbers::pi * dz / (scene_.wavelength * scene_.focal_length * (scene_.focal_length + dz));
    std::fill(data_.begin(), data_.end(), Complex(0));
    double total = 0;
    for (int row = 0; row < cells; ++row)
      for (int column = 0; column < cells; ++column) {
        const double cover = cover_[std::size_t(row) * std::size_t(cells) + std::size_t(column)];
        const double x = (column + 0.5 - 0.5 * cells) * pitch_, y = (row + 0.5 - 0.5 * cells) * pitch_;
        const std::size_t k = std::size_t(row) * std::size_t(side_) + std::size_t(column);
        const double sine = std::hypot(x, y) / scene_.focal_length;
        const double counts = scene_.is_fast ? 0.5 * (1 + std::sqrt(std::max(0.0, 1 - sine * sine))) : 1;
        data_[k] = std::polar(cover, -wave * counts * height[k] - defocus * (x * x + y * y));
        total += cover * cover;
      }
    fftw_execute(plan_);
    for (Complex& value : data_) value = std::norm(value);
    fftw_execute(plan_);  // even and real, so this is also the inverse, times the size
    Eigen::ArrayXd lags = Eigen::ArrayXd::Zero(cells * cells + 1);
    for (int i = 0; i < side_; ++i)
      for (int j = 0; j < side_; ++j) {
        const int a = std::min(i, side_ - i), b = std::min(j, side_ - j), s = a * a + b * b;
        if (s < lags.size()) lags[s] += data_[std::size_t(i) * std::size_t(side_) + std::size_t(j)].real();
      }
    if (cut < cuts_.size())
      for (Eigen::Index s = 0; s < lags.size(); ++s) {
        const double place = 8 * std::sqrt(double(s));
        const auto i = std::min(Eigen::Index(place), Eigen::Index(8 * cells - 1));
        lags[s] *= transfer_[cut][i] + (place - double(i)) * (transfer_[cut][i + 1] - transfer_[cut][i]);
      }
    Eigen::ArrayXd result(Eigen::Index(kernels.size()));
    for (std::size_t r = 0; r < kernels.size(); ++r)
      result[Eigen::Index(r)] = (lags * kernels[r]).sum() / (total * double(data_.size()));
    return result;
  }

  DrawnScene scene_;
  std::vector<double> cuts_;
  int side_;
  double pitch_;
  std::vector<Complex> data_;
  fftw_plan plan_;
  std::vector<double> cover_;
  std::vector<std::vector<double>> amplitude_;  // per shell between cuts
  std::vector<Eigen::ArrayXd> transfer_;        // H_rest over steps of pitch/8, per cut
};

}  // namespace aberfit::testing_draws
