#include <algorithm>
#include <cmath>

#include "aberfit/forward/focus_transfer.h"
#include "aberfit/report/focal_light.h"
#include "aberfit/theory/scattered_rays.h"
#include "aberfit/waves/diffraction_psf.h"
#include "round_image.h"

namespace aberfit {
using namespace internal;

namespace {

// Statistics come from the code of the fit; only the image is made here.
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
  // Planes that the pupil grid does not resolve must not spoil the others.
  Eigen::ArrayXd ring_through(double radius, const Eigen::ArrayXd& planes) const override {
    const bool seen_anywhere = path_.scatter || radius <= 0.5 * field_of_view(planes.maxCoeff());
    if (!seen_anywhere) return Eigen::ArrayXd::Constant(planes.size(), std::nan(""));
    Eigen::ArrayXd share = through(radius, planes);
    const std::vector<Eigen::Index> seen = seen_of(share, radius, planes);
    if (seen.empty()) return share;
    if (Eigen::Index(seen.size()) == planes.size()) return share;
    share.setConstant(std::nan(""));
    share(seen) = ring_through(radius, planes(seen));
    return share;
  }
  Eigen::ArrayXXd image(double dz, double half_width, int pixels) const override {
    Eigen::ArrayXXd periodic = focus_pixels(path_, coefficients_, dz, half_width, pixels);
    if (!path_.scatter) return periodic;
    const RoundSpot mean = [&](double radius) -> MeanScatter::Encircled {
      if (const auto known = path_.scatter->in_plane(radius, dz)) return *known;
      // Elsewhere the spot of the focus grows with the distance from the mirror.
      const double growth = 1 + dz / path_.mirror.focal_length;
      return {path_.scatter->encircled_energy(radius / growth),
              path_.scatter->encircled_energy_slope(radius / growth) / growth};
    };
    const double detail =
        path_.wavelength * (path_.mirror.focal_length + dz) / (2 * aperture_radius(*path_.aperture));
    return unfolded(periodic, mean, detail, field_of_view(dz), half_width);
  }
  double farthest_plane() const override {
    // Here the cone may fill the field of view. farthest_plane allows it half of that, so we double the
    // points.
    const double filled = 2 * 2 * aperture_radius(*path_.aperture) / pitch();
    return aberfit::farthest_plane(*path_.aperture, path_.mirror.focal_length, path_.wavelength, int(filled));
  }
  std::optional<TransferImage> transfer() const override {
    constexpr int kMostLags = 512;
    return focus_transfer(path_, coefficients_, 0.0, kMostLags);
  }

 private:
  double pitch() const {
    const auto* directions = std::get_if<DirectionGrid>(&path_.pupil.structure);
    const Eigen::ArrayXd& x =
        directions ? directions->cells.x : std::get<CartesianGrid>(path_.pupil.structure).x;
    return (x[x.size() - 1] - x[0]) / double(x.size() - 1);
  }
  double field_of_view(double dz) const {
    return path_.wavelength * (path_.mirror.focal_length + dz) / pitch();
  }
  Eigen::ArrayXd through(double radius, const Eigen::ArrayXd& planes) const {
    std::vector<Statistic> wanted;
    for (const double dz : planes) wanted.push_back(RingThrough{radius, dz});
    return values(wanted);
  }
  // Indices of the planes that the pupil grid resolves. One unresolved plane may make all values NaN. Then a
  // bisection over |dz| finds the nearest such plane.
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
