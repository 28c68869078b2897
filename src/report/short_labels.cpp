#include "short_labels.h"

#include <algorithm>

namespace aberfit::internal {
namespace {

// The last `words` words of a pointer, or all if it has fewer.
std::string end_of(const std::string& pointer, int words) {
  std::size_t at = pointer.size();
  for (; words > 0 && at > 0 && at != std::string::npos; --words) at = pointer.rfind('/', at - 1);
  return at == std::string::npos ? pointer : pointer.substr(pointer[at] == '/' ? at + 1 : at);
}

}  // namespace

std::vector<std::string> short_labels(const std::vector<std::string>& pointers) {
  std::vector<std::string> labels;
  for (const std::string& pointer : pointers) {
    int words = 1;
    const auto same = [&](const std::string& other) {
      return end_of(other, words) == end_of(pointer, words);
    };
    const int most = int(std::count(pointer.begin(), pointer.end(), '/'));
    while (words < most && std::count_if(pointers.begin(), pointers.end(), same) > 1) ++words;
    labels.push_back(end_of(pointer, words));
  }
  return labels;
}

}  // namespace aberfit::internal
