#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "orchestrator/run.h"

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
        arena_.execute([&] {
          tbb::this_task_arena::isolate([&] { outcomes_[i] = run_subject(jobs_[i], options_, services_); });
        });
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
  bool is_over() const { return is_aborted_ || services_.stop.signal() != 0; }

  const std::vector<SubjectJob>& jobs_;
  const RunOptions& options_;
  const RunServices& services_;
  tbb::task_arena arena_;
  std::vector<std::optional<SubjectOutcome>> outcomes_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> is_aborted_ = false;
  std::mutex mutex_;
  std::exception_ptr fatal_;
};

}  // namespace

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
  return crew.take_outcomes();
}

}  // namespace phiz
