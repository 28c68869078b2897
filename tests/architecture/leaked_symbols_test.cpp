// Code that is compiled for one instruction set must not be linked into code for every machine. In units that
// compile Eigen for a set, a symbol that other units may also have must be in that set's own namespace.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace {

// A line of `nm -A -C`: "library:member:address kind name".
struct Symbol {
  std::string member, name;
  char kind;
};

std::vector<Symbol> symbols_of(const std::string& library) {
  const std::string command = std::string(ABERFIT_NM) + " -A -C '" + library + "' 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 65536> buffer;
  while (const std::size_t read = pipe ? std::fread(buffer.data(), 1, buffer.size(), pipe.get()) : 0)
    text.append(buffer.data(), read);
  std::vector<Symbol> symbols;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos || second + 20 > line.size()) continue;
    symbols.push_back(
        {line.substr(first + 1, second - first - 1), line.substr(second + 20), line[second + 18]});
  }
  return symbols;
}

TEST(LeakedSymbols, EigenOfAnInstructionSetStaysInItsNamespace) {
  const std::vector<Symbol> symbols = symbols_of(ABERFIT_LIBRARY);
  ASSERT_FALSE(symbols.empty()) << ABERFIT_NM << " of " << ABERFIT_LIBRARY;
  std::set<std::string> members;
  int shared = 0;
  for (const Symbol& symbol : symbols) {
    if (symbol.member.find("eigen_kernels_avx") == std::string::npos) continue;
    members.insert(symbol.member);
    // The linker merges symbols of kinds W, w, V, v and u by name. DW.ref is data of the unwinder.
    if (std::string("WwVvu").find(symbol.kind) == std::string::npos || symbol.name.rfind("DW.ref.", 0) == 0)
      continue;
    ++shared;
    EXPECT_NE(symbol.name.find("aberfit_eigen_avx"), std::string::npos)
        << symbol.member << ": " << symbol.name;
  }
  if (members.empty()) GTEST_SKIP() << "this processor's library has Eigen for one instruction set only";
  EXPECT_EQ(members.size(), 2u);
  EXPECT_GT(shared, 10);  // else nothing was tested
}

}  // namespace
