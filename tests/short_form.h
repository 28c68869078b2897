#pragma once
#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

/// A test whose whole takes more than a few seconds: `TEST_WITH_SHORT_FORM(Suite, Name) { ... }` is
/// `Suite.Name` with `whole` false, of each day, and `FullStatistics.SuiteName` with `whole` true, of `ctest
/// -C statistics -L statistics`.
#define TEST_WITH_SHORT_FORM(Suite, Name)                            \
  struct Suite##Name##Body : ::testing::Test {                       \
    static void of(bool whole);                                      \
  };                                                                 \
  TEST(Suite, Name) { Suite##Name##Body::of(false); }                \
  TEST(FullStatistics, Suite##Name) { Suite##Name##Body::of(true); } \
  void Suite##Name##Body::of([[maybe_unused]] bool whole)

namespace aberfit::test {

/// All of a list, or only what stands at `few` of its places: what a short form looks at.
template <class T>
std::vector<T> all_or_few(bool all, std::vector<T> list, std::initializer_list<std::size_t> few) {
  if (all) return list;
  std::vector<T> chosen;
  for (const std::size_t i : few) chosen.push_back(list.at(i));
  return chosen;
}

}  // namespace aberfit::test
