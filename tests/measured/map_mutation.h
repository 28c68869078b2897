#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <string>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/measured/height_map.h"
#include "study/scratch_folder.h"

namespace aberfit::test {

/// Returns a damaged copy of `original`, a pure function of its arguments. The kinds alternate: flipped bits,
/// overwritten bytes, truncation, an extreme integer in the header (2, 4 or 8 bytes, or digits in a text
/// header), a repeated part, a removed part, a splice with itself.
/// header: number of bytes from the start that are damaged more often.
inline std::string damaged(const std::string& original, std::size_t header, const RandomStream& stream,
                           std::uint64_t index) {
  std::uint64_t draw = index * 64;
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : std::size_t(stream.bits(draw++) % n); };
  std::string bytes = original;
  const auto place = [&] {
    return below(2) == 0 ? below(std::min(header, bytes.size())) : below(bytes.size());
  };
  switch (index % 7) {
    case 0:
      for (std::size_t i = 0, n = 1 + below(4); i < n; ++i) bytes[place()] ^= char(1 << below(8));
      break;
    case 1:
      for (std::size_t i = 0, n = 1 + below(8); i < n; ++i) bytes[place()] = char(below(256));
      break;
    case 2:
      bytes.resize(place());
      break;
    case 3: {
      static const std::string kBinary[] = {std::string(8, '\xff'), std::string(8, '\0'),
                                            "\x7f" + std::string(7, '\xff'), "\x80" + std::string(7, '\0'),
                                            std::string(7, '\0') + "\x01"};
      std::string value = kBinary[below(5)].substr(0, std::size_t(2) << below(3));
      const std::size_t at = below(std::min(header, bytes.size()));
      bytes.replace(at, value.size(), value);
      break;
    }
    case 4: {
      static const std::string kDigits[] = {
          "-1",    "0",   "99999999999", "9223372036854775807", "-9223372036854775808",
          "1e308", "nan", "1e400",       "2147483648"};
      // Replaces a number of the header, if there is one.
      std::size_t at = below(std::min(header, bytes.size()));
      at = std::min(bytes.find_first_of("0123456789", at), bytes.size());
      std::size_t end = at;
      while (end < bytes.size() && bytes[end] >= '0' && bytes[end] <= '9') ++end;
      const std::string& digits = kDigits[below(9)];
      // The length is kept every second time, so that the cards of a FITS header stay aligned.
      const std::size_t length = below(2) == 0 ? end - at : digits.size();
      bytes.replace(at, std::min(length, bytes.size() - at), digits);
      break;
    }
    case 5: {
      const std::size_t from = place(), length = below(200);
      bytes.insert(place(), bytes.substr(from, length));
      break;
    }
    default: {
      const std::size_t from = place();
      bytes.erase(from, below(200));
      break;
    }
  }
  return bytes;
}

struct DamageCount {
  int refused = 0, read = 0;
};

/// Reads `count` damaged copies of `original`. Each must give a map that fits in the file, or an InputError
/// that names the file, what was found and what is allowed.
template <class Reader>
DamageCount read_damaged(const std::string& original, std::size_t header, const std::string& name, int count,
                         const Reader& read) {
  const ScratchFolder folder;
  const RandomStream stream(20260101, name);
  DamageCount result;
  for (int i = 0; i < count; ++i) {
    const std::string bytes = damaged(original, header, stream, std::uint64_t(i));
    const std::string path = folder.write("damaged", bytes);
    try {
      const HeightMap map = read(path);
      EXPECT_LE(std::size_t(map.height.size()), bytes.size()) << name << " " << i;
      ++result.read;
    } catch (const InputError& error) {
      EXPECT_EQ(error.file(), path) << name << " " << i;
      EXPECT_FALSE(error.found().empty()) << name << " " << i;
      EXPECT_FALSE(error.allowed().empty()) << name << " " << i;
      // No control characters; UTF-8 bytes beyond ASCII are printed as they are.
      for (const char c : std::string(error.what())) EXPECT_GE((unsigned char)c, 0x20) << name << " " << i;
      ++result.refused;
    } catch (const std::exception& error) {
      ADD_FAILURE() << name << " " << i << ": " << error.what();
    }
  }
  return result;
}

}  // namespace aberfit::test
