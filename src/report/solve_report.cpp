#include "aberfit/report/solve_report.h"

#include <fmt/format.h>

#include <iterator>

#include "json_number.h"
#include "paragraph.h"
#include "unknown_text.h"

namespace aberfit {
using namespace internal;

namespace {

constexpr double kShownAsZero = 5e-9;  // of a margin: what the root leaves

Json point_json(const Specification& spec, const SolvePoint& point) {
  if (point.at.empty()) return nullptr;
  Json at = Json::object(), budgets = Json::object();
  for (std::size_t u = 0; u < point.at.size(); ++u) at[spec.unknowns[u].pointer] = json_number(point.at[u]);
  for (std::size_t k = 0; k < point.budgets.size(); ++k) {
    const BudgetState& state = point.budgets[k];
    Json json{{"value", json_number(state.value)}, {"margin", json_number(state.margin)}};
    for (std::size_t u = 0; u < state.sensitivity.size(); ++u)
      json["sensitivity"][spec.unknowns[u].pointer] = json_number(state.sensitivity[u]);
    budgets[budget_name(spec.budgets[k])] = json;
  }
  return {{"at", at}, {"binding", spec.budgets[point.binding].key}, {"budgets", budgets}};
}

// "*": what binds. Sensitivities are of logarithms: percent of the value for each percent of the unknown.
std::string budget_rows(const Specification& spec, const SolvePoint& point) {
  std::string text;
  for (std::size_t k = 0; k < point.budgets.size(); ++k) {
    const Budget& budget = spec.budgets[k];
    const BudgetState& state = point.budgets[k];
    std::string sensitivity;
    for (const double one : state.sensitivity) sensitivity += fmt::format(" {:>10.4g}", one);
    const double room = budget.at_most ? budget.limit - state.value : state.value - budget.limit;
    text += fmt::format(
        "  {} {:<20} {:>13} {:<16} {:>8} {:>13}{}\n",
        k == point.binding && point.budgets.size() > 1 ? "*" : " ", budget.key,
        in_budget_unit(budget, state.value), budget.bound,
        std::abs(state.margin) < kShownAsZero ? "0 %" : fmt::format("{:.3g} %", 100 * state.margin),
        std::abs(state.margin) < kShownAsZero ? "-" : in_budget_unit(budget, room), sensitivity);
  }
  return text;
}

// Of a column of ten: the last word of a long name, cut where that is long, too.
std::string short_name_of(const SolveUnknown& unknown) {
  constexpr std::size_t kRoom = 6;
  std::string name = name_of(unknown);
  if (name.size() > kRoom && name.find('_') != std::string::npos) name = name.substr(name.rfind('_') + 1);
  return name.size() > kRoom ? name.substr(0, kRoom - 1) + "." : name;
}

std::string head_of_rows(const Specification& spec, bool sensitivities) {
  std::string text =
      fmt::format("    {:<20} {:>13} {:<16} {:>8} {:>13}", "budget", "value", "limit", "margin", "room");
  if (sensitivities)
    for (const SolveUnknown& unknown : spec.unknowns)
      text += fmt::format(" {:>10}", "%/% " + short_name_of(unknown));
  return text + "\n";
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

}  // namespace

Json to_json(const Specification& spec, const Json& study, const Provenance& provenance) {
  Json json = json_document("solve", study);
  json["status"] = to_string(spec.status);
  json["theory"] = to_string(spec.theory);
  json["confidence"] = spec.confidence > 0 ? Json(spec.confidence) : Json(nullptr);
  json["plate_scale_rad_per_m"] = json_number(1 / spec.focal_length);
  json["unknowns"] = Json::array();
  for (const SolveUnknown& unknown : spec.unknowns)
    json["unknowns"].push_back({{"pointer", unknown.pointer}, {"start", json_number(unknown.start)}});
  json["budgets"] = Json::array();
  for (std::size_t k = 0; k < spec.budgets.size(); ++k) {
    const Budget& budget = spec.budgets[k];
    json["budgets"].push_back({{"name", budget_name(budget)},
                               {"bound", budget.bound},
                               {"at_most", budget.at_most},
                               {"limit", json_number(budget.limit)},
                               {"without_roughness", json_number(spec.perfect[k].value)},
                               {"met_alone_at", spec.alone[k]}});
  }
  json["range"] = Json::array();
  for (const RangeEnd& end : spec.range)
    json["range"].push_back({{"value", json_number(end.value)}, {"why", end.why}});
  json["start"] = point_json(spec, spec.start);
  json["solutions"] = Json::array();
  for (const SolvePoint& solution : spec.solutions) {
    Json one = point_json(spec, solution);
    one["bracket"] = solution.bracket;
    one["holds"] = solution.holds_below ? "below" : "above";
    json["solutions"].push_back(one);
  }
  json["nearest"] = point_json(spec, spec.nearest);
  json["reason"] = spec.reason.empty() ? Json(nullptr) : Json(spec.reason);
  json["contour"] = nullptr;
  if (!spec.contour.points.empty()) {
    Json points = Json::array();
    for (const SolvePoint& point : spec.contour.points) points.push_back(point_json(spec, point));
    json["contour"] = {{"closed", spec.contour.is_closed}, {"ends", spec.contour.ends}, {"points", points}};
  }
  json["uses"] = Json::array();
  for (const BudgetUse& use : spec.uses) {
    Json one{{"name", use.name}};
    for (std::size_t k = 0; k < spec.budgets.size(); ++k) {
      one["alone"][budget_name(spec.budgets[k])] = json_number(use.alone[k]);
      one["without"][budget_name(spec.budgets[k])] = json_number(use.without[k]);
    }
    json["uses"].push_back(one);
  }
  json["evaluations"] = spec.evaluations;
  json["seconds"] = json_number(spec.seconds);
  json["warnings"] = json_warnings(spec.warnings);
  json["provenance"] = to_json(provenance);
  return json;
}

std::string summary_table(const Specification& spec) {
  const SolveUnknown& unknown = spec.unknowns.front();
  const auto shown = [&](double value) { return six_digits(value, unknown.dimension); };
  std::string text = solve_headline(spec) + (spec.title.empty() ? "" : "   " + spec.title) + "\n\n";
  text += fmt::format("Theory    {}; plate scale 1/f = {:.5g} arcsec/mm\n", to_string(spec.theory),
                      1e-3 / spec.focal_length / unit_factor("arcsec", Dimension::kAngle));
  if (spec.confidence > 0)
    text +=
        paragraph("Mirrors", fmt::format("values are those that {} of the mirrors of such a roughness are "
                                         "no worse than, not those of their mean light",
                                         format_percent(spec.confidence)));
  text +=
      paragraph("Range ", fmt::format("{} from {} ({}) to {} ({}); start {}", name_of(unknown),
                                      shown(spec.range[0].value), spec.range[0].why,
                                      shown(spec.range[1].value), spec.range[1].why, shown(unknown.start)));
  text += fmt::format("Cost      {} evaluations, {:.2g} s\n", spec.evaluations, spec.seconds);
  if (!spec.reason.empty()) text += "\n" + paragraph("Why   ", spec.reason);
  for (const SolvePoint& solution : spec.solutions) {
    text += fmt::format("\n{} = {}: budgets hold {} it; found between {} and {}\n", name_of(unknown),
                        shown(solution.at[0]), solution.holds_below ? "below" : "above",
                        shown(solution.bracket[0]), shown(solution.bracket[1]));
    for (std::size_t u = 1; u < spec.unknowns.size(); ++u)
      text += fmt::format("  at {} = {}\n", name_of(spec.unknowns[u]),
                          six_digits(solution.at[u], spec.unknowns[u].dimension));
    text += head_of_rows(spec, true) + budget_rows(spec, solution);
  }
  for (std::size_t k = 0; k < spec.budgets.size() && !spec.uses.empty(); ++k) {
    const Budget& budget = spec.budgets[k];
    text +=
        fmt::format("\n{} {}: who uses it; {} with perfect optics\n    {:<24} {:>16} {:>16}\n", budget.key,
                    budget.bound, in_budget_unit(budget, spec.perfect[k].value), "", "alone", "all but this");
    for (const BudgetUse& use : spec.uses)
      text += fmt::format("    {:<24} {:>16} {:>16}\n", use.name.substr(0, 24),
                          in_budget_unit(budget, use.alone[k]), in_budget_unit(budget, use.without[k]));
  }
  if (!spec.nearest.at.empty())
    text += fmt::format("\nNearest, {} = {}\n", name_of(unknown), shown(spec.nearest.at[0])) +
            head_of_rows(spec, false) + budget_rows(spec, spec.nearest);
  text += fmt::format("\nThe study's own, {} = {}\n", name_of(unknown), shown(unknown.start)) +
          head_of_rows(spec, false) + budget_rows(spec, spec.start);
  if (!spec.contour.points.empty()) {
    const auto& points = spec.contour.points;
    text +=
        fmt::format("\nContour of {} points, {} to {} in {}: contour.csv\n", points.size(),
                    six_digits(points.front().at[1], spec.unknowns[1].dimension),
                    six_digits(points.back().at[1], spec.unknowns[1].dimension), name_of(spec.unknowns[1]));
  }
  return text + warning_lines(spec.warnings);
}

std::string contour_csv(const Specification& spec) {
  std::string text;
  for (const SolveUnknown& unknown : spec.unknowns)
    text += name_of(unknown) + unit_suffix(unknown.dimension) + ",";
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
