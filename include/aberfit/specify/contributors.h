#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/task.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/specify/solve.h"

// What else blurs the light of a telescope beside the roughness of the mirror that a study describes:
// transfer functions multiply, so structure functions add, and each contributor is a surface more in the
// pupil.
namespace aberfit {

/// Another mirror of the path.
struct OtherSurface {
  std::string name;
  PsdModel psd;               ///< of its height
  double footprint = 1;       ///< diameter of the beam, across its own axis, over that of the pupil, > 0
  double incidence = 0;       ///< angle of incidence [rad], in [0, pi/2): the path changes by 2 h cos(angle)
  bool is_wavefront = false;  ///< `psd` is that of the reflected wavefront
};

/// Long exposure through turbulence: phase structure function 6.88 (x/r0)^(5/3) at `wavelength`, the path
/// the same at all wavelengths (Kolmogorov; Fried 1966), without inner scale.
struct Atmosphere {
  double r0 = 0;           ///< [m], > 0
  double wavelength = 0;   ///< that r0 belongs to [m]
  double outer_scale = 0;  ///< L0 of von Karman's spectrum (f^2 + 1/L0^2)^(-11/6) [m]; 0: none
};

struct Contributors {
  std::vector<OtherSurface> surfaces;
  std::optional<Atmosphere> atmosphere;
  double jitter = 0;  ///< RMS motion of the image, per axis on the sky [rad]

  bool empty() const { return surfaces.empty() && !atmosphere && jitter == 0; }
};

/// The surface in the pupil that does to the mean light what the contributor does: frequencies on a beam of a
/// smaller footprint are as much lower in the pupil, heights count cos(incidence) times, a wavefront half.
/// Along the plane of incidence the beam meets 1/cos(incidence) times as much of the surface, whose
/// frequencies are as much higher in the pupil; the PSD is the mean over directions of what the beam then
/// sees. Exact for stationary roughness at small angles of the beam and normal incidence; of inclined beams
/// the mean of exp(-D) over directions is taken for exp of the mean, which makes circles of 50 to 90 % of the
/// light too large by up to 0.25 % at 4 pi sigma cos(incidence)/lambda = 0.7 and 60 degrees, 1 % at 1.
PsdModel in_pupil(const OtherSurface& surface);
/// S = (lambda/4 pi)^2 0.02290 r0^(-5/3) (f^2 + 1/L0^2)^(-11/6), up to 1e4/r0; without L0 its height variance
/// is infinite.
PsdModel in_pupil(const Atmosphere& atmosphere);
/// Motion of `jitter` [rad] as a surface so long that it only tilts the pupil, `across` [m] wide: error of
/// its exponent 5e-5 of it at most.
PsdModel in_pupil_of_jitter(double jitter, double across);

/// The roughness of `own` with all contributors, by name; the first is "mirror", `own` itself.
std::vector<std::pair<std::string, PsdModel>> pupil_surfaces(const PsdModel& own, const Contributors& others,
                                                             double across);

/// The task with `others` in its PSD, whose theory has to be `ghs`. Throws FieldError for budgets of a
/// surface's own moments, which a whole path does not have.
TaskAt with_contributors(const TaskAt& own, const Contributors& others, const std::vector<Budget>& budgets);
/// At one place of the unknowns.
std::vector<BudgetUse> uses_of_budget(const Task& own, const Contributors& others,
                                      const std::vector<Budget>& budgets, int threads);

}  // namespace aberfit
