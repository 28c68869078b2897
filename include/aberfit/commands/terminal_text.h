#pragma once
#include <cstdio>
#include <string>
#include <string_view>

/// Text for people at a terminal: as wide as it is, and in colour where it has colours.
namespace aberfit {

/// Columns of text on standard output: COLUMNS where it is set, else the width of the terminal, else 80;
/// always 40 to 120.
int text_width();

/// The text with lines of at most `width` characters, broken at blanks; every line but the first begins with
/// `indent` blanks. Words longer than that stay whole. Characters are counted, not bytes of UTF-8.
std::string wrapped(std::string_view text, int width, int indent = 0);

/// Whether escape sequences may be written to `stream`: it is a terminal, and TERM is neither empty nor dumb.
bool takes_escapes(std::FILE* stream);

/// The same, and NO_COLOR is not set.
bool takes_colour(std::FILE* stream);

enum class Tone { kStrong, kGood, kDoubtful, kBad };
/// The text in bold, green, yellow or red where `stream` takes escapes and NO_COLOR is not set, else as it
/// is.
std::string toned(std::string_view text, Tone tone, std::FILE* stream);

}  // namespace aberfit
