#include "aberfit/report/solve_report.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "aberfit/report/documents.h"
#include "paragraph.h"
#include "unknown_text.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kShownAsZero = 5e-9;  // fraction of a margin: error of the root

// "*" marks the binding budget. Sensitivities are logarithmic: per cent of the value per per cent of the
// unknown.
void add_budgets(Page* page, const std::string& title, const Specification& spec, const SolvePoint& point,
                 bool sensitivities) {
  Page::Table table{title, {"", "budget", "value", "limit", "margin", "room"}, "llrlrr"};
  for (std::size_t u = 0; u < (sensitivities ? spec.unknowns.size() : 0); ++u)
    table.heads.push_back("%/% " + name_of(spec.unknowns[u])), table.align += 'r';
  for (std::size_t k = 0; k < point.budgets.size(); ++k) {
    const Budget& budget = spec.budgets[k];
    const BudgetState& state = point.budgets[k];
    const double room = budget.at_most ? budget.limit - state.value : state.value - budget.limit;
    const bool at_limit = std::abs(state.margin) < kShownAsZero;
    std::vector<std::string> cells = {k == point.binding && point.budgets.size() > 1 ? "*" : "",
                                      budget.key,
                                      in_budget_unit(budget, state.value),
                                      budget.bound,
                                      at_limit ? "0 %" : fmt::format("{:.3g} %", 100 * state.margin),
                                      at_limit ? "-" : in_budget_unit(budget, room)};
    for (std::size_t u = 0; u < (sensitivities ? state.sensitivity.size() : 0); ++u)
      cells.push_back(fmt::format("{:.4g}", state.sensitivity[u]));
    table.add(std::move(cells), state.margin < -kShownAsZero ? Page::Tone::kBad : Page::Tone::kPlain);
  }
  page->parts.push_back(std::move(table));
}

void add_uses(Page* page, const Specification& spec) {
  for (std::size_t k = 0; k < spec.budgets.size() && !spec.uses.empty(); ++k) {
    const Budget& budget = spec.budgets[k];
    Page::Table table{fmt::format("{} {}: use by each contributor; {} with perfect optics", budget.key,
                                  budget.bound, in_budget_unit(budget, spec.perfect[k].value)),
                      {"", "alone", "without it"},
                      "lrr"};
    for (const BudgetUse& use : spec.uses)
      table.add({use.name, in_budget_unit(budget, use.alone[k]), in_budget_unit(budget, use.without[k])});
    page->parts.push_back(std::move(table));
  }
}

void add_solution(Page* page, const Specification& spec, const SolvePoint& solution) {
  const auto shown = [&](double value) { return six_digits(value, spec.unknowns[0].dimension); };
  std::string title =
      fmt::format("{} = {}: the budgets hold {} it; found between {} and {}", name_of(spec.unknowns[0]),
                  shown(solution.at[0]), solution.holds_below ? "below" : "above", shown(solution.bracket[0]),
                  shown(solution.bracket[1]));
  for (std::size_t u = 1; u < spec.unknowns.size(); ++u)
    title += fmt::format("; at {} = {}", name_of(spec.unknowns[u]),
                         six_digits(solution.at[u], spec.unknowns[u].dimension));
  add_budgets(page, title, spec, solution, true);
}

std::string solve_headline(const Specification& spec) {
  const SolveUnknown& unknown = spec.unknowns.front();
  if (spec.status == SolveStatus::kNoSolution) return "NO SOLUTION";
  if (spec.status == SolveStatus::kUnbounded) return "NO BOUND";
  const SolvePoint& first = spec.solutions.front();
  return fmt::format(
      "SOLVED: {} {} {}{}", name_of(unknown),
      first.holds_below ? "<=" : ">=", six_digits(first.at[0], unknown.dimension),
      spec.confidence > 0 ? fmt::format(" for {} of the mirrors", format_percent(spec.confidence)) : "");
}

// Margin of each budget at the solution: "ee80_diameter 12.2 %, strehl 0 % (the limit)".
std::string margins_text(const Specification& spec, const SolvePoint& point) {
  std::string text;
  for (std::size_t k = 0; k < point.budgets.size(); ++k) {
    const double margin = point.budgets[k].margin;
    text += fmt::format("{}{} {:.3g} %{}", text.empty() ? "" : ", ", spec.budgets[k].key,
                        std::abs(margin) < kShownAsZero ? 0 : 100 * margin,
                        k == point.binding ? " (the limiting one)" : "");
  }
  return text;
}

void add_by_how_much(Page* page, const Specification& spec) {
  if (!spec.solutions.empty()) {
    const SolvePoint& first = spec.solutions.front();
    std::string text = "Margins of the budgets at the solution: " + margins_text(spec, first) + ".";
    text += " The study as it stands: " + margins_text(spec, spec.start) + ".";
    page->answers.push_back({"By how much", text});
    for (std::size_t u = 1; u < spec.unknowns.size(); ++u)
      page->answers.push_back(
          {"Second unknown",
           fmt::format("The value holds at {} = {}, as in the study. contour.csv and the picture have the "
                       "pairs of {} and {} that just meet the budgets.",
                       name_of(spec.unknowns[u]), six_digits(first.at[u], spec.unknowns[u].dimension),
                       name_of(spec.unknowns[0]), name_of(spec.unknowns[u]))});
  } else if (!spec.nearest.at.empty()) {
    page->answers.push_back(
        {"By how much",
         fmt::format("Margins of the budgets at the nearest value, {} = {}: {}.", name_of(spec.unknowns[0]),
                     six_digits(spec.nearest.at[0], spec.unknowns[0].dimension),
                     margins_text(spec, spec.nearest))});
  }
}

