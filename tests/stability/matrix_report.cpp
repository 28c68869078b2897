#include "matrix_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "matrix_row.h"

namespace aberfit {
namespace {

using nlohmann::json;

// The promises.
constexpr double kOfOpen = 0.98, kOfCarried = 0.95;
constexpr double kCarried = 0.99;  // of the slope variance

double number_of(const json& row, const char* key) {
  return row.contains(key) && row[key].is_number() ? row[key].get<double>() : std::nan("");
}

bool is(const json& row, const char* outcome) { return row["outcome"] == outcome; }

struct Count {
  std::map<std::string, int> outcomes;
  int rows = 0, failures = 0;
};

// Counts by class and its value, classes in alphabetical order.
std::map<std::pair<std::string, std::string>, Count> count_by_class(const std::vector<json>& rows) {
  std::map<std::pair<std::string, std::string>, Count> counts;
  for (const json& row : rows)
    for (const auto& [of, value] : row["classes"].items()) {
      Count& count = counts[{of, value}];
      ++count.rows;
      ++count.outcomes[row["outcome"]];
      count.failures += !failure_of(row).empty();
    }
  return counts;
}

constexpr const char* kOutcomes[] = {"equivalent", "undecided", "different", "refused"};

std::string table_of(const std::vector<json>& rows) {
  std::string text = fmt::format("{:<12}{:<16}{:>6}{:>12}{:>11}{:>11}{:>9}{:>10}\n", "class", "", "rows",
                                 "equivalent", "undecided", "different", "refused", "failures");
  for (const auto& [of, count] : count_by_class(rows)) {
    const auto share = [&n = count](const char* outcome) {
      const auto at = n.outcomes.find(outcome);
      return at == n.outcomes.end() ? std::string("-") : fmt::format("{:.0f} %", 100.0 * at->second / n.rows);
    };
    text += fmt::format("{:<12}{:<16}{:>6}{:>12}{:>11}{:>11}{:>9}{:>10}\n", of.first, of.second, count.rows,
                        share(kOutcomes[0]), share(kOutcomes[1]), share(kOutcomes[2]), share(kOutcomes[3]),
                        count.failures);
  }
  return text;
}

using Which = std::function<bool(const json&)>;

// One promise: of the rows that `of` takes, the share that `kept` takes is at least `least`.
std::string promise(const std::vector<json>& rows, const char* what, double least, const Which& of,
                    const Which& kept, bool* promised) {
  const auto all = std::count_if(rows.begin(), rows.end(), of),
             good = std::count_if(rows.begin(), rows.end(),
                                  [&](const json&row) { return of(row) && kept(row); });
  const bool holds = double(good) >= least * double(all);
  *promised = *promised && holds;
  return fmt::format("{:<6}{} of {} {} ({:.1f} %, promised {:g} %)\n", holds ? "kept" : "BROKEN", good, all,
                     what, all > 0 ? 100.0 * double(good) / double(all) : 100, 100 * least);
}

std::string promises_of(const std::vector<json>& rows, bool* promised) {
  const Which equivalent = [](const json& row) { return is(row, "equivalent"); };
  const Which every = [](const json&) { return true; };
  std::string text;
  text += promise(
      rows, "rows are no failure", 1, every, [](const json& row) { return failure_of(row).empty(); },
      promised);
  text += promise(
      rows, "scenes whose terms can carry the band are equivalent", kOfCarried,
      [](const json& row) { return number_of(row, "carried") >= kCarried; }, equivalent, promised);
  text += promise(
      rows, "scenes that leave everything open are equivalent", kOfOpen,
      [](const json& row) { return row["open"] == true; }, equivalent, promised);
  text += promise(
      rows, "others say why and what to do", 1, [&](const json& row) { return !equivalent(row); },
      [](const json& row) { return row.value("remedy", false); }, promised);
  return text;
}

std::string times_of(const std::vector<json>& rows) {
  double longest_check = 0, longest_fit = 0, all = 0;
  for (const json& row : rows) {
    const double fit = number_of(row, "fit_s");
    longest_check = std::max(longest_check, number_of(row, "check_s"));
    longest_fit = std::max(longest_fit, std::isfinite(fit) ? fit : 0);
    all += std::isfinite(fit) ? fit : 0;
  }
  return fmt::format("processor time of all fits {:.0f} s, longest fit {:.1f} s, longest check {:.1f} s\n",
                     all, longest_fit, longest_check);
}

std::string line_of(const json& row) {
  std::string text = fmt::format("{:>4} {:<78} {}", row["row"].get<int>(), row["name"].get<std::string>(),
                                 row["outcome"].get<std::string>());
  if (const double mismatch = number_of(row, "mismatch"); std::isfinite(mismatch))
    text += fmt::format(", {:.3g} margins in {}", mismatch, row.value("statistic", "nothing"));
  if (const double carried = number_of(row, "carried"); carried < kCarried)
    text += fmt::format(", carries {:.0f} % of the slopes", 100 * carried);
  for (const json& code : row.value("warnings", json::array())) text += " [" + code.get<std::string>() + "]";
  if (row.contains("message")) text += "\n       " + row["message"].get<std::string>();
  const std::string failure = failure_of(row);
  return text + (failure.empty() ? "" : "\n       FAILURE: " + failure) + "\n";
}

}  // namespace

MatrixReport report_on(const std::vector<json>& rows) {
  MatrixReport report;
  report.text = table_of(rows) + "\n" + times_of(rows) + "\n" + promises_of(rows, &report.promised) + "\n";
  for (const json& row : rows) {
    const bool failed = !failure_of(row).empty();
    report.sound = report.sound && !failed;
    if (failed || !is(row, "equivalent")) report.text += line_of(row);
  }
  return report;
}

bool draw_shares(const std::vector<json>& rows, const std::string& svg) {
  const auto counts = count_by_class(rows);
  std::string data;
  for (const auto& [of, count] : counts) {
    data += fmt::format("\"{}: {}\"", of.first, of.second);
    for (const char* outcome : kOutcomes) {
      const auto at = count.outcomes.find(outcome);
      data += fmt::format(" {}", at == count.outcomes.end() ? 0 : 100.0 * at->second / count.rows);
    }
    data += fmt::format(" {}\n", 100.0 * count.failures / count.rows);
  }
  std::FILE* gnuplot = popen("gnuplot", "w");
  if (gnuplot == nullptr) return false;
  fmt::print(gnuplot, "$shares << END\n{}END\n", data);
  fmt::print(gnuplot,
             "set terminal svg size 1100,520 dynamic\nset output '{}'\nset style data histograms\n"
             "set style histogram rowstacked\nset style fill solid 0.8 border -1\nset boxwidth 0.75\n"
             "set xtics rotate by -55 scale 0\nset ylabel 'share of {} scenes [%]'\nset yrange [0:100]\n"
             "set key outside top center horizontal\nplot ",
             svg, rows.size());
  constexpr const char* kColours[] = {"#2a9d5c", "#e9c46a", "#e07a3f", "#9aa5b1", "#5b7db1"};
  for (std::size_t k = 0; k < std::size(kOutcomes); ++k)
    fmt::print(gnuplot, "{}$shares using {}:xtic(1) title '{}' linecolor '{}'", k == 0 ? "" : ", ", k + 2,
               kOutcomes[k], kColours[k]);
  // Verdicts that are contradicted are equivalent, too: a mark on the bar, not a part of it.
  fmt::print(
      gnuplot,
      ", $shares using 0:($7 > 0 ? $7 : 1/0) with points pointtype 7 linecolor 'red' title 'failures'\n");
  return pclose(gnuplot) == 0;
}

}  // namespace aberfit
