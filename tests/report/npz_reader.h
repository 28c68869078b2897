#pragma once
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace aberfit::test {

/// An array as numpy.load reads it from a member of the archive.
struct LoadedArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

/// Reads stored zip archives of .npy members from the descriptions of the formats alone (PKWARE's APPNOTE.TXT
/// 4.3, numpy.lib.format): from the end to the directory, from there to each member.
class NpzReader {
 public:
  explicit NpzReader(std::string bytes) : bytes_(std::move(bytes)) {
    const std::size_t end = bytes_.rfind("PK\x05\x06");
    EXPECT_NE(end, std::string::npos);
    EXPECT_EQ(end + 22, bytes_.size()) << "no comment behind the directory";
    const std::size_t count = number(end + 10, 2);
    std::size_t at = number(end + 16, 4);
    EXPECT_EQ(at + number(end + 12, 4), end);
    for (std::size_t k = 0; k < count; ++k) at = read_entry(at);
    EXPECT_EQ(at, end);
  }

  const std::map<std::string, LoadedArray>& arrays() const { return arrays_; }
  const LoadedArray& at(const std::string& name) const { return arrays_.at(name); }

 private:
  std::size_t number(std::size_t at, std::size_t width) const {
    std::size_t value = 0;
    for (std::size_t k = width; k-- > 0;) value = value << 8 | std::uint8_t(bytes_.at(at + k));
    return value;
  }
  // CRC bit by bit, from its polynomial.
  static std::uint32_t crc(const std::string& text) {
    std::uint32_t value = 0xFFFFFFFFu;
    for (const char c : text)
      for (int bit = 0; bit < 8; ++bit) {
        const bool odd = ((value ^ (std::uint32_t(std::uint8_t(c)) >> bit)) & 1) != 0;
        value = odd ? (value >> 1) ^ 0xEDB88320u : value >> 1;
      }
    return ~value;
  }
  std::size_t read_entry(std::size_t at) {
    EXPECT_EQ(number(at, 4), 0x02014b50u);
    EXPECT_EQ(number(at + 10, 2), 0u) << "stored";
    const std::size_t size = number(at + 24, 4), name_size = number(at + 28, 2), local = number(at + 42, 4);
    EXPECT_EQ(number(at + 20, 4), size);
    std::string name = bytes_.substr(at + 46, name_size);
    EXPECT_EQ(number(local, 4), 0x04034b50u);
    EXPECT_EQ(bytes_.substr(local + 30, name_size), name);
    for (const auto& [in_directory, in_local] : {std::pair(16, 14), std::pair(20, 18), std::pair(24, 22)})
      EXPECT_EQ(number(at + std::size_t(in_directory), 4), number(local + std::size_t(in_local), 4));
    const std::string content =
        bytes_.substr(local + 30 + number(local + 26, 2) + number(local + 28, 2), size);
    EXPECT_EQ(content.size(), size);
    EXPECT_EQ(number(at + 16, 4), crc(content)) << name;
    EXPECT_TRUE(name.ends_with(".npy")) << name;
    EXPECT_TRUE(arrays_.emplace(name.substr(0, name.size() - 4), npy(content)).second) << name;
    return at + 46 + name_size + number(at + 30, 2) + number(at + 32, 2);
  }
  static LoadedArray npy(const std::string& content) {
    EXPECT_EQ(content.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    const std::size_t length = std::uint8_t(content[8]) + 256u * std::uint8_t(content[9]);
    EXPECT_EQ((10 + length) % 64, 0u);
    const std::string header = content.substr(10, length);
    EXPECT_EQ(header.back(), '\n');
    EXPECT_NE(header.find("'descr': '<f8'"), std::string::npos);
    EXPECT_NE(header.find("'fortran_order': False"), std::string::npos);
    LoadedArray array;
    const std::size_t open = header.find("'shape': (") + 10, close = header.find(')', open);
    std::size_t count = 1;
    std::string list = header.substr(open, close - open);
    for (std::size_t comma; (comma = list.find(',')) != std::string::npos; list = list.substr(comma + 1)) {
      array.shape.push_back(std::stoul(list.substr(0, comma)));
      count *= array.shape.back();
    }
    EXPECT_EQ(content.size(), 10 + length + 8 * count);
    for (std::size_t k = 0; k < count; ++k) {
      std::uint64_t bits = 0;
      for (std::size_t b = 8; b-- > 0;) bits = bits << 8 | std::uint8_t(content.at(10 + length + 8 * k + b));
      array.values.push_back(std::bit_cast<double>(bits));
    }
    return array;
  }

  std::string bytes_;
  std::map<std::string, LoadedArray> arrays_;
};

}  // namespace aberfit::test
