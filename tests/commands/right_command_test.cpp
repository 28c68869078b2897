// If a command cannot use a file, the message says what the file is and which command uses it.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "../study/scratch_folder.h"
#include "aberfit/commands/program.h"
#include "aberfit/core/errors.h"

namespace aberfit::test {
namespace {

std::string message_of(const std::string& path, const std::string& command) {
  try {
    require_right_file(path, command);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

struct Files {
  ScratchFolder folder;
  std::string profile = write("mirror.txt", "x_mm height_nm\n0 1\n1 2\n2 1\n");
  std::string map = write("map.csv", "# pitch = 1 mm\n1 2 3 4\n2 9 4 1\n");
  std::string fits = write("map.fits", "SIMPLE  =                    T" + std::string(50, ' ') + "END");
  std::string dabam = write("dabam-7.txt", "{\"FILE_FORMAT\": 1, \"FILE_HEADER_LINES\": 0}");
  std::string coefficients =
      write("coefficients.csv", "# radius_m = 0.2\nkind,n,m,noll,fx_per_m,fy_per_m,value_m,std_m\n");
  std::string table = write("psd.csv", "frequency_per_m,psd_m4\n1,1e-20\n2,1e-21\n");
  std::string result = write("result.json", R"({"aberfit": 1, "kind": "fit", "study": {}})");
  std::string psd_result = write("psd.json", R"({"aberfit": 1, "kind": "psd"})");
  std::string block = write("roughness.json", R"({"psd": {"model": "gaussian"}})");
  std::string empty = write("empty.json", " \n");
  std::string study = write("study.json", R"({"aberfit": 1, "mirror": {"focal_length": "2 m"}})");
  std::string damaged = write("damaged.json", R"({"aberfit": 1, "mirror": )");

  std::string write(const std::string& name, const std::string& text) const {
    return folder.write(name, text);
  }
};

TEST(RightCommand, AMeasuredFileIsForPsd) {
  const Files files;
  for (const std::string& path : {files.profile, files.map, files.fits, files.dabam}) {
    for (const char* command : {"fit", "check", "trace", "solve", "sweep"}) {
      const std::string message = message_of(path, command);
      EXPECT_NE(message.find("`aberfit psd " + path + "`"), std::string::npos) << message;
    }
    EXPECT_EQ(message_of(path, "psd"), "");
    EXPECT_EQ(command_for(path), "psd " + path);
  }
  EXPECT_NE(message_of(files.fits, "fit").find("format fits"), std::string::npos);
}

TEST(RightCommand, CoefficientsAndTablesSayWhereTheyBelong) {
  const Files files;
  for (const char* command : {"fit", "trace", "psd"}) {
    EXPECT_NE(message_of(files.coefficients, command).find("`aberfit trace STUDY --coefficients"),
              std::string::npos);
    EXPECT_NE(message_of(files.table, command).find("\"model\": \"table\", \"file\": \"psd.csv\""),
              std::string::npos);
    EXPECT_NE(message_of(files.result, command).find("the block \"study\" of this result"),
              std::string::npos);
    EXPECT_NE(message_of(files.psd_result, command).find("the block \"roughness\" of this result"),
              std::string::npos);
    EXPECT_NE(message_of(files.block, command).find("a study that contains it as \"roughness\""),
              std::string::npos);
    EXPECT_NE(message_of(files.empty, command).find("found an empty file"), std::string::npos);
  }
  EXPECT_EQ(command_for(files.coefficients), "trace STUDY --coefficients " + files.coefficients);
}

TEST(RightCommand, StudiesAndUnknownFilesAreLeftToTheirReaders) {
  const Files files;
  for (const char* command : {"fit", "trace", "psd"})
    for (const std::string& path :
         {files.study, files.damaged, std::string("-"), files.folder.file("missing.json")})
      EXPECT_EQ(message_of(path, command), "") << path;
  EXPECT_EQ(command_for(files.study), "check " + files.study);
  EXPECT_EQ(command_for("fti"), "");
}

}  // namespace
}  // namespace aberfit::test
