#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "aberfit/core/constants.h"
#include "aberfit/core/errors.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/waves/diffraction_psf.h"
#include "aberfit/waves/transfer_image.h"
#include "diffraction_band.h"
#include "diffraction_plane.h"

namespace aberfit {
using namespace internal;

namespace {

using ComplexMatrix = Eigen::MatrixXcd;

// Smallest of three measurements, 256 cells across, windows of 33 to 1025 samples. Only the ratio matters.
constexpr double kSecondsPerProduct = 1.5e-9;  // one complex multiply-add of Eigen's matrix product
constexpr double kSecondsPerButterfly =
    2.8e-9;  // one point and octave of the transform, with filling and cropping

// Largest side of an image or of its transform: 4 GiB of complex samples.
constexpr double kMostSamples = 16384;

// The pupil field in plane dz, at the pupil points.
Eigen::ArrayXcd pupil_field(const DiffractionScene& scene, double dz) {
  return scene.base() * unit_phasors(scene.defocus(dz) * scene.versine());
}

// The field on all cells of the grid, columns by rows.
ComplexMatrix on_grid(const DiffractionScene& scene, const Eigen::ArrayXcd& field) {
  const CartesianGrid& grid = scene.grid();
  ComplexMatrix cells = ComplexMatrix::Zero(scene.columns(), scene.rows());
  for (Eigen::Index k = 0; k < scene.points(); ++k)
    cells(grid.column[std::size_t(k)], grid.row[std::size_t(k)]) += field[k];
  return cells;
}

Grid by_transform(const DiffractionScene& scene, const Eigen::ArrayXcd& field, int n, int parts,
                  Eigen::Index before, Eigen::Index samples) {
  const FieldLayout layout{scene.rows(), scene.columns()};
  AlignedArray pupil(layout.size());
  std::fill_n(pupil.data(), layout.size(), 0.0);
  for (Eigen::Index k = 0; k < scene.points(); ++k) {
    double* cell = pupil.data() + scene.places()[std::size_t(k)];
    cell[0] += field[k].real();
    cell[kLines] += field[k].imag();
  }
  return focal_intensity(layout, pupil.data(), n, parts, before, samples);
}

// step: phase per cell and sample, -2 pi pitch_pupil pitch/(lambda (f+dz)).
Grid by_matrix(const ComplexMatrix& field, double step, Eigen::Index before, Eigen::Index samples) {
  const auto phases = [&](Eigen::Index cells) {
    ComplexMatrix result(samples, cells);
    for (Eigen::Index i = 0; i < cells; ++i)
      for (Eigen::Index k = 0; k < samples; ++k)
        result(k, i) = std::polar(1.0, step * double(k - before) * double(i));
    return result;
  };
  const ComplexMatrix half = phases(field.rows()) * field;              // X by rows of cells
  const ComplexMatrix focal = half * phases(field.cols()).transpose();  // X by Y
  return focal.transpose().cwiseAbs2().array();
}

// Lag of index k in a periodic transform of n samples.
double lag_of(Eigen::Index k, Eigen::Index n) { return double(k <= n / 2 ? k : k - n); }

// Multiplies the lags (along x by along y) by H of the roughness that is not part of the heights. Each
// distinct length is evaluated once.
void scatter_lags(const DiffractionProblem& problem, ComplexMatrix* lags) {
  const Eigen::Index n = lags->rows();
  std::vector<double> squares;
  for (Eigen::Index a = 0; a <= n / 2; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) squares.push_back(double(a * a + b * b));
  std::sort(squares.begin(), squares.end());
  squares.erase(std::unique(squares.begin(), squares.end()), squares.end());
  const Eigen::ArrayXd lengths =
      Eigen::Map<const Eigen::ArrayXd>(squares.data(), Eigen::Index(squares.size())).sqrt();
  const Eigen::ArrayXd factor = problem.scatter->transfer(lengths * problem.pupil.pitch_x);
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b) {
      const double square = lag_of(a, n) * lag_of(a, n) + lag_of(b, n) * lag_of(b, n);
      const auto at = std::lower_bound(squares.begin(), squares.end(), square) - squares.begin();
      (*lags)(a, b) *= factor[at];
    }
}

// The transfer function at all lags, x by y, not normalised: amplitudes of grid points, multiplied in pairs.
ComplexMatrix transfer_lags(const DiffractionScene& scene, const Eigen::ArrayXcd& field) {
  const int n = fast_transform_size(2 * std::max(scene.rows(), scene.columns()));
  const Grid intensity = by_transform(scene, field, n, 1, 0, n);
  ComplexMatrix lags = intensity.matrix().transpose().cast<std::complex<double>>();
  fourier_transform(n, n, lags.data());
  lags /= double(n) * n;
  if (scene.problem().scatter) scatter_lags(scene.problem(), &lags);
  return lags;
}

// Values of the focal plane (rows = y) from lags along x by lags along y. kernel: positions by lags.
Grid from_lags(const ComplexMatrix& kernel, const ComplexMatrix& lags) {
  const ComplexMatrix half = kernel * lags;  // X by lags along y
  return (half * kernel.transpose()).transpose().real().array();
}

// Image with roughness that is not part of the heights, by a transform of the transfer function. step: 2 pi
// times the pitch of the image in periods of the PSF.
Grid scattered(const DiffractionScene& scene, const Eigen::ArrayXcd& field, double step, Eigen::Index before,
               Eigen::Index samples) {
  const ComplexMatrix lags = transfer_lags(scene, field);
  const Eigen::Index n = lags.rows();
  ComplexMatrix phases(samples, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < samples; ++k)
      phases(k, i) = std::polar(1.0, step * double(k - before) * lag_of(i, n));
  return from_lags(phases, lags);
}

void require_square_cells(const DiffractionPupil& pupil) {
  if (std::abs(pupil.pitch_x - pupil.pitch_y) > 1e-9 * pupil.pitch_x)
    throw ComputationError("an image of the PSF needs a pupil grid with square pixels");
}

void require_plane(const DiffractionScene& scene, double dz) {
  if (!scene.has_plane(dz)) throw ComputationError("the plane of the PSF lies behind the mirror");
}

// Integral of exp(2 pi i u m x) over each pixel's part of one period, |x| < 1/2u: pixels by lags m of a
// transform of n. u: periods per metre.
ComplexMatrix pixel_integrals(double half_width, int pixels, double u, Eigen::Index n) {
  ComplexMatrix integral(pixels, n);
  const auto edge = [&](int k) { return std::clamp(half_width * (2.0 * k / pixels - 1), -0.5 / u, 0.5 / u); };
  for (Eigen::Index i = 0; i < n; ++i) {
    const double turn = 2 * kPi * u * lag_of(i, n);
    for (int k = 0; k < pixels; ++k) {
      const double length = edge(k + 1) - edge(k), half_turn = 0.5 * turn * length;
      const double middle = 0.5 * (edge(k) + edge(k + 1));
      const double within = turn == 0 || length == 0 ? length : length * std::sin(half_turn) / half_turn;
      integral(k, i) = within * std::polar(1.0, turn * middle);
    }
  }
  return integral;
}

}  // namespace

