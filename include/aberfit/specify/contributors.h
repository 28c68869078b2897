#pragma once
#include <optional>
#include <string>
#include <vector>

#include "aberfit/method/task.h"
#include "aberfit/roughness/psd.h"
#include "aberfit/specify/solve.h"

// Contributors to the blur of a telescope other than the roughness of the studied mirror. Transfer functions
// multiply and structure functions add, so that each contributor acts as one more surface in the pupil.
namespace aberfit {

/// Another mirror in the beam path.
struct OtherSurface {
  std::string name;
  PsdModel psd;          ///< PSD of its height
  double footprint = 1;  ///< diameter of the beam, perpendicular to its axis, over that of the pupil, > 0
  double incidence = 0;  ///< angle of incidence [rad], in [0, pi/2); the path changes by 2 h cos(angle)
  bool is_wavefront = false;  ///< true: `psd` is that of the reflected wavefront
};

/// Long exposure through turbulence: phase structure function 6.88 (x/r0)^(5/3) at `wavelength`, with the
/// same path difference at all wavelengths (Kolmogorov; Fried 1966) and no inner scale.
struct Atmosphere {
  double r0 = 0;           ///< [m], > 0
  double wavelength = 0;   ///< wavelength of r0 [m]
  double outer_scale = 0;  ///< L0 of von Karman's spectrum (f^2 + 1/L0^2)^(-11/6) [m]; 0: none
};

struct Contributors {
  std::vector<OtherSurface> surfaces;
  std::optional<Atmosphere> atmosphere;
  double jitter = 0;  ///< RMS image motion, per axis on the sky [rad]

  bool empty() const { return surfaces.empty() && !atmosphere && jitter == 0; }
};

/// Returns the surface in the pupil with the same effect on the mean irradiance. A smaller footprint lowers
/// the frequencies in the pupil, heights are multiplied by cos(incidence), and a wavefront is halved. Along
/// the plane of incidence, frequencies are higher in the pupil by 1/cos(incidence); the PSD is averaged over
/// directions.
/// Exact for stationary roughness at small beam angles and normal incidence. For inclined beams, exp of the
/// mean replaces the mean of exp(-D) over directions. This makes circles of 50 to 90 % encircled energy too
/// large by up to 0.25 % at 4 pi sigma cos(incidence)/lambda = 0.7 and 60 degrees, 1 % at 1.
PsdModel in_pupil(const OtherSurface& surface);
/// S = (lambda/4 pi)^2 0.02290 r0^(-5/3) (f^2 + 1/L0^2)^(-11/6), up to 1e4/r0; infinite variance without L0.
PsdModel in_pupil(const Atmosphere& atmosphere);
/// Represents image motion of `jitter` [rad] by a surface with so long a correlation that it only tilts the
/// pupil, `across` [m] wide. Relative error of the exponent: at most 5e-5.
PsdModel in_pupil_of_jitter(double jitter, double across);

/// Returns the roughness of `own` and all contributors with their names; the first is "mirror", `own` itself.
std::vector<std::pair<std::string, PsdModel>> pupil_surfaces(const PsdModel& own, const Contributors& others,
                                                             double across);

/// Returns the task with `others` in its PSD; its theory must be `ghs`. Throws FieldError for budgets of the
/// moments of the surface, which are not defined for a whole path.
TaskAt with_contributors(const TaskAt& own, const Contributors& others, const std::vector<Budget>& budgets);
/// Returns the contributions to each budget at one set of unknowns.
std::vector<BudgetUse> uses_of_budget(const Task& own, const Contributors& others,
                                      const std::vector<Budget>& budgets, int threads);

}  // namespace aberfit
