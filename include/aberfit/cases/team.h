#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "aberfit/cases/shard.h"

namespace aberfit {

/// The work that is left, handed out number by number. Use from many threads.
class CaseQueue {
 public:
  virtual ~CaseQueue() = default;
  /// The next case; nothing where there is none left.
  virtual std::optional<std::size_t> next() = 0;
};

/// Cases of this process, and, in rank 0, of all ranks.
class LocalQueue : public CaseQueue {
 public:
  explicit LocalQueue(std::vector<std::size_t> cases) : cases_(std::move(cases)) {}
  std::optional<std::size_t> next() override;
  /// Hands out nothing more.
  void close();
  std::size_t handed_out() const;
  std::size_t size() const { return cases_.size(); }
  /// A run of at most `most` neighbouring cases, and no more than an eighth of what is left for each of
  /// `workers`; count 0: none is left.
  void take(std::size_t workers, std::size_t most, std::size_t* first, std::size_t* count);

 private:
  mutable std::mutex mutex_;
  std::vector<std::size_t> cases_;
  std::size_t next_ = 0;
};

/// The processes that mpirun has started together. Rank 0 hands out, so that whoever is done first takes the
/// next; it knows alone what earlier runs have recorded. There is no claim in a file for each case, whose
/// holder might be dead: what a killed rank was at is in no record, and the next run does it.
class Team {
 public:
  /// Null in a process that mpirun has not started (or has alone). Of one that is started by mpirun but built
  /// without MPI, or that cannot find its module, `shard` is set instead: every rank takes its share.
  static std::unique_ptr<Team> join(const Environment& environment, Shard* shard);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  /// Ranks but 0: asks rank 0.
  std::unique_ptr<CaseQueue> queue();
  /// Rank 0: answers until all others have left. most: the longest run of cases in one answer.
  void serve(LocalQueue* queue, std::size_t most, const std::function<void()>& between);
  /// Ranks but 0: nothing more is to come; their records are written.
  void leave();
  /// All ranks end at once.
  void abort(int code);

 private:
  Team() = default;
  struct Module;
  std::unique_ptr<Module> module_;
  int rank_ = 0, ranks_ = 1;
};

}  // namespace aberfit
