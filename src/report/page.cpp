#include "aberfit/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "aberfit/core/overloaded.h"
#include "aberfit/core/text.h"
#include "paragraph.h"

namespace aberfit {
using namespace internal;

namespace {

// Number of characters of a UTF-8 text on a terminal.
std::size_t shown_width(const std::string& text) {
  return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string space(width - std::min(width, shown_width(text)), ' ');
  return right ? space + text : text + space;
}

std::string coloured(const std::string& text, Page::Tone tone, bool colour) {
  const char* code = tone == Page::Tone::kGood ? "32" : tone == Page::Tone::kBad ? "31" : "33";
  return colour && tone != Page::Tone::kPlain ? fmt::format("\033[1;{}m{}\033[0m", code, text) : text;
}

bool is_heading(const Page::Table& table, const Page::Table::Row& row) {
  return row.cells.size() == 1 && table.align.size() > 1;
}

std::vector<std::size_t> widths_of(const Page::Table& table) {
  std::vector<std::size_t> widths(table.align.size());
  const auto grow = [&](const std::vector<std::string>& cells) {
    for (std::size_t k = 0; k < std::min(cells.size(), widths.size()); ++k)
      widths[k] = std::max(widths[k], shown_width(cells[k]));
  };
  grow(table.heads);
  for (const Page::Table::Row& row : table.rows)
    if (!is_heading(table, row)) grow(row.cells);
  return widths;
}

// A long text in the last column continues below in the same column.
std::string line_of(const std::vector<std::string>& cells, const Page::Table& table,
                    const std::vector<std::size_t>& widths, std::size_t width) {
  std::string line;
  std::size_t column = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    line += "  ", column += 2;
    const bool last = k + 1 == widths.size(), right = table.align[k] == 'r';
    if (last && !right) {
      constexpr std::size_t kLeast = 30;
      line += wrapped(cells[k], std::max(kLeast, width - std::min(width, column)), column);
    } else {
      line += padded(cells[k], widths[k], right);
    }
    column += widths[k];
  }
  const std::size_t end = line.find_last_not_of(' ');
  return (end == std::string::npos ? "" : line.substr(0, end + 1)) + "\n";
}

struct AsText {
  const TextStyle& style;

  std::string operator()(const Page::Text& part) const {
    return paragraph(part.label, part.text, kIndent, style.width);
  }
  std::string operator()(const Page::Table& table) const {
    const std::vector<std::size_t> widths = widths_of(table);
    std::string out = "\n";
    if (!table.title.empty()) out += paragraph("", table.title, 0, style.width);
    if (!table.heads.empty()) out += line_of(table.heads, table, widths, style.width);
    for (const Page::Table::Row& row : table.rows)
      out += is_heading(table, row)
                 ? row.cells[0] + "\n"
                 : coloured(line_of(row.cells, table, widths, style.width), row.tone, style.colour);
    return table.note.empty() ? out : out + paragraph("", table.note, 2, style.width);
  }
  std::string operator()(const Page::Verbatim& part) const {
    return "\n" + (part.title.empty() ? "" : paragraph("", part.title, 0, style.width)) + part.text +
           (part.text.ends_with('\n') ? "" : "\n");
  }
};

// A cell of a Markdown table.
std::string cell_of(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

struct AsMarkdown {
  std::string operator()(const Page::Text& part) const {
    return (part.label.empty() ? "" : "**" + part.label + "** ") + part.text + "\n\n";
  }
  std::string operator()(const Page::Table& table) const {
    const auto row = [](const std::vector<std::string>& cells) {
      std::string line = "|";
      for (const std::string& cell : cells) line += " " + cell_of(cell) + " |";
      return line + "\n";
    };
    std::string out = table.title.empty() ? "" : "### " + table.title + "\n\n";
    out += row(table.heads.empty() ? std::vector<std::string>(table.align.size()) : table.heads) + "|";
    for (const char side : table.align) out += side == 'r' ? "---:|" : "---|";
    out += "\n";
    for (const Page::Table::Row& line : table.rows) {
      std::vector<std::string> cells = line.cells;
      if (is_heading(table, line)) cells[0] = "**" + cells[0] + "**";
      cells.resize(table.align.size());
      out += row(cells);
    }
    return out + "\n" + (table.note.empty() ? "" : table.note + "\n\n");
  }
  std::string operator()(const Page::Verbatim& part) const {
    return (part.title.empty() ? "" : part.title + "\n\n") + "```json\n" + part.text +
           (part.text.ends_with('\n') ? "" : "\n") + "```\n\n";
  }
};

}  // namespace

std::string text_of(const Page& page, const TextStyle& style) {
  std::string out;
  if (!page.headline.empty()) {
    out = coloured(paragraph("", page.headline, 0, style.width), page.tone, style.colour);
    for (const std::string& sentence : page.advice) out += paragraph("", sentence, 0, style.width);
    out += std::string(style.width, '-') + "\n";
  }
  if (!page.title.empty()) out += paragraph("Study", page.title, kIndent, style.width);
  for (const Page::Part& part : page.parts) out += std::visit(AsText{style}, part);
  if (!page.warnings.empty()) out += "\n";
  for (const Warning& warning : page.warnings)
    out += coloured(paragraph("WARNING", "[" + warning.code + "] " + warning.message, kIndent, style.width),
                    Page::Tone::kOpen, style.colour);
  return out;
}

std::string markdown_of(const Page& page) {
  std::string out;
  if (!page.title.empty()) out += "# " + page.title + "\n\n";
  if (!page.headline.empty()) out += "**" + page.headline + "**\n\n";
  for (const std::string& sentence : page.advice) out += sentence + "\n\n";
  for (const Page::Part& part : page.parts) out += std::visit(AsMarkdown{}, part);
  for (const Warning& warning : page.warnings)
    out += "> **" + warning.code + "**: " + warning.message + "\n\n";
  return out;
}

}  // namespace aberfit
