#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace aberfit::test {

inline std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc;
}

inline std::string little(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i, value >>= 8) text += char(value);
  return text;
}

using PackedFiles = std::vector<std::pair<std::string, std::string>>;

/// A zip archive without compression. said_bytes: false length for the directory, if not 0.
inline std::string zip_of(const PackedFiles& files, std::uint64_t method = 0, std::uint64_t said_bytes = 0,
                          int flags = 0) {
  std::string local, central;
  for (const auto& [name, content] : files) {
    const std::string entry = little(20, 2) + little(std::uint64_t(flags), 2) + little(method, 2) +
                              little(0x2100, 4) + little(crc32(content), 4) + little(content.size(), 4) +
                              little(said_bytes != 0 ? said_bytes : content.size(), 4) +
                              little(name.size(), 2) + little(0, 2);
    central += "PK\x01\x02" + little(20, 2) + entry + little(0, 10) + little(local.size(), 4) + name;
    local += "PK\x03\x04" + entry + name + content;
  }
  return local + central + "PK\x05\x06" + little(0, 4) + little(files.size(), 2) + little(files.size(), 2) +
         little(central.size(), 4) + little(local.size(), 4) + little(0, 2);
}

/// The content as uncompressed gzip (RFC 1951, blocks of type 0), with an optional name in its header.
inline std::string gzip_of(const std::string& content, const std::string& name = "") {
  constexpr std::size_t kLongest = 0xffff;
  std::string packed;
  for (std::size_t at = 0; at < content.size() || at == 0; at += kLongest) {
    const std::string block = content.substr(at, kLongest);
    packed += little(at + kLongest >= content.size() ? 1 : 0, 1) + little(block.size(), 2) +
              little(0xffff - block.size(), 2) + block;
  }
  return std::string("\x1f\x8b\x08", 3) + little(name.empty() ? 0 : 8, 1) + std::string(6, '\0') + name +
         (name.empty() ? "" : std::string(1, '\0')) + packed + little(crc32(content), 4) +
         little(content.size(), 4);
}

}  // namespace aberfit::test
