#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "orchestrator/run.h"
#include "store/error.h"

namespace phiz {
namespace {

/// Hands out subjects one by one to a few threads that share one oneTBB arena. Every subject runs isolated: a
/// thread that waits inside one subject's loop never picks up work of another.
class Crew {
 public:
  Crew(const std::vector<SubjectJob>& jobs, const RunOptions& options, const RunServices& services,
       int threads)
      : jobs_(jobs), options_(options), services_(services), arena_(threads), outcomes_(jobs.size()) {}

  void work() {
    for (std::size_t i = next_++; i < jobs_.size() && !is_over(); i = next_++) {
      try {
        const Reservation reservation(*this, i);
        if (is_over()) break;
        arena_.execute([&] {
          tbb::this_task_arena::isolate([&] { outcomes_[i] = run_subject(jobs_[i], options_, services_); });
        });
        outcomes_[i]->steps = {};
        outcomes_[i]->summaries = {};
        const auto& failure = outcomes_[i]->failure;
        if (failure && (options_.fails_fast || is_hopeless(*failure))) is_aborted_ = true;
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!fatal_) fatal_ = std::current_exception();
        is_aborted_ = true;
      }
    }
  }

  std::vector<SubjectOutcome> take_outcomes() {
    if (fatal_) std::rethrow_exception(fatal_);
    std::vector<SubjectOutcome> finished;
    for (auto& outcome : outcomes_) {
      if (outcome) finished.push_back(std::move(*outcome));
    }
    return finished;
  }

 private:
  /// A subject's share of the memory, waited for. Whoever is alone never waits.
  class Reservation {
   public:
    Reservation(Crew& crew, std::size_t job) : crew_(crew) {
      if (crew_.options_.max_memory_bytes == 0) return;
      bytes_ = crew_.estimate(job);
      std::unique_lock lock(crew_.mutex_);
      crew_.memory_freed_.wait(lock, [&] {
        return crew_.running_ == 0 || crew_.is_over() ||
               crew_.reserved_bytes_ + bytes_ <= crew_.options_.max_memory_bytes;
      });
      ++crew_.running_;
      crew_.reserved_bytes_ += bytes_;
    }
    ~Reservation() {
      if (bytes_ == 0) return;
      const std::lock_guard lock(crew_.mutex_);
      --crew_.running_;
      crew_.reserved_bytes_ -= bytes_;
      crew_.memory_freed_.notify_all();
    }
    Reservation(const Reservation&) = delete;
    Reservation& operator=(const Reservation&) = delete;

   private:
    Crew& crew_;
    std::uint64_t bytes_ = 0;
  };

  std::uint64_t estimate(std::size_t job) const {
    try {
      const auto status = services_.store.files().find_status(jobs_[job].scan);
      return estimate_memory_bytes(status ? status->size_bytes : 0);
    } catch (const StoreError&) {
      return estimate_memory_bytes(0);  // the subject itself will say what is wrong
    }
  }

  bool is_over() const { return is_aborted_ || services_.stop.signal() != 0; }

  const std::vector<SubjectJob>& jobs_;
  const RunOptions& options_;
  const RunServices& services_;
  tbb::task_arena arena_;
  std::vector<std::optional<SubjectOutcome>> outcomes_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> is_aborted_ = false;
  std::mutex mutex_;
  std::condition_variable memory_freed_;
  std::size_t running_ = 0;  // of those with a reservation
  std::uint64_t reserved_bytes_ = 0;
  std::exception_ptr fatal_;
};

/// Leases that processes left behind which were killed between their commit and giving the lease back. They
/// keep nobody from anything; nobody would look at them again either.
void remove_left_leases(const RunServices& services) {
  try {
    for (const LeaseTable::Entry& lease : services.leases.list()) {
      if (lease.is_dead && services.store.find_done_result(lease.key)) services.leases.break_lease(lease.key);
    }
  } catch (const StoreError&) {
    // The work is done; the next run, or `store unlock`, tries again.
  }
}

}  // namespace

std::uint64_t estimate_memory_bytes(std::uint64_t scan_bytes) {
  // On the safe side of what a fit was seen to take: 196 MiB for 300,000 points in 7 MB of binary PLY.
  return (std::uint64_t{160} << 20) + 24 * scan_bytes;
}

std::vector<SubjectOutcome> run_subjects(const std::vector<SubjectJob>& jobs, const RunOptions& options,
                                         const RunServices& services) {
  const int machine = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = options.threads > 0 ? options.threads : machine;
  const tbb::global_control bound(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  services.reporter.begin(jobs.size());
  Crew crew(jobs, options, services, threads);
  const std::size_t helpers = std::min<std::size_t>(jobs.size(), static_cast<std::size_t>(threads));
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < helpers; ++i) others.emplace_back([&] { crew.work(); });
  crew.work();
  for (std::thread& other : others) other.join();
  std::vector<SubjectOutcome> outcomes = crew.take_outcomes();
  if (!options.is_dry_run) remove_left_leases(services);
  services.reporter.end(outcomes, jobs.size());
  return outcomes;
}

}  // namespace phiz
