#include "aberfit/cases/team.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "aberfit/core/text.h"
#include "mpi_module.h"

namespace aberfit {
using namespace internal;

std::optional<std::size_t> LocalQueue::next() {
  const std::lock_guard lock(mutex_);
  if (next_ == cases_.size()) return std::nullopt;
  return cases_[next_++];
}

void LocalQueue::close() {
  const std::lock_guard lock(mutex_);
  next_ = cases_.size();
}

std::size_t LocalQueue::handed_out() const {
  const std::lock_guard lock(mutex_);
  return next_;
}

void LocalQueue::take(std::size_t workers, std::size_t most, std::size_t* first, std::size_t* count) {
  constexpr std::size_t kShares = 8;
  const std::lock_guard lock(mutex_);
  const std::size_t left = cases_.size() - next_;
  const std::size_t fair = std::min(left, std::clamp<std::size_t>(left / (kShares * workers), 1, most));
  *first = left > 0 ? cases_[next_] : 0;
  for (*count = 0; *count < fair && cases_[next_] == *first + *count; ++*count) ++next_;
}

struct Team::Module {
  void* handle = nullptr;
  decltype(&aberfit_mpi_begin) begin = nullptr;
  decltype(&aberfit_mpi_ask) ask = nullptr;
  decltype(&aberfit_mpi_serve) serve = nullptr;
  decltype(&aberfit_mpi_leave) leave = nullptr;
  decltype(&aberfit_mpi_end) end = nullptr;
  decltype(&aberfit_mpi_abort) abort = nullptr;

  template <class Function>
  bool find(const char* name, Function* function) {
    *function = reinterpret_cast<Function>(::dlsym(handle, name));
    return *function != nullptr;
  }
  bool load(const std::string& path) {
    handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);  // Open MPI looks up its own parts globally
    return handle && find("aberfit_mpi_begin", &begin) && find("aberfit_mpi_ask", &ask) &&
           find("aberfit_mpi_serve", &serve) && find("aberfit_mpi_leave", &leave) &&
           find("aberfit_mpi_end", &end) && find("aberfit_mpi_abort", &abort);
  }
};

namespace {

// The rank that mpirun of Open MPI, MPICH (Hydra) or srun gives to this process.
struct Place {
  int rank = 0, ranks = 1;
  bool open_mpi = false;
};
Place place_of(const Environment& environment) {
  const auto number = [&](const char* name) { return parse_number<int>(environment(name)).value_or(-1); };
  if (number("OMPI_COMM_WORLD_SIZE") > 1)
    return {number("OMPI_COMM_WORLD_RANK"), number("OMPI_COMM_WORLD_SIZE"), true};
  if (number("PMI_SIZE") > 1) return {number("PMI_RANK"), number("PMI_SIZE"), false};
  return {};
}

// The module is next to the program, or in its installation folder.
std::vector<std::string> places_of_module() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  return {(folder / "aberfit_mpi.so").string(), (folder / "../lib/aberfit/aberfit_mpi.so").string()};
}

// Takes a run of cases from rank 0 at a time, one request at a time.
class RemoteQueue : public CaseQueue {
 public:
  explicit RemoteQueue(decltype(&aberfit_mpi_ask) ask) : ask_(ask) {}
  std::optional<std::size_t> next() override {
    const std::lock_guard lock(mutex_);
    if (left_ == 0 && !ended_) {
      long first = 0, count = 0;
      ask_(&first, &count);
      next_ = std::size_t(first), left_ = std::size_t(count);
      ended_ = count == 0;
    }
    if (left_ == 0) return std::nullopt;
    --left_;
    return next_++;
  }

 private:
  std::mutex mutex_;
  decltype(&aberfit_mpi_ask) ask_;
  std::size_t next_ = 0, left_ = 0;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<Team> Team::join(const Environment& environment, Shard* shard) {
  const Place place = place_of(environment);
  if (place.ranks < 2 || place.rank < 0) return nullptr;
  std::unique_ptr<Team> team(new Team);
  team->module_ = std::make_unique<Module>();
  const std::vector<std::string> paths = places_of_module();
  const bool loaded = place.open_mpi && std::any_of(paths.begin(), paths.end(), [&](const auto& path) {
                        return team->module_->load(path);
                      });
  if (loaded && team->module_->begin(&team->rank_, &team->ranks_) == 0) return team;
  team->module_.reset();
  *shard = {place.rank, place.ranks};
  return nullptr;
}

Team::~Team() {
  if (module_) module_->end();
}

std::unique_ptr<CaseQueue> Team::queue() { return std::make_unique<RemoteQueue>(module_->ask); }

void Team::serve(LocalQueue* queue, std::size_t most, const std::function<void()>& between) {
  struct State {
    LocalQueue* queue;
    std::size_t workers, most;
    const std::function<void()>* between;
  } state{queue, std::size_t(ranks_), most, &between};
  module_->serve(
      [](void* of, long* first, long* count) {
        const State& own = *static_cast<State*>(of);
        std::size_t begin = 0, many = 0;
        own.queue->take(own.workers, own.most, &begin, &many);
        *first = long(begin), *count = long(many);
      },
      [](void* of) { (*static_cast<State*>(of)->between)(); }, &state);
}

void Team::leave() { module_->leave(); }

void Team::abort(int code) { module_->abort(code); }

}  // namespace aberfit
