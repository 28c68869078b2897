#include "aberfit/report/html_report.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "aberfit/report/documents.h"
#include "report/sample_result.h"
#include "study/scratch_folder.h"

using namespace aberfit;
using Json = nlohmann::ordered_json;

namespace {

// Addresses that a browser would fetch for a page: those in src, href, url() or @import, unless they are data
// or a place in the page. Scripts count, because they may fetch anything.
std::vector<std::string> fetched_by(const std::string& html) {
  std::vector<std::string> found;
  static const std::regex kReference(
      R"re((?:src|href|data|action|poster)\s*=\s*["']([^"']*)["']|url\(([^)]*)\)|@import\s+([^;]*);|<(script|iframe|object|embed|link|base)\b)re");
  for (auto at = std::sregex_iterator(html.begin(), html.end(), kReference); at != std::sregex_iterator();
       ++at) {
    std::string target;
    for (std::size_t k = 1; k < at->size(); ++k) target += (*at)[k];
    if (!target.starts_with("data:") && !target.starts_with("#") && !target.starts_with("'#") &&
        !target.starts_with("\"#"))
      found.push_back(target);
  }
  return found;
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

class ReportPage : public ::testing::Test {
 protected:
  std::string page_with(Json study, std::vector<DrawnPicture> pictures = {}) {
    ResultDocument result = sample_result();
    if (study.contains("title")) result.title = study["title"];
    return html_of({page_of(result, true),
                    to_json(result, study),
                    study,
                    std::move(pictures),
                    folder_.file(""),
                    {{"date", "2026-01-02"}}});
  }
  test::ScratchFolder folder_;
};

}  // namespace

TEST_F(ReportPage, AnswersTheFirstQuestions) {
  write(folder_.file("coefficients.csv"), "x");
  const std::string html = page_with({{"aberfit", 1},
                                      {"title", "Primary"},
                                      {"mirror", {{"focal_length", "2.8 m"}}},
                                      {"light", {{"wavelength", "632.8 nm"}}}});
  for (const char* said :
       {"<h1>Primary</h1>", "focal length 2.8 m", "wavelength 632.8 nm", "What the study specifies",
        "How certain", "What it rests on", "Limits that apply here", "coefficients.csv", "OpticStudio",
        "prysm", "seed", "Every number of result.json"})
    EXPECT_NE(html.find(said), std::string::npos) << said;
  EXPECT_EQ(html.find("{{"), std::string::npos);
}

TEST_F(ReportPage, ExplainsTheNamesOnItAndNoOthers) {
  const std::string html =
      page_with({{"aberfit", 1}, {"roughness", {{"psd", {{"model", "k-correlation"}}}}}});
  EXPECT_NE(html.find("Names on this page"), std::string::npos);
  EXPECT_NE(html.find("its knee is at the frequency f = 1/B"), std::string::npos);
  EXPECT_EQ(html.find("normalised point source sensitivity"), std::string::npos);
  EXPECT_NE(html.find("of 2026-01-02"), std::string::npos);
}

TEST_F(ReportPage, FetchesNothing) {
  write(folder_.file("a.svg"),
        "<?xml version=\"1.0\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"><use xlink:href=\"#a\"/></svg>");
  const std::string html = page_with({{"aberfit", 1}}, {{"a", "a.svg", "Title", "Caption.", "Alt."}});
  EXPECT_EQ(fetched_by(html), std::vector<std::string>{});
  EXPECT_EQ(html.find("<?xml"), std::string::npos);
  EXPECT_NE(html.find("<svg xmlns"), std::string::npos);
  EXPECT_NE(html.find("aria-label=\"Alt.\""), std::string::npos);
  EXPECT_EQ(fetched_by("<img src='http://a/b.png'><script>"),
            (std::vector<std::string>{"http://a/b.png", "script"}));
}

TEST_F(ReportPage, ShowsTextOfUsersAsText) {
  const std::string html =
      page_with({{"aberfit", 1}, {"title", "<b>&\"'"}, {"description", "<script>alert(1)</script>"}});
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<b>"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;"), std::string::npos);
}

// RFC 4648, section 10.
TEST_F(ReportPage, HasPngsInBase64) {
  const std::pair<const char*, const char*> kPairs[] = {
      {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foob", "Zm9vYg=="}, {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : kPairs) {
    write(folder_.file("a.png"), bytes);
    const std::string html = page_with({{"aberfit", 1}}, {{"a", "a.png", "Title", "Caption.", "Alt."}});
    EXPECT_NE(html.find(std::string("base64,") + text + "\""), std::string::npos) << bytes;
  }
}

TEST_F(ReportPage, StaysBelowThreeMegabytes) {
  write(folder_.file("small.png"), std::string(1000, 'x'));
  write(folder_.file("large.png"), std::string(2500000, 'x'));
  const std::string html = page_with({{"aberfit", 1}}, {{"large", "large.png", "Large", "Caption.", "Alt."},
                                                        {"small", "small.png", "Small", "Caption.", "Alt."}});
  EXPECT_LT(html.size(), 3000000u);
  EXPECT_NE(html.find("See the file large.png."), std::string::npos);
  EXPECT_EQ(html.find("See the file small.png."), std::string::npos);
}

TEST_F(ReportPage, PutsResultsSideBySide) {
  const Json one = to_json(sample_result(), {{"aberfit", 1}, {"mirror", {{"focal_length", 2.8}}}});
  Json two = one;
  two["study"]["mirror"]["focal_length"] = 3.5;
  two["fit"]["rank"] = one["fit"]["rank"].get<int>() + 7;
  const std::string html = html_of(std::vector<ComparedResult>{{"a", one, "a/report.html"}, {"b", two, ""}});
  EXPECT_NE(html.find("/mirror/focal_length"), std::string::npos);
  EXPECT_NE(html.find("Where the results come from"), std::string::npos);
  EXPECT_EQ(html.find("What all studies specify"), std::string::npos);  // their only block differs
  EXPECT_NE(html.find("<code>fit.rank</code>"), std::string::npos);
  EXPECT_EQ(html.find("<code>fit.evaluations</code>"), std::string::npos);  // the same in both
  EXPECT_EQ(fetched_by(html), std::vector<std::string>{"a/report.html"});   // a link that a reader may follow
  EXPECT_EQ(html.find("{{"), std::string::npos);
}
