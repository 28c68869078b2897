#include "independent_waves.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace aberfit {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPadding = 4;
constexpr int kPointsAcross = 8;     // of a cell, for its share of the aperture
constexpr double kPartOfRadius = 2;  // samples that four nodes of Gauss serve
constexpr double kGaussNode[] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                 0.8611363115940526};
constexpr double kGaussWeight[] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                   0.3478548451374538};

}  // namespace

IndependentWaves::IndependentWaves(double f, const Aperture& aperture, double wavelength,
                                   const IndependentSurface& surface, int cells)
    : focal_length_(f), wavelength_(wavelength), samples_(kPadding * cells) {
  const double t_rim = aperture_radius(aperture) / (2 * f);
  rim_ = t_rim;
  pitch_ = 2 * aperture_radius(aperture) / (1 + t_rim * t_rim) / cells;
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; ++column) {
      int inside = 0;
      double x = 0, y = 0;  // the middle of what is inside
      std::complex<double> turned = 0;
      for (int i = 0; i < kPointsAcross * kPointsAcross; ++i) {
        const double px = (column + (i % kPointsAcross + 0.5) / kPointsAcross - 0.5 * cells) * pitch_;
        const double py = (row + (double(i / kPointsAcross) + 0.5) / kPointsAcross - 0.5 * cells) * pitch_;
        const double sine = std::hypot(px, py) / f;
        if (!(sine < 1)) continue;
        const double t = sine / (1 + std::sqrt(1 - sine * sine));
        const double longer = 1 + t * t;  // r over f sin(theta)
        if (!aperture_contains(aperture, px * longer, py * longer, 0)) continue;
        ++inside;
        x += px * longer;
        y += py * longer;
        if (surface.has_steps())
          turned += std::polar(1.0, 4 * kPi / wavelength * surface.step(px * longer, py * longer) / longer);
      }
      if (inside == 0) continue;
      x /= inside;
      y /= inside;
      const double t2 = (x * x + y * y) / (4 * f * f), cover = inside / double(kPointsAcross * kPointsAcross);
      const double density = std::pow(1 + t2, 3) / (1 - t2);
      total_ += cover * density;
      const std::complex<double> step = surface.has_steps() ? turned / double(inside) : 1;
      cells_.push_back({column, row, cover * std::sqrt(density) * std::abs(step),
                        4 * kPi / wavelength * surface.height(x, y) / (1 + t2) + std::arg(step),
                        2 * t2 / (1 + t2)});
    }
  field_ = reinterpret_cast<std::complex<double>*>(
      fftw_alloc_complex(std::size_t(samples_) * std::size_t(samples_)));
  auto* data = reinterpret_cast<fftw_complex*>(field_);
  plan_ = fftw_plan_dft_2d(samples_, samples_, data, data, FFTW_FORWARD, FFTW_ESTIMATE);
}

IndependentWaves::~IndependentWaves() {
  fftw_destroy_plan(static_cast<fftw_plan>(plan_));
  fftw_free(field_);
}

double IndependentWaves::power(int column, int row) const {
  const auto wrapped = [this](int k) { return std::size_t((k % samples_ + samples_) % samples_); };
  return std::norm(field_[wrapped(row) * std::size_t(samples_) + wrapped(column)]);
}

// Mean of the pattern on a circle, by Lagrange polynomials through six samples along either axis.
double IndependentWaves::on_circle(double r) const {
  const int angles = std::max(48, int(std::ceil(6 * r)));
  double sum = 0;
  for (int a = 0; a < angles; ++a) {
    const double x = r * std::cos(2 * kPi * a / angles), y = r * std::sin(2 * kPi * a / angles);
    const int column = int(std::floor(x)) - 2, row = int(std::floor(y)) - 2;
    const auto lagrange = [](double at, double* weight) {  // at: from the first of the six
      for (int i = 0; i < 6; ++i) {
        weight[i] = 1;
        for (int j = 0; j < 6; ++j)
          if (j != i) weight[i] *= (at - j) / (i - j);
      }
    };
    double along_x[6], along_y[6];
    lagrange(x - column, along_x);
    lagrange(y - row, along_y);
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 6; ++i) sum += along_y[j] * along_x[i] * power(column + i, row + j);
  }
  return sum / angles;
}

