#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "aberfit/chart/cost_model.h"
#include "aberfit/measured/height_map.h"
#include "aberfit/method/scene_facts.h"
#include "aberfit/method/term_search.h"
#include "aberfit/scene/characterisation.h"
#include "aberfit/theory/paper_table.h"

namespace aberfit {

/// The terms that a fit would take.
struct CheckedTerms {
  Eigen::Index count = 0;  ///< named by the study; of a search: the default that all but a fit takes
  double captured = 0;     ///< share of the specification's height variance; 0 without roughness
  std::optional<OrderRange> expected;  ///< where a search is expected to end; absent: the study names them
};

/// How many statistics a fit would have.
struct CheckedStatistics {
  std::size_t fitted = 0, guides = 0, held_out = 0;
};

/// Cells across the aperture of the grids for waves: where a fit begins, and where its surface is judged.
struct CheckedCells {
  double fit = 0, verdict = 0;
};

/// The same fit with every frequency of the roughness as a term (`"band": "all"`).
struct CheckedWholeBand {
  std::optional<double> seconds;  ///< predicted; nothing where no grid is fine enough
};

/// The resolved numbers of a study's scene, the model it needs and why, and what a fit will take.
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
  std::optional<CheckedWholeBand> whole;    ///< what the split saves
  std::string remedy;                       ///< what brings a prediction above a minute down; else empty
  std::optional<TheoryError> theory_error;  ///< of wave optics; absent without roughness or where it has none
  std::vector<Target> fitted, held_out;     ///< every statistic that the verdict is on
  int starts = 1;                           ///< of the fit
  int threads = 1;                          ///< that the prediction is for
  std::string rates;                        ///< where the rates of the prediction come from, a clause
  std::optional<FitPrediction> prediction;
  std::string unpredicted;  ///< why there is no prediction; empty where there is one
  Warnings warnings;
  std::optional<PaperCells> paper_table;
};

/// Everything but the paper's table. The study has statistics as targets, no map. Computes no fit.
CheckReport make_check(const Task& task, const FitRates& rates, int threads);

/// The same of a study of a measured map: what is fitted, and what that takes.
struct MapCheckReport {
  std::string title;
  Eigen::Index columns = 0, rows = 0, valid = 0;  ///< points of the map
  double pitch_x = 0, pitch_y = 0;                ///< [m]
  Eigen::Index terms = 0;                         ///< fitted by least squares
  double seconds = 0;                             ///< predicted time of the fit [s]
  int threads = 1;                                ///< that the prediction is for
  Warnings warnings;                              ///< of the map
  std::optional<BandShares> shares;               ///< beside a roughness: where the terms end, what scatters
};
MapCheckReport make_map_check(const HeightMap& map, const TermSet& terms, int threads);

}  // namespace aberfit