Eigen::ArrayXXd diffraction_pixels(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   double half_width, int pixels) {
  require_square_cells(problem.pupil);
  if (problem.wavelength.is_band()) {
    Eigen::ArrayXXd sum = Eigen::ArrayXXd::Zero(pixels, pixels);
    const std::vector<LightLine>& lines = problem.wavelength.lines();
    for (std::size_t k = 0; k < lines.size(); ++k)
      sum += lines[k].share * diffraction_pixels(at_line(problem, k), height, dz, half_width, pixels);
    return sum;
  }
  const DiffractionScene scene(problem, height, 1);
  require_plane(scene, dz);
  const ComplexMatrix lags = transfer_lags(scene, pupil_field(scene, dz));
  const double u = scene.per_period(dz);
  return from_lags(pixel_integrals(half_width, pixels, u, lags.rows()), lags) * (u * u / scene.total());
}

PsfImage diffraction_psf(const DiffractionProblem& problem, const Eigen::ArrayXd& height,
                         const PsfWindow& window) {
  const DiffractionPupil& pupil = problem.pupil;
  require_square_cells(pupil);
  const DiffractionScene scene(problem, height, 1);
  require_plane(scene, window.dz);
  const int cells = std::max(scene.rows(), scene.columns());
  const double field_of_view = 2 * scene.field_radius(window.dz);
  const double wanted = window.pitch > 0 ? window.pitch : 0.25 * field_of_view / cells;
  const double transform_samples = std::max(double(cells), std::ceil(field_of_view / wanted * (1 - 1e-12)));
  const bool transform_fits = transform_samples <= kMostSamples;
  // The number of part transforms of the pupil's size is the number of samples per cell.
  const int parts = transform_fits ? std::max(1, int(transform_samples / cells)) : 1;
  const int part_size =
      transform_fits ? fast_transform_size(std::max(cells, int(std::ceil(transform_samples / parts)))) : 0;
  const int m = parts * part_size;
  const double transform_pitch = field_of_view / (transform_fits ? double(m) : transform_samples);
  const bool whole = !(window.half_width > 0) || window.half_width >= 0.5 * field_of_view - transform_pitch;
  const double matrix_samples = 2 * std::floor(window.half_width / wanted) + 1;
  if (whole ? !transform_fits : !(matrix_samples <= kMostSamples))
    throw ComputationError(
        fmt::format("an image of the PSF with a pitch of {} m has {:.0f} samples per side, more than {:.0f}; "
                    "take a coarser pitch or a narrower window",
                    wanted, whole ? transform_samples : matrix_samples, kMostSamples));
  PsfImage image;
  image.dz = window.dz;
  Eigen::Index before = m / 2, samples = m;
  image.pitch = transform_pitch;
  if (!whole) {
    const double by_products = kSecondsPerProduct * matrix_samples * cells * (cells + matrix_samples);
    const double by_butterflies = kSecondsPerButterfly * double(m) * m * 2 * std::log2(double(m));
    if (!transform_fits || by_products < by_butterflies) {
      image.method = PsfImage::Method::kMatrix;
      image.pitch = wanted;
    }
    before = Eigen::Index(std::floor(window.half_width / image.pitch * (1 + 1e-12)));
    samples = 2 * before + 1;
  }
  const Eigen::ArrayXcd field = pupil_field(scene, window.dz);
  const double per_metre = scene.per_period(window.dz);  // periods of the PSF
  if (problem.scatter) {
    image.intensity = scattered(scene, field, 2 * kPi * image.pitch * per_metre, before, samples);
  } else
    image.intensity =
        image.method == PsfImage::Method::kMatrix
            ? by_matrix(on_grid(scene, field), -2 * kPi * image.pitch * per_metre, before, samples)
            : by_transform(scene, field, part_size, parts, before, samples);
  image.intensity *= per_metre * per_metre / scene.total();
  image.first = -double(before) * image.pitch;
  return image;
}

TransferImage diffraction_transfer(const DiffractionProblem& problem, const Eigen::ArrayXd& height, double dz,
                                   int most_lags) {
  require_square_cells(problem.pupil);
  const DiffractionScene scene(problem, height, 1);
  require_plane(scene, dz);
  const ComplexMatrix lags = transfer_lags(scene, pupil_field(scene, dz));
  const Eigen::Index n = lags.rows(), last = std::max(scene.rows(), scene.columns()) - 1;
  const Eigen::Index stride = std::max<Eigen::Index>(1, (last + most_lags - 1) / most_lags);
  TransferImage image;
  image.middle = last / stride;
  image.step = double(stride) * scene.per_period(dz);
  const Eigen::Index side = 2 * image.middle + 1;
  image.value.resize(side, side);
  const auto at = [&](Eigen::Index k) { return ((k - image.middle) * stride + n) % n; };
  for (Eigen::Index column = 0; column < side; ++column)
    for (Eigen::Index row = 0; row < side; ++row)
      image.value(row, column) = lags(at(column), at(row)) / scene.total();
  // Sums of squares miss energy beyond the field of view, but OTF(0) refers to the total energy.
  image.value(image.middle, image.middle) = 1;
  return image;
}

}  // namespace aberfit
