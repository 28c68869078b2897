#include "aberfit/report/page.h"

#include <gtest/gtest.h>

#include <sstream>

using namespace aberfit;

namespace {

Page sample() {
  Page page;
  page.headline = "EQUIVALENT by wave optics";
  page.tone = Page::Tone::kGood;
  page.advice = {"Take the terms."};
  page.title = "A mirror";
  page.say("Scene", "a circle");
  Page::Table table{"Values", {"name", "value"}, "lr"};
  table.add({"ee50", "1.000 um"});
  table.add({"In other planes"});
  table.add({"a|b", "12.00 um"}, Page::Tone::kBad);
  page.parts.push_back(table);
  page.parts.push_back(Page::Verbatim{"For a study:", "{\"psd\": 1}"});
  page.warnings = {{"unusual", "too large"}};
  return page;
}

}  // namespace

TEST(Page, IsTextWithColumnsThatLineUp) {
  EXPECT_EQ(text_of(sample(), {40, false}),
            "EQUIVALENT by wave optics\nTake the terms.\n----------------------------------------\n"
            "Study     A mirror\nScene     a circle\n\nValues\n"
            "  name     value\n  ee50  1.000 um\nIn other planes\n  a|b   12.00 um\n\n"
            "For a study:\n{\"psd\": 1}\n\nWARNING   [unusual] too large\n");
}

TEST(Page, BreaksLongTextAtTheWidth) {
  Page page;
  page.say("Why", std::string(30, 'a') + " " + std::string(30, 'b') + " " + std::string(30, 'c'));
  Page::Table table{"", {}, "ll"};
  table.add({"label", std::string(25, 'd') + " " + std::string(25, 'e')});
  page.parts.push_back(table);
  std::istringstream lines(text_of(page, {50, false}));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 50u) << line;
}

TEST(Page, HasEscapesInColourAlone) {
  EXPECT_EQ(text_of(sample()).find('\033'), std::string::npos);
  const std::string coloured = text_of(sample(), {100, true});
  EXPECT_EQ(coloured.find("\033[1;32mEQUIVALENT"), 0u);
  EXPECT_NE(coloured.find("\033[1;31m  a|b"), std::string::npos);
}

TEST(Page, IsMarkdownThatKeepsBars) {
  const std::string text = markdown_of(sample());
  EXPECT_NE(text.find("| name | value |\n|---|---:|\n| ee50 | 1.000 um |\n"), std::string::npos) << text;
  EXPECT_NE(text.find("| **In other planes** |  |\n| a\\|b | 12.00 um |"), std::string::npos) << text;
  EXPECT_NE(text.find("> **unusual**: too large"), std::string::npos);
}
