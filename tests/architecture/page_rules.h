#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace aberfit::test {

/// The pages of a repository, to which comments may refer.
struct Pages {
  std::set<std::filesystem::path> files;          ///< .md files below the root
  std::map<std::string, std::set<int>> sections;  ///< by the page's name; pages without numbers have none
};

/// Numbers of a page's headings, `## 3. Of what`.
std::set<int> sections_of(const std::string& page);

/// Finds references to missing pages and sections. Returns one sentence with file and line for each. A
/// reference is a name in capitals with the suffix .md, with or without folders, or one of the names that
/// comments use bare (PHYSICS and its like); the number behind a name, or two joined by `and`, is a section,
/// as it is after the word `section` on a page that has any. Of sources (.h, .cpp, .inc) the comments are
/// read, of all else the whole text. A name without folders may lie anywhere, a name with folders lies below
/// the root or the file's own folder.
std::vector<std::string> lost_references(const Pages& pages, const std::filesystem::path& file,
                                         const std::string& text);

/// Markdown links and pictures, `[text](target)`, whose target is no file or folder; one sentence each.
/// Targets are relative to the page. Those of the web and of the page itself are allowed, and text between
/// backquotes is no link. file: path of the page below `root`.
std::vector<std::string> broken_links(const std::filesystem::path& root, const std::filesystem::path& file,
                                      const std::string& text);

}  // namespace aberfit::test