namespace {

// (4 pi/lambda)^2 (C(0) - C(r)) with C(0) - C(r) = 2 pi int S(f) (1 - J0(2 pi f r)) f df. After kTurns turns
// J0 averages out: it fades from half of there on, and only 1 is left.
class StructureOfPhase {
 public:
  StructureOfPhase(const std::function<double(double)>& psd, double f_min, double f_max, double longest,
                   double wavelength)
      : psd_(psd), k2_(std::pow(4 * kPi / wavelength, 2)) {
    constexpr double kTooLong = 1e-3;  // waves over the longest shear: it sees none of them
    low_ = std::max(f_min, kTooLong / longest);
    high_ = std::min(f_max, 1 / wavelength);  // nothing finer scatters
    // A band without an upper end is cut where 1e-12 of its variance is left.
    std::vector<std::pair<double, double>> shells;
    double all = 0, left = 0;
    for (double at = low_; at < high_; at *= 1.02)
      shells.push_back({at, at * at * psd(at)}), all += shells.back().second;
    while (!shells.empty() && (left += shells.back().second) < 1e-12 * all) {
      high_ = shells.back().first;
      shells.pop_back();
    }
    for (double from = low_; from < high_; from *= 1.02) {
      ends_.push_back(from);
      add_jump(from, std::min(high_, 1.02 * from));
    }
    ends_.push_back(high_);
  }
  double at(double r) const {
    constexpr double kTurns = 30, kPerTurn = 10;
    const double faded = kTurns / r;
    double sum = 0;
    std::size_t end = 1;
    for (double from = low_; from < high_;) {
      double to = ends_[end];
      if (from < faded) to = std::min({to, from + 1 / (kPerTurn * r), faded});
      const double f = 0.5 * (from + to), fading = std::clamp(2 * f / faded - 1, 0.0, 1.0);
      const double bessel =
          from < faded ? std::pow(std::cos(0.5 * kPi * fading), 2) * std::cyl_bessel_j(0.0, 2 * kPi * f * r)
                       : 0;
      sum += 2 * kPi * f * psd_(f) * (to - from) * (1 - bessel);
      from = to;
      if (from == ends_[end]) ++end;
    }
    return k2_ * sum;
  }

 private:
  // If the largest part of a sum begins or ends inside a step, the step is split there. Weaker parts, and a
  // second one in the same step, leave an error of up to 2 % of their variance.
  void add_jump(double from, double to) {
    constexpr double kSteepest = 0.5;  // a slope of -25 in 2 %
    double low = from * (1 + 1e-9), high = to * (1 - 1e-9);
    if (!(low < high)) return;
    const auto jump = [this](double a, double b) { return std::abs(psd_(a) - psd_(b)); };
    if (jump(low, high) <= kSteepest * std::max(psd_(low), psd_(high))) return;
    while (high - low > 1e-9 * low) {
      const double middle = 0.5 * (low + high);
      (jump(low, middle) > jump(middle, high) ? high : low) = middle;
    }
    ends_.push_back(high);
  }

  const std::function<double(double)>& psd_;
  double k2_, low_ = 0, high_ = 0;
  std::vector<double> ends_;  // of steps of 2 % and less
};

}  // namespace

void IndependentWaves::scatter(const std::function<double(double)>& psd, double f_min, double f_max) {
  const double longest = 1.3 * samples_ / kPadding * pitch_ * (1 + rim_ * rim_);
  constexpr int kPerCell = 8;
  const int shears = int(1.5 * samples_ / kPadding) * kPerCell;
  const double step = pitch_ / kPerCell;
  const StructureOfPhase structure(psd, f_min, f_max, longest, wavelength_);
  std::vector<double> exponent(std::size_t(shears), 0.0);
  for (int i = 1; i < shears; ++i) exponent[std::size_t(i)] = structure.at(step * i);
  const auto at = [&](double r) {
    const double place = std::min(r / step, double(shears) - 1.001);
    const auto i = std::size_t(place);
    return exponent[i] + (place - double(i)) * (exponent[i + 1] - exponent[i]);
  };
  // Parts of the aperture with equal energy, which may lie off the axis. Each has t^2 = tan^2(theta/2) and an
  // azimuth, along which heights are foreshortened more than across it.
  constexpr int kParts = 128;
  std::vector<double> light_until;
  for (const Cell& cell : cells_)
    light_until.push_back((light_until.empty() ? 0 : light_until.back()) + cell.amplitude * cell.amplitude);
  std::vector<std::pair<double, double>> parts;
  for (int k = 0; k < kParts; ++k) {
    const double place = 0.6180339887498949 * k;
    const auto here = std::upper_bound(light_until.begin(), light_until.end() - 1,
                                       (place - std::floor(place)) * light_until.back());
    const Cell& cell = cells_[std::size_t(here - light_until.begin())];
    const double middle = 0.5 * samples_ / kPadding - 0.5;
    parts.emplace_back(cell.versine / (2 - cell.versine),
                       std::atan2(cell.row - middle, cell.column - middle));
  }
  factor_.assign(kShearDirections, std::vector<double>(std::size_t(shears), 0.0));
  for (int direction = 0; direction < kShearDirections; ++direction)
    for (const auto& [t2, azimuth] : parts) {
      const double angle = kPi * direction / kShearDirections - azimuth;
      const double across = 1 + t2, along = (1 + t2) * (1 + t2) / (1 - t2);
      const double longer = std::hypot(across * std::sin(angle), along * std::cos(angle));
      for (int i = 0; i < shears; ++i)
        factor_[std::size_t(direction)][std::size_t(i)] +=
            std::exp(-at(i * step * longer) / ((1 + t2) * (1 + t2))) / kParts;
    }
}

