// Records that are read equal those that were written, even after interruptions.
#include "aberfit/cases/journal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "aberfit/core/errors.h"
#include "study/scratch_folder.h"

namespace aberfit {
namespace {

using test::read_file;
using test::ScratchFolder;

CaseRecord record(const std::string& id, double value = 1, const std::string& error = "") {
  CaseRecord made;
  made.id = id;
  made.base = "b";
  made.index = 3;
  made.at = {{"/roughness/psd/rms", "\"20 nm\""}, {"/fit/seed", "4"}};
  made.values = {{"ee80_radius_m", value}, {"none", std::nan("")}};
  made.verdict = "equivalent";
  made.warnings = {"few-modes"};
  made.error = error;
  made.seconds = 0.25;
  return made;
}

TEST(CaseRecord, IsReadAsItWasWritten) {
  const CaseRecord first = record("a", 1.2345678901234567e-5, "no \"focus\"\nthere");
  const std::string line = to_line(first);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  const std::optional<CaseRecord> second = record_of(line);
  ASSERT_TRUE(second);
  EXPECT_EQ(to_line(*second), line);
  EXPECT_EQ(second->values[0].second, first.values[0].second);
  EXPECT_TRUE(std::isnan(second->values[1].second));
  EXPECT_EQ(second->at, first.at);
  EXPECT_EQ(second->error, first.error);
  EXPECT_EQ(nlohmann::json::parse(line)["status"], "failed");
  for (const char* wrong : {"", "{}", "[1]", "{\"id\": 3}", "no"}) EXPECT_FALSE(record_of(wrong)) << wrong;
  // Numbers that are no possible count (found by fuzzing).
  for (const char* index : {"3e26", "-1", "2.5", "true", "null"}) {
    nlohmann::json damaged = nlohmann::json::parse(line);
    damaged["index"] = nlohmann::json::parse(index);
    EXPECT_FALSE(record_of(damaged.dump())) << index;
  }
}

class Journal : public testing::Test {
 protected:
  std::vector<CaseRecord> read() { return read_journals(folder_.file("cases"), &damaged_); }
  const ScratchFolder folder_;
  std::size_t damaged_ = 0;
};

TEST_F(Journal, GoesOnBehindALineThatWasCutShort) {
  { CaseJournal(folder_.file("cases")).add(record("a")); }
  const std::string file = folder_.file("cases/worker-0001.jsonl"), whole = read_file(file);
  const std::string second = to_line(record("b", 2));
  // The process is killed at any position of the second line.
  for (std::size_t cut = 0; cut < second.size(); cut += 7) {
    folder_.write("cases/worker-0001.jsonl", whole + second.substr(0, cut));
    EXPECT_EQ(read().size(), 1u) << cut;
    EXPECT_EQ(damaged_, 0u);
    { CaseJournal(folder_.file("cases")).add(record("c", 3)); }
    EXPECT_EQ(read_file(file), whole + to_line(record("c", 3))) << cut;
  }
  // An incomplete line that is longer than one block of the reading.
  folder_.write("cases/worker-0001.jsonl", whole + std::string(20000, 'x'));
  { CaseJournal(folder_.file("cases")).add(record("c", 3)); }
  EXPECT_EQ(read_file(file), whole + to_line(record("c", 3)));
}

TEST_F(Journal, HasAFileForEveryWorkerAndTakesThoseOfTheDead) {
  {
    CaseJournal one(folder_.file("cases")), two(folder_.file("cases"));
    one.add(record("a")), two.add(record("b")), one.add(record("c"));
    EXPECT_TRUE(std::filesystem::exists(folder_.file("cases/worker-0002.jsonl")));
  }
  CaseJournal three(folder_.file("cases"));
  three.add(record("d"));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("cases/worker-0003.jsonl")));
  EXPECT_EQ(read_file(folder_.file("cases/worker-0001.jsonl")),
            to_line(record("a")) + to_line(record("c")) + to_line(record("d")));
}

TEST_F(Journal, OfManyThreadsHasWholeLines) {
  {
    CaseJournal journal(folder_.file("cases"));
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t)
      threads.emplace_back([&journal, t] {
        for (int k = 0; k < 50; ++k) journal.add(record(std::to_string(100 * t + k)));
      });
  }
  EXPECT_EQ(read().size(), 400u);
  EXPECT_EQ(damaged_, 0u);
}

TEST_F(Journal, IsReadOnceForACaseAndADoneOneGoesBeforeAFailedOne) {
  folder_.write("note.txt", "");
  std::filesystem::create_directory(folder_.file("cases"));
  folder_.write("cases/worker-0001.jsonl",
                to_line(record("a", 1, "failed once")) + "no record\n" + to_line(record("b", 2)));
  folder_.write("cases/worker-0002.jsonl", to_line(record("a", 3)) + to_line(record("b", 4)));
  const std::vector<CaseRecord> found = read();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(damaged_, 1u);
  EXPECT_EQ(found[0].values[0].second, 3);
  EXPECT_EQ(found[1].values[0].second, 2);
}

TEST_F(Journal, SaysWhereItCannotWrite) {
  folder_.write("file", "");
  CaseJournal journal(folder_.file("file/cases"));
  EXPECT_THROW(journal.add(record("a")), InputError);
}

TEST_F(Journal, SharesAreHeldByOneAndInOneWay) {
  const std::string cases = folder_.file("cases");
  {
    const ShareLock one(cases, 0, 4), two(cases, 1, 4);
    EXPECT_THROW(ShareLock(cases, 1, 4, 0.1), InputError);
    EXPECT_THROW(ShareLock(cases, 0, 1, 0.1), InputError);
  }
  const ShareLock whole(cases, 0, 1);
}

}  // namespace
}  // namespace aberfit
