#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "aberfit/cases/shard.h"

namespace aberfit {

/// The remaining work, handed out case by case. Use from many threads is safe.
class CaseQueue {
 public:
  virtual ~CaseQueue() = default;
  /// The next case; empty if none is left.
  virtual std::optional<std::size_t> next() = 0;
};

/// Cases of this process or, in rank 0, of all ranks.
class LocalQueue : public CaseQueue {
 public:
  explicit LocalQueue(std::vector<std::size_t> cases) : cases_(std::move(cases)) {}
  std::optional<std::size_t> next() override;
  /// Stops the hand-out.
  void close();
  std::size_t handed_out() const;
  std::size_t size() const { return cases_.size(); }
  /// At most `most` neighbouring cases, and at most 1/8 of the rest per worker. count 0: none is left.
  void take(std::size_t workers, std::size_t most, std::size_t* first, std::size_t* count);

 private:
  mutable std::mutex mutex_;
  std::vector<std::size_t> cases_;
  std::size_t next_ = 0;
};

/// The processes that mpirun has started together. Rank 0 hands out the cases, so a rank that is done takes
/// the next. Only rank 0 knows the records of earlier runs. There is no file per claimed case, because its
/// holder might be dead. The case of a killed rank has no record, so the next run does it.
class Team {
 public:
  /// Null in a process that mpirun did not start, or started alone. If mpirun started it but it has no MPI,
  /// or its module is missing, `shard` is set instead: every rank takes its own shard.
  static std::unique_ptr<Team> join(const Environment& environment, Shard* shard);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  /// For ranks except 0: requests cases from rank 0.
  std::unique_ptr<CaseQueue> queue();
  /// For rank 0: answers until all others have left. most: the longest run of cases in one answer.
  void serve(LocalQueue* queue, std::size_t most, const std::function<void()>& between);
  /// For ranks except 0: no more requests follow, and the records are written.
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
