// This file describes the results of `solve`: kinds "solve", "ceilings" and "psd-of-focus".
#include <cmath>

#include "aberfit/core/constants.h"
#include "facts.h"

namespace aberfit::internal {

static void describe(Facts& facts, const RangeEnd& end) {
  facts("value", end.value, "Last value that could be computed.");
  facts("why", end.why, "Reason why the search ends there.");
}

namespace {

std::vector<std::string> pointers_of(const std::vector<SolveUnknown>& unknowns) {
  std::vector<std::string> all;
  for (const SolveUnknown& unknown : unknowns) all.push_back(unknown.pointer);
  return all;
}
std::vector<std::string> names_of(const std::vector<Budget>& budgets) {
  std::vector<std::string> all;
  for (const Budget& budget : budgets) all.push_back(budget_name(budget));
  return all;
}
Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), Eigen::Index(values.size()));
}

struct StateFacts {
  BudgetState state;
  std::vector<std::string> pointers;
};

void describe(Facts& facts, const StateFacts& of) {
  facts("value", of.state.value, "Value of the limited quantity, in the unit of the budget's name.");
  facts("margin", of.state.margin,
        "Distance from the limit over the limit; negative where the budget is violated.");
  facts.where(!of.state.sensitivity.empty(), "sensitivity",
              NamedNumbers{of.pointers, vector_of(of.state.sensitivity)},
              "d ln(value)/d ln(unknown), by the pointer of each unknown.");
}

struct PointFacts {
  const Specification* spec = nullptr;
  SolvePoint point;
};

void describe(Facts& facts, const PointFacts& of) {
  const Specification none, &spec = of.spec ? *of.spec : none;
  const std::vector<std::string> pointers = pointers_of(spec.unknowns);
  std::vector<StateFacts> states;
  for (const BudgetState& state : of.point.budgets) states.push_back({state, pointers});
  facts("at", NamedNumbers{pointers, vector_of(of.point.at)}, "Value of each unknown, by its pointer.");
  facts("binding", of.spec ? spec.budgets[of.point.binding].key : "", "The budget with the least margin.");
  facts.keyed("budgets", names_of(spec.budgets), states, "State of each budget there.");
}

struct SolutionFacts : PointFacts {};

void describe(Facts& facts, const SolutionFacts& of) {
  describe(facts, static_cast<const PointFacts&>(of));
  facts("bracket", of.point.bracket, "Neighbouring steps of the search that enclose it.");
  facts("holds", of.point.holds_below ? "below" : "above", "Side of it on which the budgets hold.");
}

struct BudgetFacts {
  Budget budget;
  double perfect = kNaN;
};

void describe(Facts& facts, const BudgetFacts& of) {
  facts("name", budget_name(of.budget), "The budget's name, with the SI unit of its limit.");
  facts("bound", of.budget.bound, "The bound as written in the study.");
  facts("limit", of.budget.limit, "The limit in SI units.");
  facts("without_roughness", of.perfect, "Value of the mirror without roughness.");
}

struct SolvedBudget : BudgetFacts {
  std::vector<double> alone;
};

void describe(Facts& facts, const SolvedBudget& of) {
  describe(facts, static_cast<const BudgetFacts&>(of));
  facts("at_most", of.budget.at_most, "Whether the limit is an upper limit.");
  facts("met_alone_at", of.alone, "Value of the first unknown that meets this budget alone.");
}

struct ContourFacts {
  bool is_closed = false;
  std::array<std::string, 2> ends;
  std::vector<PointFacts> points;
};

void describe(Facts& facts, const ContourFacts& contour) {
  facts("closed", contour.is_closed, "Whether the curve is closed.");
  facts("ends", contour.ends, "Reason why the curve ends, on either side.");
  facts("points", contour.points, "Points of the curve, in order.");
}

struct UseFacts {
  std::vector<std::string> budgets;
  BudgetUse use;
};

void describe(Facts& facts, const UseFacts& of) {
  facts("name", of.use.name, "Name of the contributor.");
  facts("alone", NamedNumbers{of.budgets, vector_of(of.use.alone)},
        "Value of each budgeted quantity with this contributor alone.");
  facts("without", NamedNumbers{of.budgets, vector_of(of.use.without)},
        "Value of each budgeted quantity without this contributor.");
}

template <typename Text>
std::optional<std::string> if_said(const Text& text) {
  return text.empty() ? std::nullopt : std::optional<std::string>(text);
}

}  // namespace

static void describe(Facts& facts, const SolveUnknown& unknown) {
  facts("pointer", unknown.pointer, "JSON pointer to the number in the study.");
  facts("start", unknown.start, "The study's own value, in its SI unit.");
}

