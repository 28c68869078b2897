#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "study/run_program.h"
#include "study/scratch_folder.h"

// The pages show commands and their output, shortened at "...". Here the commands are run in a folder that
// holds only the project's fits and examples. Their output must contain what the pages show.
namespace aberfit::test {
namespace {

struct Block {
  std::string language, text;
};

std::vector<Block> blocks_of(const std::string& page) {
  std::vector<Block> blocks;
  bool inside = false;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      inside = !inside;
      if (inside) blocks.push_back({line.substr(3), ""});
    } else if (inside) {
      blocks.back().text += line + "\n";
    }
  }
  return blocks;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Words must be equal, except at the end of a sentence; numbers agree to 2 % or 0.011, because processors
// round differently.
bool alike(std::string shown, std::string printed) {
  for (std::string* word : {&shown, &printed}) word->erase(word->find_last_not_of(",;:.") + 1);
  if (shown == printed) return true;
  const auto number = [](const std::string& word, double* value) {
    char* end = nullptr;
    *value = std::strtod(word.c_str(), &end);
    return end != word.c_str() && std::string(end).find_first_not_of("%)") == std::string::npos;
  };
  double a = 0, b = 0;
  return number(shown, &a) && number(printed, &b) &&
         std::abs(a - b) <= std::max(0.011, 0.02 * std::max(std::abs(a), std::abs(b)));
}

// The first piece of `shown` (a line, or the text between its dots) that does not follow the earlier pieces
// in `printed`; empty: all are there.
std::string missing_piece(const std::string& shown, const std::string& printed) {
  const std::vector<std::string> all = words_of(printed);
  auto at = all.begin();
  std::istringstream lines(shown);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::vector<std::string>> pieces(1);
    for (const std::string& word : words_of(line)) {
      if (word.find("...") == std::string::npos)
        pieces.back().push_back(word);
      else
        pieces.emplace_back();
    }
    for (const std::vector<std::string>& piece : pieces) {
      at = std::search(at, all.end(), piece.begin(), piece.end(),
                       [](const auto& word, const auto& of_page) { return alike(of_page, word); });
      if (at == all.end() && !piece.empty()) return fmt::format("{}", fmt::join(piece, " "));
      at += std::ptrdiff_t(piece.size());
    }
  }
  return "";
}

class PageRuns : public ::testing::Test {
 protected:
  PageRuns() {
    for (const char* name : {"fits", "examples"})
      std::filesystem::create_symlink(std::filesystem::path(ABERFIT_SOURCE_DIR) / name, folder_.file(name));
    const std::string programs = std::filesystem::path(ABERFIT_PROGRAM).parent_path();
    setenv("PATH", (programs + ":" + std::getenv("PATH")).c_str(), 1);
  }

  // Runs the commands of `script` in one shell and returns what they print.
  std::string printed_by(const std::string& script) {
    folder_.write("block.sh", "set -e\n" + script);
    const int status =
        std::system(("cd '" + folder_.file("") + "' && bash block.sh > stdout.txt 2> stderr.txt").c_str());
    EXPECT_EQ(status, 0) << script << read_file(folder_.file("stderr.txt"));
    return read_file(folder_.file("stdout.txt"));
  }

  void run(const std::string& page, int least_shown) {
    std::string printed;
    int shown = 0;
    for (const Block& block : blocks_of(read_file(std::string(ABERFIT_SOURCE_DIR) + "/" + page))) {
      if (block.language == "json")
        printed = printed_by("aberfit fit " + folder_.write("study.json", block.text));
      // Other tests install, build and run the examples.
      const bool installs =
          block.text.find("bash ") != std::string::npos || block.text.find("cmake ") != std::string::npos;
      if (block.language == "sh" && !installs) printed = printed_by(block.text);
      const bool is_output = block.language == "text" && !printed.empty();
      if (!is_output) continue;
      EXPECT_EQ(missing_piece(block.text, printed), "") << page << " shows\n"
                                                        << block.text << "printed is\n"
                                                        << printed;
      ++shown;
    }
    EXPECT_GE(shown, least_shown) << page;
  }

  ScratchFolder folder_;
};

}  // namespace

TEST_F(PageRuns, TheFirstPageShowsWhatItsStudyPrints) { run("README.md", 1); }
TEST_F(PageRuns, TheTutorialShowsWhatItsCommandsPrint) { run("examples/README.md", 5); }

TEST(PageBlocks, WordsAndNumbersAreComparedPieceByPiece) {
  EXPECT_EQ(missing_piece("a 1.00 ... c", "x a 1.01 b c"), "");
  EXPECT_EQ(missing_piece("a 1.00 ... c", "x a 1.20 b c"), "a 1.00");
  EXPECT_EQ(missing_piece("c ... a", "a b c"), "a");
  EXPECT_EQ(missing_piece("12.2 %, then", "12.21 %, then"), "");
  EXPECT_EQ(missing_piece("12.2 nm", "12.2 um"), "12.2 nm");
}

}  // namespace aberfit::test
