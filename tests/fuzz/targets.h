#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// The fuzz targets: readers of texts and files that others wrote, each as a function of bytes. libFuzzer
/// calls them with bytes of its own (fuzz_main.cpp), replay/ with bytes that once made them fail.
namespace aberfit::test {

struct FuzzTarget {
  std::string name;  ///< and of its folder in corpus/
  /// Reads the bytes. Errors meant for a user are caught. All others are thrown on, and a broken promise of
  /// the reader throws a std::logic_error.
  std::function<void(std::string_view bytes)> read;
  std::function<std::vector<std::string>()> seeds;  ///< good inputs of every kind to begin with
  std::size_t longest = 4096;                       ///< inputs longer than this are not tried [bytes]
};

std::vector<FuzzTarget> unit_targets();      ///< quantities and units
std::vector<FuzzTarget> measured_targets();  ///< one per format of measured files, and masks
std::vector<FuzzTarget> table_targets();     ///< PSD tables, coefficients, focal data, sweeps
std::vector<FuzzTarget> study_targets();     ///< studies
std::vector<FuzzTarget> psd_targets();       ///< options of `aberfit psd`

/// All of them.
inline std::vector<FuzzTarget> fuzz_targets() {
  std::vector<FuzzTarget> all;
  for (const auto& part :
       {unit_targets(), measured_targets(), table_targets(), study_targets(), psd_targets()})
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace aberfit::test