void describe(Facts& facts, const Specification& spec) {
  const auto point = [&](const SolvePoint& at) {
    return at.at.empty() ? std::nullopt : std::optional(PointFacts{&spec, at});
  };
  std::vector<SolvedBudget> budgets;
  for (std::size_t k = 0; k < spec.budgets.size(); ++k)
    budgets.push_back({{spec.budgets[k], spec.perfect[k].value}, spec.alone[k]});
  std::vector<SolutionFacts> solutions;
  for (const SolvePoint& solution : spec.solutions) solutions.push_back({{&spec, solution}});
  ContourFacts contour{spec.contour.is_closed, spec.contour.ends, {}};
  for (const SolvePoint& one : spec.contour.points) contour.points.push_back({&spec, one});
  std::vector<UseFacts> uses;
  for (const BudgetUse& use : spec.uses) uses.push_back({names_of(spec.budgets), use});
  facts("status", spec.status, "solved, no_solution or unbounded.");
  facts("theory", spec.theory, "ghs or geometric.");
  facts("confidence", spec.confidence > 0 ? std::optional(spec.confidence) : std::nullopt,
        "Fraction of mirrors that the budgets hold for; null: they hold for the mean PSF.");
  facts("plate_scale_rad_per_m", 1 / spec.focal_length, "Angle on the sky over length in the focal plane.");
  facts("unknowns", spec.unknowns, "The unknown numbers.");
  facts("budgets", budgets, "The budgets that have to hold.");
  facts("range", spec.range, "Lower and upper end of the search for the first unknown.");
  facts("start", point(spec.start), "State at the study's own values.");
  facts("solutions", solutions, "The solutions, nearest to the start first.");
  facts("nearest", point(spec.nearest), "Point of least violation, where there is no solution.");
  facts("reason", if_said(spec.reason), "Reason why there is no solution or no bound.");
  facts("contour", contour.points.empty() ? std::nullopt : std::optional(contour),
        "The curve in two unknowns on which the strictest budget is just met.");
  facts("uses", uses, "How much of each budget each contributor uses.");
  facts("evaluations", spec.evaluations, "Evaluations of the theory.");
  facts("seconds", spec.seconds, "Time of the search.");
  facts("warnings", spec.warnings, "Warnings that the reader should know.");
}

namespace {

// Describes the budget that ends a ceiling; null, with a reason, if no height violates one.
void describe_end(Facts& facts, const Ceilings& of, double rms, std::size_t binding,
                  const std::string& reason) {
  const bool ends = std::isfinite(rms) && binding < of.budgets.size();
  facts("binding", ends ? std::optional(of.budgets[binding].key) : std::nullopt,
        "The limiting budget; null where no height violates one.");
  facts.where(!std::isfinite(rms), "reason", reason, "Reason why no ceiling was found.");
}

struct OctaveFacts {
  const Ceilings* of = nullptr;
  OctaveCeiling octave;
};

void describe(Facts& facts, const OctaveFacts& one) {
  const Ceilings none, &of = one.of ? *one.of : none;
  facts("frequency_per_m", one.octave.frequency, "Middle of the octave.");
  facts("cycles_across", one.octave.frequency * of.across,
        "Middle of the octave in cycles across the aperture.");
  facts("rms_m", one.octave.rms, "Largest RMS height in this octave if all others are smooth.");
  facts("profile_psd_m3", one.octave.profile_psd, "That height as a level of the one-sided profile PSD.");
  describe_end(facts, of, one.octave.rms, one.octave.binding, one.octave.reason);
}

struct LineFacts {
  const Ceilings* of = nullptr;
  LineCeiling line;
};

void describe(Facts& facts, const LineFacts& one) {
  const Ceilings none, &of = one.of ? *one.of : none;
  facts.object("profile_psd", "The line A/f^B in the form of a power law of a study.", [&](Facts& line) {
    line("A", one.line.level, "One-sided profile PSD at 1 cycle/mm [m^3].");
    line("f_unit", "1/mm", "The frequency that A belongs to.");
    line("B", one.line.exponent, "Exponent.");
  });
  facts("rms_m", one.line.rms, "RMS height of the surface over the band.");
  facts("headroom", one.line.headroom, "Least ratio of an octave's ceiling to the level of the line there.");
  facts("closest_per_m", one.line.closest, "Frequency of the octave with the least ratio.");
  describe_end(facts, of, one.line.rms, one.line.binding, one.line.reason);
}

struct FocusLight {
  const PsdOfFocus* of = nullptr;
};

void describe(Facts& facts, const FocusLight& light) {
  const PsdOfFocus none, &of = light.of ? *light.of : none;
  facts("kind", of.is_image ? "rings" : "circles", "Rings of pixels, or circles.");
  facts("radius_m", of.radius, "Radius of a circle, or mean radius of a ring.");
  facts("measured", of.measured, "Energy fraction inside the circle, or mean value of a pixel.");
  facts("fitted", of.fitted, "Prediction of the fitted roughness.");
  facts("noise", of.noise, "Standard deviation of the measured value.");
  facts("spread", of.spread, "Standard deviation among single mirrors.");
}

}  // namespace

