#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace aberfit::test {

/// Rooms in include order (DESIGN): each may include itself and those before it.
const std::vector<std::string>& rooms();

/// What the rules say against a file: one sentence per #include that breaks them, naming file and line; empty
/// when all is well. file: path below `root`, in include/aberfit/<room>, src/<room> or src/main.cpp; text:
/// its contents. Local includes are looked up on disc, beside the file.
std::vector<std::string> violations(const std::filesystem::path& root, const std::filesystem::path& file,
                                    const std::string& text);

/// Entries of the top level that have no place there.
/// names: files and folders of the top level, without what git ignores.
std::vector<std::string> out_of_place(const std::vector<std::string>& names);

}  // namespace aberfit::test