void add_answers(Page* page, const Specification& spec) {
  add_by_how_much(page, spec);
  const auto say = [&](const char* label, std::string text) {
    page->answers.push_back({label, std::move(text)});
  };
  say("How certain",
      spec.confidence > 0
          ? "The budgets hold for " + format_percent(spec.confidence) + " of such mirrors."
          : "The budgets hold for the mean PSF of such mirrors. With `confidence` in `solve` they hold for a "
            "fraction of single mirrors instead." +
                std::string(spec.solutions.empty() ? "" : " The value found is exact to 1e-11."));
  say("What it rests on",
      std::string(spec.theory == Theory::kGhs ? "Generalised" : "Geometric") +
          " Harvey-Shack theory for a stationary, isotropic, Gaussian roughness with the given PSD.");
  if (spec.solutions.empty())
    return say("What would change it",
               "Other budgets, or other numbers of the mirror, the aperture, the light or the roughness.");
  const SolvePoint& first = spec.solutions.front();
  const BudgetState& state = first.budgets[first.binding];
  if (!state.sensitivity.empty())
    say("What would change it",
        fmt::format("{} is the limiting budget: 1 % more {} changes it by {:+.3g} %.",
                    spec.budgets[first.binding].key, name_of(spec.unknowns[0]), state.sensitivity[0]));
}

}  // namespace

Page page_of(const Specification& spec) {
  const SolveUnknown& unknown = spec.unknowns.front();
  const std::string name = name_of(unknown);
  const auto shown = [&](double value) { return six_digits(value, unknown.dimension); };
  Page page;
  page.headline = solve_headline(spec);
  page.tone = spec.status == SolveStatus::kSolved ? Page::Tone::kGood : Page::Tone::kOpen;
  if (!spec.reason.empty()) page.advice.push_back(spec.reason);
  if (!spec.solutions.empty())
    page.advice.push_back(
        fmt::format("To specify it, put the value into {} of the study; `aberfit fit` then finds the terms "
                    "of such a mirror.",
                    unknown.pointer));
  add_answers(&page, spec);
  page.title = spec.title;
  page.say("Theory", fmt::format("{}; plate scale 1/f = {:.5g} arcsec/mm", to_string(spec.theory),
                                 1e-3 / spec.focal_length / unit_factor("arcsec", Dimension::kAngle)));
  if (spec.confidence > 0)
    page.say("Mirrors", fmt::format("{} of the mirrors of such a roughness are no worse than these values; "
                                    "they are not those of the mean PSF",
                                    format_percent(spec.confidence)));
  page.say("Range", fmt::format("{} from {} ({}) to {} ({}); start {}", name, shown(spec.range[0].value),
                                spec.range[0].why, shown(spec.range[1].value), spec.range[1].why,
                                shown(unknown.start)));
  page.say("Cost", fmt::format("{} evaluations, {:.2g} s", spec.evaluations, spec.seconds));
  for (const SolvePoint& solution : spec.solutions) add_solution(&page, spec, solution);
  add_uses(&page, spec);
  if (!spec.nearest.at.empty())
    add_budgets(&page, fmt::format("Nearest, {} = {}", name, shown(spec.nearest.at[0])), spec, spec.nearest,
                false);
  add_budgets(&page, fmt::format("The study's own value, {} = {}", name, shown(unknown.start)), spec,
              spec.start, false);
  if (const auto& points = spec.contour.points; !points.empty())
    page.say("Contour", fmt::format("{} points, {} to {} in {}: contour.csv", points.size(),
                                    six_digits(points.front().at[1], spec.unknowns[1].dimension),
                                    six_digits(points.back().at[1], spec.unknowns[1].dimension),
                                    name_of(spec.unknowns[1])));
  page.warnings = spec.warnings;
  return page;
}

std::string contour_csv(const Specification& spec) {
  std::string text;
  for (const SolveUnknown& unknown : spec.unknowns) text += column_of(unknown) + ",";
  for (const Budget& budget : spec.budgets)
    text += fmt::format("{0},{1}_margin,", budget_name(budget), budget.key);
  text += "binding\n";
  for (const SolvePoint& point : spec.contour.points) {
    for (const double value : point.at) fmt::format_to(std::back_inserter(text), "{:.12g},", value);
    for (const BudgetState& state : point.budgets)
      fmt::format_to(std::back_inserter(text), "{:.12g},{:.3g},", state.value, state.margin);
    text += spec.budgets[point.binding].key + "\n";
  }
  return text;
}

}  // namespace aberfit
