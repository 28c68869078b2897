#pragma once
#include <string>
#include <vector>

namespace aberfit::internal {

struct NamedPurpose {
  std::string name, purpose;
};

/// The files of a folder of results with their purpose, in the order of interest. The files of pictures are
/// one entry.
std::vector<NamedPurpose> files_with_purpose(const std::string& folder);

/// Instructions to use terms and scatter in other programs, for the files in the folder; empty if there are
/// no terms.
std::vector<NamedPurpose> uses_of_terms(const std::string& folder);

}  // namespace aberfit::internal