// Transforms the pattern to the transfer function, multiplies by the factor, and transforms back.
void IndependentWaves::apply_scatter() {
  const std::size_t all = std::size_t(samples_) * std::size_t(samples_);
  for (std::size_t k = 0; k < all; ++k) field_[k] = std::norm(field_[k]);
  fftw_execute(static_cast<fftw_plan>(plan_));
  const auto lag = [this](int k) { return double(k <= samples_ / 2 ? k : k - samples_); };
  for (int row = 0; row < samples_; ++row)
    for (int column = 0; column < samples_; ++column) {
      const double place = 8 * std::hypot(lag(row), lag(column));
      double turn = std::atan2(lag(row), lag(column)) / kPi;  // of half a turn: the other half is the same
      turn = (turn - std::floor(turn)) * kShearDirections;
      const auto direction = std::size_t(turn) % kShearDirections;
      const auto along = [&](const std::vector<double>& factor) {
        const auto i = std::min(std::size_t(place), factor.size() - 2);
        return factor[i] + std::min(1.0, place - double(i)) * (factor[i + 1] - factor[i]);
      };
      const double here = along(factor_[direction]),
                   next = along(factor_[(direction + 1) % kShearDirections]);
      const double factor = here + (turn - std::floor(turn)) * (next - here);
      field_[std::size_t(row) * std::size_t(samples_) + std::size_t(column)] *= factor;
    }
  fftw_execute(static_cast<fftw_plan>(plan_));
  // Takes amplitudes again, at their places: the second transform turned the plane about its middle.
  for (std::size_t k = 0; k < all; ++k) field_[k] = std::sqrt(std::max(0.0, field_[k].real() / double(all)));
}

std::vector<double> IndependentWaves::shares(double dz, const std::vector<double>& radii) {
  std::fill_n(field_, std::size_t(samples_) * std::size_t(samples_), 0.0);
  const double defocus = 2 * kPi / wavelength_ * dz / (1 + dz / focal_length_);
  for (const Cell& cell : cells_)
    field_[std::size_t(cell.row) * std::size_t(samples_) + std::size_t(cell.column)] =
        std::polar(cell.amplitude, cell.phase + defocus * cell.versine);
  fftw_execute(static_cast<fftw_plan>(plan_));
  if (!factor_.empty()) apply_scatter();

  // Radii are in samples; planes further out have a larger image. The pattern, oversampled by two, is
  // interpolated along circles, and Gauss's rule sums the circles between the radii.
  const double per_sample = wavelength_ * (focal_length_ + dz) / (samples_ * pitch_);
  std::vector<std::size_t> order(radii.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return radii[a] < radii[b]; });
  std::vector<double> light(radii.size(), 0.0);
  double inside = 0, from = 0;
  for (const std::size_t k : order) {
    const double to = radii[k] / per_sample;
    const int parts = std::max(1, int(std::ceil((to - from) / kPartOfRadius)));
    for (int part = 0; part < parts; ++part) {
      const double low = from + (to - from) * part / parts, width = (to - from) / parts;
      for (std::size_t node = 0; node < 4; ++node) {
        const double r = low + 0.5 * width * (1 + kGaussNode[node]);
        inside += 0.5 * width * kGaussWeight[node] * 2 * kPi * r * on_circle(r);
      }
    }
    light[k] = inside;
    from = to;
  }
  const double all = total_ * double(samples_) * double(samples_);
  for (double& share : light) share /= all;
  return light;
}

}  // namespace aberfit
