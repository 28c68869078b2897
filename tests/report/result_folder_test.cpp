// A folder of results holds all files of one run, whatever happens to the runs that write there.
#include "aberfit/report/result_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "aberfit/core/content_hash.h"
#include "aberfit/core/errors.h"
#include "aberfit/core/random.h"
#include "aberfit/report/result.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

namespace fs = std::filesystem;
using test::read_file;
using test::ScratchFolder;

constexpr int kFiles = 12;

ResultClaim claim(const std::string& command = "fit", bool force = false) {
  return {command, {"result.json", "file-*", "plots/file-*", "plots/old.png"}, force};
}

// A run whose files all hold its number: `kFiles` of its own in two folders, and a result.
void run(const std::string& to, int number, const std::string& also = "", const ResultClaim& by = claim()) {
  ResultFolder folder(to, by);
  const std::string into = folder.path() + "/", text = std::to_string(number);
  for (int k = 0; k < kFiles; ++k)
    write_file(into + (k % 2 ? "plots/" : "") + "file-" + std::to_string(k), text);
  if (!also.empty()) write_file(into + also, text);
  write_file(into + "result.json", text);
  folder.show();
}

std::set<std::string> visible(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with('.'))
      names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

// The number of the run if all its files are there; -1 if they are of several runs or some are missing.
int whole_run(const std::string& folder) {
  std::set<std::string> numbers;
  for (const std::string& file : visible(folder)) numbers.insert(read_file(folder + "/" + file));
  return numbers.size() == 1 && visible(folder).size() == kFiles + 1 ? std::stoi(*numbers.begin()) : -1;
}

pid_t in_child(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  return child;
}

int exit_code_of_child(const std::function<void()>& work) {
  int status = 0;
  waitpid(in_child(work), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ResultFolder, LeavesNothingOfAnEarlierRunAndAllOfTheUsers) {
  ScratchFolder scratch;
  const std::string out = scratch.file("new/out");
  run(out, 1, "plots/old.png");
  scratch.write("new/out/notes.txt", "mine");
  fs::create_directories(out + "/mine");
  scratch.write("new/out/mine/study.json", "mine");
  run(out, 2);
  EXPECT_FALSE(fs::exists(out + "/plots/old.png"));
  EXPECT_EQ(read_file(out + "/notes.txt"), "mine");
  EXPECT_EQ(read_file(out + "/mine/study.json"), "mine");
  EXPECT_EQ(read_file(out + "/plots/file-1"), "2");
  EXPECT_EQ(visible(scratch.file("new")).size(), std::size_t(kFiles + 1 + 2)) << "something is left beside";
}

TEST(ResultFolder, OfARunThatFailsIsWhatItWas) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out"), fresh = scratch.file("a/b/c");
  run(out, 1);
  for (const std::string& folder : {out, fresh}) {
    ResultFolder second(folder, claim());
    write_file(second.path() + "/result.json", "2");
  }
  EXPECT_EQ(whole_run(out), 1);
  EXPECT_FALSE(fs::exists(scratch.file("a")));
}

TEST(ResultFolder, IsRefusedToASecondRunWhileTheFirstLasts) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  {
    const ResultFolder first(out, claim());
    try {
      const ResultFolder second(out, claim());
      FAIL();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("another run"), std::string::npos) << error.what();
    }
    // The refused run has not removed the first one's folder.
    EXPECT_TRUE(fs::exists(first.path()));
  }
  run(out, 1);
  EXPECT_EQ(whole_run(out), 1);
}

TEST(ResultFolder, IsOneRunsWheneverARunIsKilled) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 0);
  RandomStream stream(7, "kills");
  for (int k = 1; k <= 20; ++k) {
    const pid_t child = in_child([&] {
      for (int number = k * 100000;; ++number) run(out, number);
    });
    usleep(useconds_t(stream.bits(std::uint64_t(k)) % 20000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    EXPECT_GE(whole_run(out), 0) << "kill " << k;
  }
  run(out, 5);
  EXPECT_EQ(whole_run(out), 5);
  EXPECT_EQ(visible(scratch.file("")).size(), std::size_t(kFiles + 1)) << "something is left beside";
}

TEST(ResultFolder, OfAFullDiskIsWhatItWas) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 1);
  const int code = exit_code_of_child([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit none{0, 0};  // every write fails
    setrlimit(RLIMIT_FSIZE, &none);
    try {
      run(out, 2);
    } catch (const InputError&) {
      _exit(2);
    }
  });
  EXPECT_EQ(code, 2);
  EXPECT_EQ(whole_run(out), 1);
}

