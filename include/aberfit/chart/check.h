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
#include "aberfit/theory/paper_table.h"

namespace aberfit {

/// The terms that a fit begins with.
struct CheckedTerms {
  Eigen::Index count = 0;
  double captured = 0;       ///< share of the height variance of what they stand for; 0 without roughness
  bool automatic = false;    ///< the study leaves them open
  int order = 0;             ///< the highest n of the Zernikes among them; 0: there are none
  std::size_t segments = 0;  ///< whose errors are among them
};

/// How many statistics a fit would have.
struct CheckedStatistics {
  std::size_t fitted = 0, guides = 0, held_out = 0;
};

/// Cells across the aperture of the grids for waves: where a fit begins, and where its surface is judged.
struct CheckedCells {
  double fit = 0, verdict = 0;
};

/// What a fit takes, as far as its first iterations tell, one or the mean of up to five within a second: from
/// a draw, on the grid or the rays that the fit begins with, all derivatives included.
struct CheckedCost {
  Eigen::Index points = 0;     ///< cells of the grid, or rays
  Eigen::Index residuals = 0;  ///< statistics fitted, guides and PSD bins
  double bytes = 0;  ///< memory of the process at its highest; where no iteration was made, estimated
  std::optional<double> iteration_seconds;  ///< measured; absent: no iteration was made
  bool at_least = false;  ///< the first evaluation took so long that it was left at that: no less than this
  std::optional<double> verdict_seconds;  ///< of one look on fresh points; absent: too long to make one
  std::string obstacle;                   ///< why no iteration was made, a clause; empty where one was
};

/// The resolved numbers of a study's scene, the model it needs and why, and what a fit takes.
struct CheckReport {
  std::string title;  ///< of the task, for people
  MirrorCharacterisation mirror;
  std::optional<SceneFacts> scene;       ///< absent without roughness
  double focal_sigma = 0;                ///< scale of the focal spot [m]
  std::string theory;                    ///< what targets come from, as in SceneFacts
  FocusModel model = FocusModel::kRays;  ///< of the surface
  std::string reason;                    ///< one sentence: which model the scene needs and why
  bool too_simple = false;               ///< theory or model is simpler than what the scene needs
  bool light_decides = true;             ///< the verdict of `fit` is light's
  CheckedTerms terms;
  CheckedStatistics statistics;
  bool automatic_rays = false;              ///< `rays` is the least that the fit will choose
  std::int64_t rays = 0;                    ///< nothing for waves, whose grid the light decides
  std::optional<CheckedCells> cells;        ///< of waves; absent where no grid is fine enough
  std::optional<BandShares> shares;         ///< of a split roughness
  std::optional<TheoryError> theory_error;  ///< of wave optics; absent without roughness or where it has none
  std::vector<Target> fitted, held_out;     ///< every statistic that the verdict is on
  int starts = 1;                           ///< of the fit
  int threads = 1;                          ///< that the iteration was made with
  std::optional<CheckedCost> cost;          ///< absent: not asked for
  Warnings warnings;
  std::optional<PaperCells> paper_table;
};

/// The terms that a fit begins with: those that the study names, else the Zernikes that carry the band up to
/// the cut (order_to_carry), or the default ones where these are too many.
TermsSpec first_set(const Task& task, const Groundwork& ground);

/// Everything but the paper's table. The study has statistics as targets, no map. measure: makes one
/// iteration of the fit, which takes about as long as two evaluations, and none where it needs more memory
/// than the machine has.
CheckReport make_check(const Task& task, const RunContext& context, bool measure);

/// The same of a study of a measured map: what is fitted.
struct MapCheckReport {
  std::string title;
  Eigen::Index columns = 0, rows = 0, valid = 0;  ///< points of the map
  double pitch_x = 0, pitch_y = 0;                ///< [m]
  Eigen::Index terms = 0;                         ///< fitted by least squares
  Warnings warnings;                              ///< of the map
  std::optional<BandShares> shares;               ///< beside a roughness: where the terms end, what scatters
};
MapCheckReport make_map_check(const HeightMap& map, const TermSet& terms);

}  // namespace aberfit
