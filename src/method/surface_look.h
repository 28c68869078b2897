#pragma once
#include <cstdint>
#include <vector>

#include "aberfit/measured/height_map.h"
#include "aberfit/method/constants.h"
#include "aberfit/method/task.h"
#include "aberfit/roughness/fourier_transform.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/waves/diffraction_psf.h"

namespace aberfit::internal {

/// Properties of one surface; NaN where a zone has no grid cells or no image was requested.
struct LookedAt {
  Eigen::ArrayXd psd;    ///< per bin [m^4]
  Eigen::ArrayXd zones;  ///< law::kSlopeZones: RMS slope over that of the aperture
  double slope_x_over_y = 0;
  double length_over_width = 0, bright_share = 0;
};

/// The estimators of `Character` on one grid of square cells of the mirror, the same for every surface. They
/// are paraxial: images err alike in scale by 1/(32 N^2), N the f-number. Safe for many threads.
class SurfaceLook {
 public:
  /// edges: of the bins [cycles/m], ascending; none or at least two. pitch [m].
  SurfaceLook(const Task& task, Eigen::ArrayXd edges, double pitch, bool with_image);

  const PupilSample& points() const { return pupil_.sample; }
  /// A random surface of `psd` over the aperture and map_margin points beyond, for interpolation.
  HeightMap draw(const RadialPsd& psd, std::uint64_t seed) const;
  /// Heights of such a map at `points`.
  Eigen::ArrayXd at_points(const HeightMap& map) const;
  /// height: at `points` [m].
  LookedAt operator()(Eigen::ArrayXd height) const;

 private:
  static constexpr Eigen::Index map_margin = 4;
  struct Step {
    Eigen::Index from, to;  // neighbouring points
    int zone;
    bool along_x;
  };
  void find_steps(const Aperture& aperture);
  void find_bins(const Eigen::ArrayXd& edges);
  void find_rings();
  void level(Eigen::ArrayXd* height) const;
  void look_at_slopes(const Eigen::ArrayXd& height, LookedAt* looked) const;
  void look_at_psd(const Eigen::ArrayXd& height, LookedAt* looked) const;
  void look_at_image(const Eigen::ArrayXd& height, LookedAt* looked) const;
  Eigen::Index place(Eigen::Index point) const;  // index in a transform
  double signed_index(Eigen::Index k) const { return double(2 * k < size_ ? k : k - size_); }

  DiffractionPupil pupil_;
  double pitch_, phase_per_height_;
  bool with_image_;
  Eigen::Index size_;  // side of the transform
  FourierTransform transform_;
  Eigen::ArrayXd window_, departure_;
  std::vector<Step> steps_;
  Eigen::Index bins_ = 0;
  std::vector<std::int16_t> bin_of_;    // bin of each ordinate of the transform; -1: none
  std::vector<std::uint16_t> ring_of_;  // ring of each pixel of an image, half a pixel wide
};

}  // namespace aberfit::internal
