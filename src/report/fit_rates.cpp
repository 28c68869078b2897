#include "aberfit/report/fit_rates.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

using nlohmann::ordered_json;

ordered_json read_chart(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "no file that can be read", "chart.json as `aberfit chart` writes it");
  try {
    return ordered_json::parse(in);
  } catch (const ordered_json::exception&) {  // a number that no double holds is none of its parse errors
    throw InputError(file, "", "no JSON", "chart.json as `aberfit chart` writes it");
  }
}

}  // namespace

ordered_json to_json(const FitRates& r) {
  return {{"size",
           {{"rays", r.size.rays},
            {"terms", r.size.terms},
            {"fitted", r.size.fitted},
            {"judged", r.size.judged},
            {"zone_points", r.size.zone_points},
            {"threads", r.size.threads}}},
          {"targets_seconds", r.measured.targets},
          {"prior_seconds", r.measured.prior},
          {"forward_seconds", r.forward},
          {"jacobian_seconds", r.jacobian},
          {"exact_seconds", r.exact},
          {"iteration_seconds", r.measured.iteration},
          {"iterations", r.iterations},
          {"iterations_known", r.iterations_known},
          {"fresh_seconds", r.measured.fresh},
          {"zones_seconds", r.measured.zones},
          {"expected",
           {{"targets_seconds", r.expected.targets},
            {"prior_seconds", r.expected.prior},
            {"iteration_seconds", r.expected.iteration},
            {"fresh_seconds", r.expected.fresh},
            {"zones_seconds", r.expected.zones}}}};
}

FitRates read_rates(const std::string& file_or_folder, const ordered_json& study, bool* same_study) {
  namespace fs = std::filesystem;
  const std::string file =
      fs::is_directory(file_or_folder) ? (fs::path(file_or_folder) / "chart.json").string() : file_or_folder;
  const ordered_json chart = read_chart(file);
  FitRates r;
  try {
    if (chart.at("kind") != "chart") throw InputError(file, "/kind", chart["kind"].dump(), "\"chart\"");
    const ordered_json &rates = chart.at("rates"), &size = rates.at("size"), &expected = rates.at("expected");
    // A chart that was edited must not end as a prediction of nothing or of minus a second.
    const auto number = [&](const ordered_json& from, const char* key) {
      const double value = from.at(key).get<double>();
      const bool counts = &from == &size && std::string(key) != "zone_points";
      if (!std::isfinite(value) || value < 0 || (counts && value < 1))
        throw InputError(file,
                         std::string("/rates/") +
                             (&from == &size       ? "size/"
                              : &from == &expected ? "expected/"
                                                   : "") +
                             key,
                         from[key].dump(), counts ? "a number from 1 up" : "a number from 0 up");
      return value;
    };
    r.size = {number(size, "rays"),   number(size, "terms"),       number(size, "fitted"),
              number(size, "judged"), number(size, "zone_points"), number(size, "threads")};
    const auto work = [&](const ordered_json& from) {
      FitWork w;
      w.targets = number(from, "targets_seconds");
      w.prior = number(from, "prior_seconds");
      w.iteration = number(from, "iteration_seconds");
      w.fresh = number(from, "fresh_seconds");
      w.zones = number(from, "zones_seconds");
      return w;
    };
    r.measured = work(rates);
    r.expected = work(expected);
    r.forward = number(rates, "forward_seconds");
    r.jacobian = number(rates, "jacobian_seconds");
    r.exact = number(rates, "exact_seconds");
    r.iterations = number(rates, "iterations");
    r.iterations_known = rates.at("iterations_known").get<bool>();
    *same_study = chart.at("study") == study;
  } catch (const ordered_json::exception&) {
    throw InputError(file, "", "no rates of a chart", "chart.json as `aberfit chart` writes it");
  }
  r.source = *same_study ? "measured on this study, " + file : "scaled from another study, " + file;
  if (!*same_study) {
    r.iterations_known = false;
    r.iterations = built_in_rates().iterations;
  }
  return r;
}

}  // namespace aberfit
