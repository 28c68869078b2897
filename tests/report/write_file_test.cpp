#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "aberfit/core/errors.h"
#include "aberfit/report/result.h"

using namespace aberfit;
namespace fs = std::filesystem;

namespace {

class WriteFile : public ::testing::Test {
 protected:
  WriteFile() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("write file ") + info->name());
    fs::remove_all(folder_);
  }
  ~WriteFile() override { fs::remove_all(folder_); }
  std::string content(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t entries() {
    return std::size_t(
        std::distance(fs::recursive_directory_iterator(folder_), fs::recursive_directory_iterator()));
  }
  fs::path folder_;
};

}  // namespace

TEST_F(WriteFile, CreatesFoldersAndReplacesWhatWasThere) {
  const fs::path path = folder_ / "a" / "b.txt";
  write_file(path.string(), "first\n");
  EXPECT_EQ(content(path), "first\n");
  const std::string second("second\0\r\n", 9);
  write_file(path.string(), second);
  EXPECT_EQ(content(path), second);
  EXPECT_EQ(entries(), 2u);  // the folder and the file, nothing left beside it
}

TEST_F(WriteFile, LeavesNothingBehindWhenItFails) {
  fs::create_directories(folder_ / "taken" / "inside");
  EXPECT_THROW(write_file((folder_ / "taken").string(), "text"), InputError);  // a folder stands there
  EXPECT_EQ(entries(), 2u);
  write_file((folder_ / "file").string(), "kept");
  EXPECT_THROW(write_file((folder_ / "file" / "below.txt").string(), "text"), InputError);
  EXPECT_EQ(content(folder_ / "file"), "kept");
  EXPECT_EQ(entries(), 3u);
}

TEST_F(WriteFile, NamesTheFileItCouldNotWrite) {
  fs::create_directories(folder_ / "taken" / "inside");
  const std::string path = (folder_ / "taken").string();
  try {
    write_file(path, "text");
    FAIL() << "no InputError";
  } catch (const InputError& e) {
    EXPECT_EQ(e.file(), path);
  }
}

TEST_F(WriteFile, ShowsReadersOnlyWholeFiles) {
  const fs::path path = folder_ / "shared.txt";
  const std::string a(200000, 'a'), b(300000, 'b');
  write_file(path.string(), a);
  const auto writer = [&](const std::string& text) {
    for (int i = 0; i < 50; ++i) write_file(path.string(), text);
  };
  std::thread one(writer, a), two(writer, b);
  int torn = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string seen = content(path);
    if (seen != a && seen != b) ++torn;
  }
  one.join();
  two.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(entries(), 1u);
}
