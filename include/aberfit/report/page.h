#pragma once
#include <string>
#include <variant>
#include <vector>

#include "aberfit/core/warning.h"

namespace aberfit {

/// A result for people. A page is made once and shown as text on a terminal, as Markdown, and as HTML in
/// `report.html`.
struct Page {
  enum class Tone { kPlain, kGood, kOpen, kBad };

  /// A paragraph with a short label, such as "Scene". With an empty label it continues the one before.
  struct Text {
    std::string label, text;
  };
  /// A table with formatted cells.
  struct Table {
    struct Row {
      std::vector<std::string> cells;  ///< a single cell is a heading of the rows that follow
      Tone tone = Tone::kPlain;
    };
    std::string title;
    std::vector<std::string> heads;  ///< empty: a table of labels and values
    std::string align;               ///< "l" or "r" for each column
    std::vector<Row> rows = {};
    std::string note = {};  ///< below the table

    void add(std::vector<std::string> cells, Tone tone = Tone::kPlain) {
      rows.push_back({std::move(cells), tone});
    }
  };
  /// Text that keeps its lines, such as a block to paste.
  struct Verbatim {
    std::string title, text;
  };
  using Part = std::variant<Text, Table, Verbatim>;

  std::string headline;  ///< the answer; empty if there is no question
  Tone tone = Tone::kPlain;
  std::vector<std::string> advice;  ///< next steps, one sentence each
  std::vector<Text> answers;        ///< certainty, basis and remedies; documents only
  std::string title;                ///< title of the study
  std::vector<Part> parts;
  Warnings warnings;

  void say(std::string label, std::string text) { parts.push_back(Text{std::move(label), std::move(text)}); }
};

struct TextStyle {
  std::size_t width = 100;  ///< longest line [characters]; tables may be wider
  bool colour = false;      ///< escape sequences of ANSI terminals
};

/// The page as plain text.
std::string text_of(const Page& page, const TextStyle& style = {});

/// The page as GitHub-flavoured Markdown.
std::string markdown_of(const Page& page);

}  // namespace aberfit
