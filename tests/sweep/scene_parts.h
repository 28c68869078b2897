#pragma once
#include <cmath>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <random>
#include <string>

namespace aberfit {

/// Random numbers for scenes. They are the same on every machine, unlike the distributions of std.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * (double(bits_() >> 11) * 0x1p-53); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int whole(int low, int high) { return int(uniform(low, high + 1)); }  ///< both included

 private:
  std::mt19937_64 bits_;
};

struct Band {
  double low = 0, high = 0;  ///< [cycles/m]
};

/// Corners of a hexagon about the axis, `across` from one to the opposite one [m].
nlohmann::json hexagon(double across);
/// A rectangle with a diagonal of `across` [m] that is `angle` [rad] from x.
nlohmann::json rectangle(double across, double angle);
/// Text of a table of a power law with a shoulder, as polishing leaves it, with the RMS height `rms` [m]: 40
/// points of frequency [cycles/m] and 2-D PSD [m^4].
std::string shouldered_table(const Band& band, double rms, Dice* dice);

}  // namespace aberfit
