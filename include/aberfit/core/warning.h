#pragma once
#include <string>
#include <vector>

namespace aberfit {

/// Something the reader of a result must know: a stable kebab-case code for programs, a sentence for people.
struct Warning {
  std::string code;
  std::string message;
};
using Warnings = std::vector<Warning>;

}  // namespace aberfit
