// Comments and pages refer only to pages, sections and files that a clone has.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "page_rules.h"
#include "source_text.h"

namespace aberfit::test {
namespace {

namespace fs = std::filesystem;

// Texts that people read, as paths below the root: sources, pages and build files, without others' data.
std::vector<fs::path> readings() {
  std::vector<fs::path> found = {"README.md", "CMakeLists.txt"};
  for (const char* folder : {"include", "src", "tests", "examples", "fits"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const fs::path file = fs::relative(entry.path(), kRoot);
      const std::string end = file.extension().string();
      const bool read = end == ".h" || end == ".cpp" || end == ".inc" || end == ".md" ||
                        file.filename() == "CMakeLists.txt";
      if (entry.is_regular_file() && read && !file.string().starts_with("tests/data/")) found.push_back(file);
    }
  std::sort(found.begin(), found.end());
  return found;
}

Pages pages() {
  Pages all;
  for (const fs::path& file : readings())
    if (file.extension() == ".md") {
      all.files.insert(file);
      const std::set<int> sections = sections_of(contents(kRoot / file));
      if (!sections.empty()) all.sections[file.stem().string()].insert(sections.begin(), sections.end());
    }
  return all;
}

TEST(Pages, EveryReferenceLeadsToAPageAndSectionOfTheRepository) {
  const Pages all = pages();
  // Pages and sections must have been found; an empty list would pass wrongly.
  EXPECT_TRUE(all.files.contains("include/aberfit/FORMATS.md"));
  EXPECT_EQ(all.sections.at("PHYSICS"), (std::set<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  for (const fs::path& file : readings()) {
    const std::vector<std::string> found = lost_references(all, file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
  }
}

TEST(Pages, EveryLinkLeadsToAFile) {
  for (const fs::path& file : pages().files) {
    const std::vector<std::string> found = broken_links(kRoot, file, contents(kRoot / file));
    EXPECT_TRUE(found.empty()) << joined(found);
  }
}

// Tests the rules themselves: each breach is reported, its permitted neighbour is not.
TEST(PageRules, FindTheNumbersOfSections) {
  EXPECT_EQ(sections_of("# 1. A\ntext ## 2. no\n\n## 3. C\n### 12. D\n## 4 no\n## Five\n5. no\n"),
            (std::set<int>{1, 3, 12}));
}

TEST(PageRules, TellReferencesThatLeadNowhere) {
  Pages some;
  some.files = {"README.md", "src/CHANGES.md", "include/aberfit/PHYSICS.md"};
  some.sections["PHYSICS"] = {1, 2, 10};
  struct Case {
    const char* file;
    const char* text;     // its breach begins on the second line
    const char* problem;  // empty: allowed
  };
  const Case cases[] = {
      {"src/fit/a.h", "\n/// As PHYSICS 2, and (PHYSICS 10): 0.5 % and 3 of them.\n", ""},
      {"src/fit/a.h", "\n/// PHYSICS 3\n", "PHYSICS has no section 3"},
      {"src/fit/a.h", "\nint a;  ///< (PHYSICS 11; Noll 1976)\n", "PHYSICS has no section 11"},
      {"src/fit/a.h", "\n/// PHYSICS 1 and 2.\n", ""},
      {"src/fit/a.h", "\n/// PHYSICS 1 and 4.\n", "PHYSICS has no section 4"},
      {"src/fit/a.cpp", "\n  // where PHYSICS\n  // 10 says\n", ""},
      {"src/fit/a.cpp", "\n  // where PHYSICS\n  // 12 says\n", "PHYSICS has no section 12"},
      {"src/fit/a.inc", "\n/* PHYSICS.md, section 7 */\n", "PHYSICS has no section 7"},
      {"src/fit/a.cpp", "\nf(\"PHYSICS 3\", R\"(DESIGN)\");  // not in a comment\n", ""},
      {"src/fit/a.cpp", "\n// PHYSICS 2 cm wide? 0.3 PHYSICS. 7\n", ""},
      {"src/fit/a.cpp", "\n// as FORMATS says\n", "FORMATS is no page"},
      {"src/fit/a.cpp", "\n// the table (DESIGN: rooms)\n", "DESIGN is no page"},
      {"src/fit/a.cpp", "\n// STYLE\n", "STYLE is no page"},
      {"src/fit/a.cpp", "\n// ELLIPSE_DESIGN_P, DESIGNS, FITS and JSON are no pages\n", ""},
      {"src/fit/a.cpp", "\n// see README.md and src/CHANGES.md, or PHYSICS.md 2\n", ""},
      {"src/fit/a.cpp", "\n// see THEORY.md\n", "THEORY is no page"},
      {"src/fit/a.cpp", "\n// see src/README.md\n", "src/README is no page"},
      {"CMakeLists.txt", "\n# DESIGN\n", "DESIGN is no page"},
      {"src/CHANGES.md", "\nPHYSICS 4, `DESIGN_P`\n", "PHYSICS has no section 4"},
      {"src/CHANGES.md", "\n[the page](../include/aberfit/PHYSICS.md), section 2; section 9 of theirs\n", ""},
      {"src/CHANGES.md", "\n[the page](../include/aberfit/PHYSICS.md), section 9\n", "no section 9"},
      {"src/CHANGES.md", "\n[the page](../aberfit/PHYSICS.md)\n", "../aberfit/PHYSICS is no page"},
      {"include/aberfit/PHYSICS.md", "\nas in section 2, sections 1 and 10\n", ""},
      {"include/aberfit/PHYSICS.md", "\nas in\nsection 5\n", "PHYSICS has no section 5"},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(c.file) + ": " + c.text);
    const std::vector<std::string> found = lost_references(some, c.file, c.text);
    EXPECT_EQ(found.size(), *c.problem ? 1u : 0u) << joined(found);
    EXPECT_NE(joined(found).find(c.problem), std::string::npos) << joined(found);
  }
  EXPECT_EQ(lost_references(some, "src/fit/a.h", "int a;\n\n/// PHYSICS 3\n"),
            std::vector<std::string>{"src/fit/a.h:3: PHYSICS has no section 3"});
}

TEST(PageRules, TellLinksThatLeadNowhere) {
  struct Case {
    const char* text;
    bool is_broken;
  };
  const Case cases[] = {
      {"[all](../../README.md) of it", false},
      {"![a picture](../../fits/README.md)", false},
      {"[a folder](theory) and [a place](../../README.md#accuracy-and-speed)", false},
      {"[here](#there), [outside](https://example.org/a.md), [mail](mailto:a@example.org)", false},
      {"`[no](link.md)` and\n```\n[nor](this.md)\n```\n", false},
      {"[a lambda](int) is one, f[i](x, y) is none", true},
      {"[gone](../README.md)", true},
      {"![gone](no_picture.png)", true},
      {"[gone](no_page.md#part)", true},
      {"[nothing]()", true},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.text);
    const std::vector<std::string> found = broken_links(kRoot, "include/aberfit/PHYSICS.md", c.text);
    EXPECT_EQ(found.size(), c.is_broken ? 1u : 0u) << joined(found);
  }
  EXPECT_EQ(broken_links(kRoot, "README.md", "a\n[b](c.md)\n"),
            std::vector<std::string>{"README.md:2: [](c.md) leads to no file"});
}

}  // namespace
}  // namespace aberfit::test
