#pragma once
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace aberfit::test {

/// ../shared/data/<folder> beside the project: files that others made, which are not copied into it. Nothing
/// where the folder is not.
inline std::optional<std::filesystem::path> shared_data(std::string_view folder) {
  const std::filesystem::path path =
      std::filesystem::path(ABERFIT_SOURCE_DIR).parent_path() / "shared" / "data" / folder;
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) return std::nullopt;
  return path;
}

/// Base of the suites whose tests read such files. Their names end in OnRealData: tests/run.sh counts by it.
class RealData : public ::testing::Test {
 protected:
  explicit RealData(std::string folder) : folder_(std::move(folder)) {}
  void SetUp() override {
    if (!shared_data(folder_)) GTEST_SKIP() << "no ../shared/data/" << folder_ << " beside the project";
  }
  std::string file(const std::string& name) const { return (*shared_data(folder_) / name).string(); }

 private:
  std::string folder_;
};

class DabamOnRealData : public RealData {
 protected:
  DabamOnRealData() : RealData("dabam") {}
};

class ZygoOnRealData : public RealData {
 protected:
  ZygoOnRealData() : RealData("prysm-zygo") {}
};

class InstrumentsOnRealData : public RealData {
 protected:
  InstrumentsOnRealData() : RealData("instruments") {}
};

}  // namespace aberfit::test
