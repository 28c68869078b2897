#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "aberfit/measured/height_map.h"
#include "aberfit/method/groundwork.h"
#include "aberfit/method/run_context.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/task.h"
#include "aberfit/scene/characterisation.h"

namespace aberfit {

/// The terms that a fit begins with.
struct CheckedTerms {
  Eigen::Index count = 0;
  double captured = 0;       ///< fraction of the specified height variance; 0 without roughness
  bool automatic = false;    ///< the study leaves them open
  int order = 0;             ///< highest n of the Zernikes; 0: there are none
  std::size_t segments = 0;  ///< number of segments whose errors are terms
};

/// The number of statistics of a fit.
struct CheckedStatistics {
  std::size_t fitted = 0, guides = 0, held_out = 0;
};

/// Grid points across the aperture for wave optics, at the start of a fit and at its judgement.
struct CheckedCells {
  double fit = 0, verdict = 0;
};

/// The cost of a fit, measured on its first iteration, or on the mean of up to five within a second. The
/// iterations start from a random surface on the first grid or rays of the fit and include all derivatives.
struct CheckedCost {
  Eigen::Index points = 0;     ///< grid points, or rays
  Eigen::Index residuals = 0;  ///< fitted statistics, guides and PSD bins
  double bytes = 0;            ///< peak memory of the process; estimated where no iteration was made
  std::optional<double> iteration_seconds;  ///< measured; absent: no iteration was made
  bool at_least = false;  ///< lower limit: only the first evaluation was made, because it took so long
  std::optional<double> verdict_seconds;  ///< time of one judgement on fresh points; absent: too long
  std::string obstacle;                   ///< why no iteration was made, a clause; empty where one was
};

/// The resolved numbers of a study's scene, the model that it needs and why, and the cost of a fit.
struct CheckReport {
  std::string title;  ///< title of the task, for people
  MirrorCharacterisation mirror;
  std::optional<SceneFacts> scene;       ///< absent without roughness
  double focal_sigma = 0;                ///< scale of the focal spot [m]
  std::string theory;                    ///< origin of the targets, as in SceneFacts
  FocusModel model = FocusModel::kRays;  ///< model of the surface
  std::string reason;                    ///< one sentence: which model the scene needs and why
  bool too_simple = false;               ///< theory or model is simpler than the scene needs
  bool light_decides = true;             ///< wave optics gives the verdict of `fit`
  CheckedTerms terms;
  CheckedStatistics statistics;
  bool automatic_rays = false;              ///< `rays` is the smallest number that the fit chooses
  std::int64_t rays = 0;                    ///< 0 for waves, whose grid follows from their targets
  std::optional<CheckedCells> cells;        ///< for waves; absent where no grid is fine enough
  std::optional<BandShares> shares;         ///< parts of a split roughness
  std::optional<TheoryError> theory_error;  ///< error of wave optics; absent without roughness or if unknown
  std::vector<Target> fitted, held_out;     ///< every judged statistic
  int starts = 1;                           ///< starts of the fit
  int threads = 1;                          ///< threads of the measured iteration
  std::optional<CheckedCost> cost;          ///< absent: not requested
  Warnings warnings;
};

/// The terms that a fit begins with: those named by the study, or the Zernikes that carry the band up to the
/// cut (order_to_carry), or the default ones where these are too many.
TermsSpec first_set(const Task& task, const Groundwork& ground);

/// The whole report except the paper's table. The study has statistics as targets, no map. measure: makes one
/// iteration of the fit, which takes about as long as two evaluations, unless memory is too small.
CheckReport make_check(const Task& task, const RunContext& context, bool measure);

/// The same for a study of a measured map.
struct MapCheckReport {
  std::string title;
  Eigen::Index columns = 0, rows = 0, valid = 0;  ///< points of the map
  double pitch_x = 0, pitch_y = 0;                ///< [m]
  Eigen::Index terms = 0;                         ///< fitted by least squares
  Warnings warnings;                              ///< warnings of the map
  std::optional<BandShares> shares;               ///< end of the terms, and scatter; absent without roughness
};
MapCheckReport make_map_check(const HeightMap& map, const TermSet& terms);

}  // namespace aberfit
