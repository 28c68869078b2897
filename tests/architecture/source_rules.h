#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace aberfit::test {

/// Rooms in include order (src/README.md): each may include itself and those before it.
const std::vector<std::string>& rooms();

/// Checks the includes of a file. Returns one sentence with file and line per #include that breaks the rules.
/// file: path below `root`, in include/aberfit/<room>, src/<room>, src (the program) or
/// include/aberfit/aberfit.h, which includes public headers and nothing else; text: its contents. Local
/// includes are looked up on disc, beside the file.
std::vector<std::string> violations(const std::filesystem::path& root, const std::filesystem::path& file,
                                    const std::string& text);

/// Public headers that aberfit.h does not include, and rooms that are out of order there, one sentence each.
/// files: sources and headers by their paths below the root; text: of aberfit.h.
std::vector<std::string> missing_from_umbrella(const std::vector<std::filesystem::path>& files,
                                               const std::string& text);

/// Functions of more than kLongestFunction lines, one sentence each with file and line. A function extends
/// from the first line of its signature (for a template from `template`, without the comment) to its closing
/// brace. It is found by the indentation of clang-format: none at namespace level, two columns as a member of
/// a class there.
std::vector<std::string> long_functions(const std::filesystem::path& file, const std::string& text);
inline constexpr std::size_t kLongestFunction = 80;

/// Rooms that hold more than kLargestShare of all lines, one sentence each.
/// lines: of every source file, by its path below the root.
std::vector<std::string> large_rooms(const std::map<std::filesystem::path, std::size_t>& lines);
inline constexpr double kLargestShare = 0.15;

/// Finds places where a file above the method copies or changes a Study or a Task. Returns one sentence with
/// file and line for each. A study stays as it was read; other values are passed beside it. Allowed are const
/// references and pointers, and a const object straight from the function that makes it. Only files of chart,
/// commands and the program are checked.
std::vector<std::string> changed_studies(const std::filesystem::path& file, const std::string& text);

/// Finds names that a header lets out of their room. Returns one sentence with file and line for each. A
/// header in src/<room> declares in aberfit::internal; in aberfit itself it may only define what a class
/// there has named, `struct Public::Part { ... }`. A header in include/ may declare classes of
/// aberfit::internal without defining them, and mention those in the private part of its own. Neither opens a
/// namespace to all who include it (`using namespace`). Other files may do as they like.
std::vector<std::string> leaked_names(const std::filesystem::path& file, const std::string& text);

/// Codes of the warnings in a source: words in lower case with dashes that open the braces of an element
/// pushed back, of a `return {{`, or of an assignment to `warning`, also if `? :` chooses between two. Other
/// lists of such words (formats, choices of a study) do not count.
std::vector<std::string> warning_codes(const std::string& text);

/// The comments of a source; the rest is blank, on the same lines.
std::string comments_of(const std::string& text);

/// Entries of the top level that do not belong there. names: files and folders of the top level, without
/// those that git ignores.
std::vector<std::string> out_of_place(const std::vector<std::string>& names);

}  // namespace aberfit::test