// Two folders cannot change places if one is the working folder.
TEST(ResultFolder, ThatIsTheWorkingFolderStaysTheSameFolder) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 1, "plots/old.png");
  const int code = exit_code_of_child([&] {
    fs::current_path(out);
    run(".", 2);
    if (!fs::exists("result.json")) _exit(3);
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(whole_run(out), 2);
}

// Other results in subfolders are neither linked nor moved, and a run that writes there continues.
TEST(ResultFolder, LeavesFoldersInItAlone) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 1);
  ResultFolder other(out + "/other", {"solve", {"result.json", "more"}});
  write_file(other.path() + "/result.json", "3");
  run(out, 2);
  EXPECT_EQ(read_file(out + "/result.json"), "2");
  write_file(other.path() + "/more", "3");
  other.show();
  EXPECT_EQ(read_file(out + "/other/result.json"), "3");
  EXPECT_EQ(read_file(out + "/other/more"), "3");
}

// A list of files that was changed by others removes nothing outside the folder.
TEST(ResultFolder, TakesNoNamesThatLeadOutOfIt) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 1);
  scratch.write("mine.txt", "mine");
  const std::string hash = content_hash("mine") + " ";
  scratch.write("out/.aberfit-files", read_file(out + "/.aberfit-files") + hash + "../mine.txt\n" + hash +
                                          scratch.file("mine.txt") + "\n" + hash + "plots/../../mine.txt\n");
  fs::create_directories(out + "/folder");  // file by file
  run(out, 2);
  EXPECT_EQ(read_file(scratch.file("mine.txt")), "mine");
}

std::string refusal(const std::string& out, const ResultClaim& by) {
  try {
    const ResultFolder folder(out, by);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ResultFolder, IsRefusedWhereAnotherCommandOrPersonHasWrittenAndSaysWhat) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  run(out, 1);
  EXPECT_NE(refusal(out, claim("solve")).find("result.json of `aberfit fit`"), std::string::npos)
      << refusal(out, claim("solve"));
  EXPECT_NE(refusal(out, claim("solve")).find("--force"), std::string::npos);
  EXPECT_EQ(refusal(out, {"solve", {"result", "plots/old*", "mine*"}}), "");  // nothing in the way
  EXPECT_EQ(refusal(out, claim()), "");
  scratch.write("out/file-4", "mine");  // changed since
  EXPECT_NE(refusal(out, claim()).find("file-4 (not written by"), std::string::npos) << refusal(out, claim());
  fs::remove(out + "/file-4");
  EXPECT_EQ(refusal(out, claim()), "");
  scratch.write("out/plots/file-x", "mine");
  EXPECT_NE(refusal(out, claim()).find("plots/file-x"), std::string::npos);
  fs::remove_all(out + "/plots");
  scratch.write("out/plots", "mine");  // a folder is needed here
  EXPECT_NE(refusal(out, claim()).find("plots (not written by"), std::string::npos);
  fs::remove(out + "/result.json");
  fs::create_directories(out + "/result.json");
  EXPECT_EQ(refusal(out, claim("fit", true)).find("--force"), std::string::npos);  // it does not help
  EXPECT_NE(refusal(out, claim("fit", true)).find("result.json"), std::string::npos);
}

// --force replaces the files that are in the way and names them. All other files stay, whoever wrote them.
TEST(ResultFolder, ReplacesByForceWhatIsInTheWayAndNothingElse) {
  for (const bool with_folder : {false, true}) {  // all at once, file by file
    ScratchFolder scratch;
    const std::string out = scratch.file("out");
    run(out, 1, "plots/own.png");
    scratch.write("out/file-4", "mine");
    scratch.write("out/notes.txt", "mine");
    if (with_folder) fs::create_directories(out + "/folder");
    std::string told;
    ResultClaim by = claim("solve", true);
    by.tell = [&](const std::string& line) { told = line; };
    run(out, 2, "", by);
    EXPECT_EQ(read_file(out + "/result.json"), "2");
    EXPECT_EQ(read_file(out + "/file-4"), "2");
    EXPECT_EQ(read_file(out + "/notes.txt"), "mine");
    EXPECT_EQ(read_file(out + "/plots/own.png"), "1");
    EXPECT_NE(told.find("file-4 (not written by"), std::string::npos) << told;
    EXPECT_NE(told.find("of `aberfit fit`"), std::string::npos) << told;
    told.clear();
    run(out, 3, "", by);  // the command's own files now
    EXPECT_EQ(told, "");
    EXPECT_EQ(read_file(out + "/result.json"), "3");
  }
}

TEST(ResultFolder, KeepsItsResultsWhereSomethingComesInTheWayMeanwhile) {
  ScratchFolder scratch;
  const std::string out = scratch.file("out");
  ResultFolder folder(out, {"fit", {"result.json"}});
  write_file(folder.path() + "/result.json", "1");
  scratch.write("mine.txt", "mine");
  fs::create_directories(out);
  fs::rename(scratch.file("mine.txt"), out + "/result.json");
  EXPECT_THROW(folder.show(), InputError);
  EXPECT_EQ(read_file(out + "/result.json"), "mine");
  EXPECT_EQ(read_file(scratch.file("out-2/result.json")), "1");
}

}  // namespace
}  // namespace aberfit