void describe(Facts& facts, const Ceilings& ceilings) {
  std::vector<BudgetFacts> budgets;
  for (std::size_t k = 0; k < ceilings.budgets.size(); ++k)
    budgets.push_back({ceilings.budgets[k], ceilings.perfect[k]});
  std::vector<OctaveFacts> octaves;
  for (const OctaveCeiling& octave : ceilings.octaves) octaves.push_back({&ceilings, octave});
  std::vector<LineFacts> lines;
  for (const LineCeiling& line : ceilings.lines) lines.push_back({&ceilings, line});
  facts("status", ceilings.reason.empty() ? "found" : "no_solution", "found or no_solution.");
  facts("reason", if_said(ceilings.reason), "Reason why there are none.");
  facts("theory", ceilings.theory, "ghs or geometric.");
  facts("plate_scale_rad_per_m", 1 / ceilings.focal_length,
        "Angle on the sky over length in the focal plane.");
  facts("f_min_per_m", ceilings.f_min, "Lower end of the band.");
  facts("f_max_per_m", ceilings.f_max, "Upper end of the band.");
  facts("budgets", budgets, "The budgets that have to hold.");
  facts("octaves", octaves, "Largest roughness of each octave alone.");
  facts("lines", lines, "The largest lines A/f^B of a drawing.");
  facts("evaluations", ceilings.evaluations, "Evaluations of the theory.");
  facts("seconds", ceilings.seconds, "Time of the search.");
  facts("warnings", ceilings.warnings, "Warnings that the reader should know.");
}

static void describe(Facts& facts, const NumberOfFocus& number) {
  const bool known = number.identified();
  facts("pointer", number.unknown.pointer, "JSON pointer to the number in the study.");
  facts("start", number.unknown.start, "The study's own value, in its SI unit.");
  facts("identified", known, "Whether the measurement determines it.");
  facts("value", known ? number.best : kNaN, "Value found; null where it is not determined.");
  facts("best", number.best, "Value at the minimum.");
  facts("relative_std", known ? number.log_std : kNaN, "Relative standard deviation.");
  facts("lower", number.lower_found ? number.lower : kNaN,
        "Lower end of the interval; null where there is none.");
  facts("upper", number.upper_found ? number.upper : kNaN,
        "Upper end of the interval; null where there is none.");
}

void describe(Facts& facts, const PsdOfFocus& result) {
  std::vector<Eigen::VectorXd> correlation;
  for (Eigen::Index u = 0; u < result.correlation.rows(); ++u)
    correlation.emplace_back(result.correlation.row(u));
  using Pixels = std::array<double, 2>;
  const bool image = result.is_image;
  facts("status", result.status, "fitted, not-identified, poor-fit or not-converged.");
  facts("message", if_said(result.message), "Reason why it is not fitted.");
  facts("confidence", result.confidence, "Confidence of the intervals.");
  facts("numbers", result.numbers, "The unknown numbers.");
  facts("correlation_of_logarithms", correlation, "Correlation of the logarithms of the numbers.");
  facts("chi_squared", result.is_noise_known ? result.chi_squared : kNaN,
        "Chi-squared; null without a known noise.");
  facts("degrees_of_freedom", result.degrees_of_freedom, "Degrees of freedom.");
  facts("goodness", result.goodness,
        "p-value of the residuals: of chi-squared with a known noise, else of their shape.");
  facts("noise_factor", result.noise_factor, "Noise in the residuals over the assumed noise.");
  facts("of", result.is_one_mirror ? "mirror" : "mean", "Whether one mirror or a mean of many was measured.");
  facts("plane_m", result.dz, "Distance of the plane from the focus.");
  facts("total", result.total, "Total energy, in the unit of the data.");
  facts("background", image ? result.background : kNaN, "Background per pixel; null for a curve.");
  facts("centre_pixels", image ? std::optional(Pixels{result.centre_x, result.centre_y}) : std::nullopt,
        "Centre of the image, counted from its lower left pixel.");
  facts("light", FocusLight{&result}, "Measured and fitted values.");
  facts("evaluations", result.evaluations, "Evaluations of the theory.");
  facts("seconds", result.seconds, "Time of the fit.");
  facts("warnings", result.warnings, "Warnings that the reader should know.");
}

}  // namespace aberfit::internal
