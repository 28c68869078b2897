#include <algorithm>
#include <cmath>

#include "aberfit/forward/focus_transfer.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/theory/scattered_rays.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit {
namespace {

// Common length of every pixel (rows) with every sample of a line (columns), both of even spacing [m].
Eigen::MatrixXd overlap(double half_width, int pixels, double first, double pitch, Eigen::Index samples) {
  const double pixel = 2 * half_width / pixels;
  Eigen::MatrixXd length = Eigen::MatrixXd::Zero(pixels, samples);
  for (Eigen::Index s = 0; s < samples; ++s) {
    const double left = first + (double(s) - 0.5) * pitch, right = left + pitch;
    const int from = std::max(0, int(std::floor((left + half_width) / pixel)));
    const int to = std::min(pixels - 1, int(std::floor((right + half_width) / pixel)));
    for (int p = from; p <= to; ++p) {
      const double begin = p * pixel - half_width;
      length(p, s) = std::max(0.0, std::min(right, begin + pixel) - std::max(left, begin));
    }
  }
  return length;
}

// Statistics by the code that fits; what is made here is the image.
class WaveLight : public FocalLight {
 public:
  WaveLight(const LightPath& path, Eigen::VectorXd coefficients, int threads)
      : path_(path), coefficients_(std::move(coefficients)), threads_(threads) {}

  double statistic(const Statistic& wanted) const override { return values({wanted})[0]; }
  Eigen::ArrayXd encircled_energy(const Eigen::ArrayXd& radii, double dz) const override {
    std::vector<Statistic> wanted;
    for (const double radius : radii) wanted.push_back(RingThrough{radius, dz});
    Eigen::ArrayXd share = values(wanted);
    for (Eigen::Index k = 0; k < share.size(); ++k)
      if (radii[k] == 0) share[k] = 0;
    return share;
  }
  // Planes that the cells do not see leave the others their light. Of more planes than have mean spots of
  // their own beyond the cells: what those change, from one in ten on.
  Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
    constexpr Eigen::Index kApart = 10;
    Eigen::ArrayXd share = through(radius, planes);
    const std::vector<Eigen::Index> seen = seen_of(share, radius, planes);
    if (seen.empty()) return share;
    if (Eigen::Index(seen.size()) < planes.size()) {
      share.setConstant(std::nan(""));
      share(seen) = ring_through(radius, planes(seen));
      return share;
    }
    const Eigen::Index last = planes.size() - 1;
    if (!path_.scatter || planes.size() <= Eigen::Index(kMostPlanesOfTheirOwn)) return share;
    std::vector<Eigen::Index> at;
    for (Eigen::Index k = 0; k < last; k += kApart) at.push_back(k);
    at.push_back(last);
    const Eigen::ArrayXd change = through(radius, planes(at)) - share(at);
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
      const double from = planes[at[i]], to = planes[at[i + 1]];
      const Eigen::Index whole = Eigen::Index(i);
      for (Eigen::Index k = at[i] + (i > 0); k <= at[i + 1]; ++k) {
        // A halo widens with the square of the defocus; across the focus the change is next to nothing.
        const double part = from * to < 0
                                ? (planes[k] - from) / (to - from)
                                : (planes[k] - from) * (planes[k] + from) / ((to - from) * (to + from));
        share[k] += change[whole] + part * (change[whole + 1] - change[whole]);
      }
    }
    return share;
  }
  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    constexpr double kSamplesPerPixel = 2;
    const double pixel = 2 * half_width / pixels;
    PsfWindow window;
    window.half_width = half_width + pixel;
    // Speckles are as wide as the pattern of the aperture: they are averaged over a pixel, not picked.
    const double speckle =
        path_.wavelength * (path_.mirror.focal_length + dz) / (2 * aperture_radius(*path_.aperture));
    window.pitch = std::min(pixel / kSamplesPerPixel, speckle / 4);
    window.dz = dz;
    const PsfImage psf = focus_psf(path_, coefficients_, window);
    const Eigen::MatrixXd x = overlap(half_width, pixels, psf.first, psf.pitch, psf.intensity.cols());
    const Eigen::MatrixXd y = overlap(half_width, pixels, psf.first, psf.pitch, psf.intensity.rows());
    return (y * psf.intensity.matrix() * x.transpose()).array();
  }
  std::optional<TransferImage> transfer() const override {
    constexpr int kMostLags = 512;
    return focus_transfer(path_, coefficients_, 0.0, kMostLags);
  }

 private:
  Eigen::ArrayXd through(double radius, const Eigen::ArrayXd& planes) const {
    std::vector<Statistic> wanted;
    for (const double dz : planes) wanted.push_back(RingThrough{radius, dz});
    return values(wanted);
  }
  // Places of planes that have light. One whose phases the cells cannot follow takes it from all of them:
  // where none has any, the farthest that has tells which do.
  std::vector<Eigen::Index> seen_of(const Eigen::ArrayXd& share, double radius,
                                    const Eigen::ArrayXd& planes) const {
    double end = HUGE_VAL;
    if (!share.isFinite().any()) {
      std::vector<double> reach;
      for (const double dz : planes) reach.push_back(std::abs(dz));
      std::sort(reach.begin(), reach.end());
      const auto unseen = std::partition_point(reach.begin(), reach.end(), [&](double dz) {
        return through(radius, Eigen::Array2d(-dz, dz)).isFinite().all();
      });
      if (unseen != reach.end()) end = *unseen;
    }
    std::vector<Eigen::Index> seen;
    for (Eigen::Index k = 0; k < planes.size(); ++k)
      if (end < HUGE_VAL ? std::abs(planes[k]) < end : std::isfinite(share[k])) seen.push_back(k);
    return seen;
  }
  Eigen::ArrayXd values(const std::vector<Statistic>& wanted) const {
    return focus_statistics(path_, coefficients_, wanted, threads_, nullptr);
  }

  LightPath path_;
  Eigen::VectorXd coefficients_;
  int threads_;
};

}  // namespace

std::unique_ptr<FocalLight> surface_light(const LightPath& path, const Eigen::VectorXd& coefficients,
                                          int threads) {
  if (path.model == FocusModel::kWaves) return std::make_unique<WaveLight>(path, coefficients, threads);
  SurfaceField field;
  path.surface.apply(coefficients, &field);
  if (path.scatter) add_scatter(*path.scatter, path.pupil, kScatterSeed, &field);
  return ray_light(trace(path.mirror, path.pupil, field), trace_nominal(path.mirror, path.pupil),
                   path.centre);
}

}  // namespace aberfit
