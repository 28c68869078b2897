#pragma once
#include <string>
#include <vector>

namespace aberfit::internal {

struct NamedPurpose {
  std::string name, purpose;
};

/// The files of a folder of results and what each is for, in the order in which people look at them; the
/// files of pictures are one entry.
std::vector<NamedPurpose> files_with_purpose(const std::string& folder);

/// How to use terms and scatter in other programs, for those files that are in the folder; empty where there
/// are no terms.
std::vector<NamedPurpose> uses_of_terms(const std::string& folder);

}  // namespace aberfit::internal
