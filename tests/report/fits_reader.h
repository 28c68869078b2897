#pragma once
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace aberfit::test {

/// One image of a FITS file, read from the standard alone: cards of 80 characters in blocks of 2880,
/// big-endian doubles, the first axis fastest.
struct FitsUnitRead {
  std::map<std::string, std::string> keys;  ///< values without quotes and padding
  std::size_t columns = 0, rows = 1;
  std::vector<double> values;

  double at(std::size_t row, std::size_t column) const { return values.at(row * columns + column); }
  double number(const std::string& key) const { return std::stod(keys.at(key)); }
};

inline std::vector<FitsUnitRead> read_fits_units(const std::string& bytes) {
  constexpr std::size_t kBlock = 2880, kCard = 80;
  const auto next_block = [](std::size_t at) { return (at + kBlock - 1) / kBlock * kBlock; };
  EXPECT_EQ(bytes.size() % kBlock, 0u);
  std::vector<FitsUnitRead> units;
  for (std::size_t at = 0; at < bytes.size();) {
    FitsUnitRead unit;
    for (; bytes.compare(at, kCard, "END" + std::string(kCard - 3, ' ')) != 0; at += kCard) {
      std::string key = bytes.substr(at, 8), value = bytes.substr(at + 10, kCard - 10);
      key.erase(key.find_last_not_of(' ') + 1);
      if (bytes.substr(at + 8, 2) != "= ") continue;  // COMMENT
      if (value[0] == '\'') {
        value = value.substr(1, value.find('\'', 1) - 1);
      } else {
        value = value.substr(0, value.find('/'));
        value.erase(0, value.find_first_not_of(' '));
      }
      value.erase(value.find_last_not_of(' ') + 1);
      EXPECT_TRUE(unit.keys.emplace(key, value).second) << key << " twice";
    }
    at = next_block(at + kCard);
    EXPECT_EQ(unit.keys.at("BITPIX"), "-64");
    unit.columns = std::stoul(unit.keys.at("NAXIS1"));
    if (unit.keys.at("NAXIS") == "2") unit.rows = std::stoul(unit.keys.at("NAXIS2"));
    for (std::size_t k = 0; k < unit.columns * unit.rows; ++k, at += 8) {
      std::uint64_t bits = 0;
      for (std::size_t b = 0; b < 8; ++b) bits = bits << 8 | std::uint8_t(bytes.at(at + b));
      unit.values.push_back(std::bit_cast<double>(bits));
    }
    at = next_block(at);
    units.push_back(std::move(unit));
  }
  return units;
}

}  // namespace aberfit::test
