#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "aberfit/report/drawn_picture.h"
#include "aberfit/report/page.h"

namespace aberfit {

/// Contents of report.html.
struct HtmlReport {
  const Page& page;
  const nlohmann::ordered_json& document;  ///< result.json
  const nlohmann::ordered_json& asked;     ///< the study as typed, with its units
  std::vector<DrawnPicture> pictures;
  std::string folder;           ///< folder of results: its files are listed, its pictures included
  std::vector<Page::Text> run;  ///< when, where and how it was made; `document` leaves this out
  const Page* whole = nullptr;  ///< page with tables too long for `page`; null: none
};

/// One HTML page in UTF-8 without script or external reference. It has the question, the answer, its limits,
/// all tables, the pictures, the files and the origin of the result. A picture is only named if it is no SVG
/// or PNG, or would make the page larger than 3 MB.
std::string html_of(const HtmlReport& report);

/// The first screen of that page as HTML without head and styles, for a notebook.
std::string first_screen_of(const HtmlReport& report);

/// One of several results to compare.
struct ComparedResult {
  std::string name;                        ///< name of its folder, for people
  const nlohmann::ordered_json& document;  ///< result.json
  std::string link;                        ///< to its report, relative to the page; empty: no report
};
/// One HTML page of several results: their answers and origins, and the inputs and numbers that differ. run:
/// when, where and how the page was made.
std::string html_of(const std::vector<ComparedResult>& results, const std::vector<Page::Text>& run = {});

}  // namespace aberfit
