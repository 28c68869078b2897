#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>

#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"

namespace aberfit::test {

/// A folder for this test and process, removed with the object, so that tests may run in parallel.
class Scratch {
 public:
  Scratch() {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::path(testing::TempDir()) / (std::string("aberfit_") + test->test_suite_name() + "_" +
                                                     test->name() + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, std::string_view bytes) const {
    std::ofstream(path(name), std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

inline std::string file_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Returns the whole message of the InputError that `call` throws; "" if it throws nothing.
inline std::string input_error(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Returns a damaged copy of a file, a pure function of (original, stream, number). It has one to three of
/// these: flipped bits, overwritten bytes, truncation, a part removed, repeated or moved, an extreme or
/// invalid number, and a header extended by lines or blanks.
inline std::string mutated(const std::string& original, const RandomStream& stream, std::uint64_t number) {
  std::uint64_t next = number << 16;
  const auto below = [&](std::size_t bound) {
    return bound == 0 ? std::size_t(0) : std::size_t(stream.bits(next++) % bound);
  };
  static const char* const kNumbers[] = {
      "1e308",      "-1e308", "1e999", "1e-320", "nan", "inf", "-inf", "-1",   "0",  "99999999999999999999",
      "2147483648", "65536",  "1e9",   "-0.0",   "--",  "abc", "",     "0x10", "1,5"};
  std::string text = original;
  const std::size_t damages = 1 + below(3);
  for (std::size_t damage = 0; damage < damages; ++damage) {
    const std::size_t kind = below(8);
    const std::size_t at = below(text.size() + 1),
                      length = below(1 + std::min<std::size_t>(text.size() - at, 400));
    switch (kind) {
      case 0:
        for (std::size_t i = 0; i < 1 + length / 40 && !text.empty(); ++i)
          text[below(text.size())] ^= char(1 << below(8));
        break;
      case 1:
        for (std::size_t i = at; i < at + length / 8; ++i) text[i] = char(below(256));
        break;
      case 2:
        text.resize(at);
        break;
      case 3:
        text.erase(at, length);
        break;
      case 4:
        text.insert(at, text.substr(at, length));
        break;
      case 5: {
        const std::string piece = text.substr(at, length);
        text.erase(at, length);
        text.insert(below(text.size() + 1), piece);
        break;
      }
      case 6: {
        constexpr const char* kDigits = "+-.0123456789eE";
        const std::size_t begin = text.find_first_of(kDigits, at);
        if (begin == std::string::npos) break;
        const std::size_t end = std::min(text.find_first_not_of(kDigits, begin), text.size());
        text.replace(begin, end - begin, kNumbers[below(std::size(kNumbers))]);
        break;
      }
      default: {
        static const char* const kFillers[] = {"\n", " ", "# a comment\n", "1 ", "x", "{", "\xff", "\r\n"};
        const char* const filler = kFillers[below(std::size(kFillers))];
        std::string header;
        for (std::size_t i = 0, count = 1 + below(4000); i < count; ++i) header += filler;
        text.insert(below(2) == 0 ? 0 : at, header);
      }
    }
  }
  return text;
}

struct MutationCounts {
  int read = 0, refused = 0;
};

/// Calls `read` on `count` damaged copies of `original`, each written to `path`. A reader may read the file
/// or throw an InputError that names the file; anything else fails the test.
inline MutationCounts read_mutations(const std::string& original, const std::string& path, int count,
                                     std::string_view stream_name, const std::function<void()>& read) {
  const RandomStream stream(1, stream_name);
  MutationCounts counts;
  for (int number = 0; number < count; ++number) {
    {
      const std::string bytes = mutated(original, stream, std::uint64_t(number));
      std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    }
    try {
      read();
      ++counts.read;
    } catch (const InputError& error) {
      ++counts.refused;
      EXPECT_FALSE(error.file().empty()) << "mutation " << number << ": " << error.what();
      EXPECT_FALSE(error.found().empty()) << "mutation " << number << ": " << error.what();
      EXPECT_FALSE(error.allowed().empty()) << "mutation " << number << ": " << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "mutation " << number << " of " << stream_name << ": " << error.what();
    }
  }
  return counts;
}

}  // namespace aberfit::test
