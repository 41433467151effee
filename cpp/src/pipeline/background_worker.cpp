#include "ssjs/pipeline/background_worker.hpp"

#include <utility>

#if defined(__linux__)
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Behind the sampling, and not so far behind that another program on the same core keeps it from ever being done: then feed() would wait.
void take_a_lower_priority() {
#if defined(__linux__)
  constexpr int kNicer = 5;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  const int now = getpriority(PRIO_PROCESS, thread);
  static_cast<void>(setpriority(PRIO_PROCESS, thread, now + kNicer));  // refused: the work is done all the same
#endif
}

}  // namespace

BackgroundWorker::~BackgroundWorker() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void BackgroundWorker::start(std::function<void()> job) {
  if (has_job_) throw InvalidArgument("BackgroundWorker.start", "a second job", "the first must be collected before");
  has_job_ = true;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    job_ = std::move(job);
    at_work_ = true;
  }
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  changed_.notify_all();
}

bool BackgroundWorker::is_done() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !at_work_;
}

void BackgroundWorker::wait() const {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return !at_work_; });
}

void BackgroundWorker::collect() {
  wait();
  has_job_ = false;
  if (problem_) std::rethrow_exception(std::exchange(problem_, nullptr));
}

void BackgroundWorker::run() {
  take_a_lower_priority();
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return at_work_ || stopping_; });
    if (!at_work_) return;
    lock.unlock();
    std::exception_ptr problem;
    try {
      job_();
    } catch (...) {
      problem = std::current_exception();
    }
    lock.lock();
    job_ = nullptr;
    problem_ = problem;
    at_work_ = false;
    changed_.notify_all();
  }
}

}  // namespace ssjs
