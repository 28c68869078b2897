#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/page.h"

namespace aberfit {

/// What report.html is made from.
struct HtmlReport {
  const Page& page;
  const nlohmann::ordered_json& document;  ///< result.json
  const nlohmann::ordered_json& asked;     ///< the study as it was typed, with its units
  std::vector<DrawnPicture> pictures;
  std::string folder;           ///< of the results: its files are listed, its pictures taken in
  std::vector<Page::Text> run;  ///< when, where and how it was made; not in `document`, which stays the same
  const Page* whole = nullptr;  ///< with tables that are too long for `page`; null: there are none
};

/// One HTML page (UTF-8, no script, no reference to anything outside of itself) with what was asked, the
/// answer, its limits, all tables, the pictures, the files and where the result comes from. Pictures that are
/// no SVG or PNG, or that would make the page larger than 3 MB, are named instead of shown.
std::string html_of(const HtmlReport& report);

/// One of several results that are put side by side.
struct ComparedResult {
  std::string name;                        ///< of its folder, for people
  const nlohmann::ordered_json& document;  ///< result.json
  std::string link;                        ///< to its report, relative to the page; empty: it has none
};
/// One HTML page of several results: their answers, what was asked and what came, where they differ.
std::string html_of(const std::vector<ComparedResult>& results);

}  // namespace aberfit
