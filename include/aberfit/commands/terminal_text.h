#pragma once
#include <cstdio>
#include <string>
#include <string_view>

/// Text for a terminal, as wide as the terminal, and in colour if it has colours.
namespace aberfit {

/// Number of columns on standard output: COLUMNS if it is set, otherwise the width of the terminal, otherwise
/// 80; always 40 to 120.
int text_width();

/// The text with lines of at most `width` characters, broken at blanks; every line but the first begins with
/// `indent` blanks. Words longer than that stay whole. Characters are counted, not bytes of UTF-8.
std::string wrapped(std::string_view text, int width, int indent = 0);

/// Returns whether escape sequences may be written to `stream`: it is a terminal, and TERM is neither empty
/// nor dumb.
bool takes_escapes(std::FILE* stream);

/// Returns whether, in addition, NO_COLOR is not set.
bool takes_colour(std::FILE* stream);

enum class Tone { kStrong, kGood, kDoubtful, kBad };
/// The text in bold, green, yellow or red if takes_colour(stream), otherwise unchanged.
std::string toned(std::string_view text, Tone tone, std::FILE* stream);

}  // namespace aberfit
