// This file describes the results of "check", a study before its fit, and "trace", a given surface.
#include "aberfit/method/constants.h"
#include "facts.h"
#include "statistic_label.h"

namespace aberfit::internal {

static void describe(Facts& facts, const CheckedTerms& terms) {
  facts("count", terms.count, "Number of terms that the fit begins with.");
  facts("captured_fraction", terms.captured, "Fraction of the height variance that they can carry.");
  facts("automatic", terms.automatic, "Whether the program chooses the terms.");
  facts("n_max", terms.order > 0 ? std::optional(terms.order) : std::nullopt,
        "Largest n of the Zernikes; null without them.");
  facts.where(terms.segments > 0, "segments", terms.segments, "Segments whose errors are among the terms.");
}

static void describe(Facts& facts, const TheoryError& error) {
  facts("paraxial", error.paraxial, "Relative error of radii in the paraxial form, 1/(32 N^2).");
  facts("small_angle", error.small_angle, "Relative error of ee90 by taking sines for tangents.");
  facts("beyond_ten_degrees", error.beyond_ten_degrees,
        "Fraction of the energy scattered beyond 10 degrees.");
  facts("cut_share", error.cut_share,
        "Fraction of the height variance above 1/lambda, which does not scatter.");
}

static void describe(Facts& facts, const CheckedCells& cells) {
  facts("fit", cells.fit, "Grid points across the aperture at the start of the fit.");
  facts("verdict", cells.verdict, "Grid points across the aperture where the surface is judged.");
}

static void describe(Facts& facts, const MirrorCharacterisation& mirror) {
  facts("f_number", mirror.f_number, "Focal length over the largest extent of the aperture.");
  facts("rim_sag_m", mirror.rim_sag_max, "Height of the rim above the vertex.");
  facts("rim_plane_residual_m", mirror.plane_residual,
        "Standard deviation of the rim's distance from its best-fit plane.");
}

namespace {

struct Checked {
  Target target;
  bool held_out = false;
};

void describe(Facts& facts, const Checked& checked) {
  describe(facts, checked.target);
  facts("held_out", checked.held_out, "Whether it is only judged, not fitted.");
}

struct CheckedScene {
  SceneFacts scene;
  double rays_ee90 = 0, focal_sigma = 0;
};

void describe(Facts& facts, const CheckedScene& checked) {
  describe(facts, checked.scene);
  facts("rays_ee90_radius_m", checked.rays_ee90, "The ee90 radius by geometric rays.");
  facts("focal_sigma_m", checked.focal_sigma, "Scale of the focal spot.");
}

struct Cost {
  CheckedCost of;
  int threads = 1;
};

void describe(Facts& facts, const Cost& cost) {
  const CheckedCost& of = cost.of;
  using Seconds = std::optional<double>;
  const auto seconds = [&](int count) {
    return of.iteration_seconds ? Seconds(count * *of.iteration_seconds) : Seconds();
  };
  facts("pupil_points", of.points,
        "Number of rays (by wave optics: of grid points) at the start of the fit.");
  facts("residuals", of.residuals, "Number of residuals: statistics, guides and PSD bins.");
  facts("bytes", of.bytes, "Largest memory of the process; estimated where no iteration was made.");
  facts("threads", cost.threads, "Number of threads of that iteration.");
  facts("iteration_seconds", of.iteration_seconds, "Time of one iteration; null where none was made.");
  facts("at_least", of.at_least, "Whether the iteration was stopped early, so that a full one takes longer.");
  facts("iterations", std::array{law::kFewIterations, law::kManyIterations},
        "Usual range of the number of iterations.");
  facts("iterations_seconds", std::array{seconds(law::kFewIterations), seconds(law::kManyIterations)},
        "Time of that many iterations.");
  facts("verdict_seconds", of.verdict_seconds,
        "Time of one judgement on fresh points; null: more than 10 s.");
  facts("obstacle", of.obstacle.empty() ? std::nullopt : std::optional(of.obstacle),
        "Why no iteration was made; null where one was.");
}

}  // namespace

void describe(Facts& facts, const CheckReport& report) {
  std::vector<Target> all = report.fitted;
  all.insert(all.end(), report.held_out.begin(), report.held_out.end());
  std::vector<Checked> targets;
  for (const Target& target : all) targets.push_back({target, targets.size() >= report.fitted.size()});
  const bool scene = report.scene.has_value(), split = report.shares.has_value();
  facts("mirror", report.mirror, "The mirror's shape.");
  facts.where(scene, "scene",
              scene ? CheckedScene{*report.scene, report.scene->errors->rays.ee90, report.focal_sigma}
                    : CheckedScene(),
              "The specification, and the models that it needs.");
  facts.if_any("theory_error", report.theory_error, "What the wave theory itself leaves out.");
  facts.keyed("target", unique_names(all), targets, "Target of each statistic, by its name.");
  facts.if_any("cells_across", report.cells, "Pupil grids of wave optics.");
  facts("terms", report.terms, "The terms that the fit begins with.");
  facts.where(split, "split", SplitFacts{report.shares.value_or(BandShares()), {}, {}},
              "How the roughness is divided between terms and scatter.");
  facts.where(report.cost.has_value(), "cost", Cost{report.cost.value_or(CheckedCost()), report.threads},
              "What one iteration of the fit takes.");
  facts("warnings", report.warnings, "Warnings that the reader should know.");
}

void describe(Facts& facts, const MapCheckReport& report) {
  const bool square = report.pitch_x == report.pitch_y;
  facts.object("map", "The measured map.", [&](Facts& map) {
    map("columns", report.columns, "Number of its columns.");
    map("rows", report.rows, "Number of its rows.");
    map("valid", report.valid, "Number of points that have a height.");
    map("pitch_m", square ? std::optional(report.pitch_x) : std::nullopt,
        "Distance of its points; null where it differs along x and y.");
    map("pitch_x_m", report.pitch_x, "Distance of its columns.");
    map("pitch_y_m", report.pitch_y, "Distance of its rows.");
  });
  facts.object("terms", "The terms that are fitted to it.",
               [&](Facts& terms) { terms("count", report.terms, "Number of terms."); });
  facts.where(report.shares.has_value(), "split", SplitFacts{report.shares.value_or(BandShares()), {}, {}},
              "How the roughness is divided between terms and scatter.");
  facts("warnings", report.warnings, "Warnings that the reader should know.");
}

void describe(Facts& facts, const TraceReport& report) {
  NamedNumbers values, targets;
  values.values.resize(Eigen::Index(report.statistics.size()));
  targets.values.resize(values.values.size());
  for (const TracedStatistic& traced : report.statistics) {
    const Eigen::Index k = Eigen::Index(values.names.size());
    values.names.push_back(statistic_name(traced.statistic));
    values.values[k] = traced.value;
    targets.values[k] = traced.target;
  }
  targets.names = values.names;
  facts("theory", report.theory, "Theory that the targets come from.");
  facts("model", report.model, "How statistics were computed from the surface: waves or rays.");
  facts("reason", report.reason, "Which model the scene needs, and why.");
  facts("pupil_points", report.rays, "Number of rays (by wave optics: of grid points).");
  facts("lost_rays", report.lost_rays, "Rays that do not reach the focus.");
  facts("terms", report.terms, "Number of terms of the surface.");
  facts("statistics", values, "Statistics of the surface.");
  facts("target", targets, "Targets that a fit of the same study would have.");
  facts("warnings", report.warnings, "Warnings that the reader should know.");
}

}  // namespace aberfit::internal
