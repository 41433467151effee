/// One thread beside the one that feeds the filter, for what may take longer than a step. docs/embedding.md
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace ssjs {

/// One job at a time, on a thread that is started with the first and kept. Where the system can give a thread of a process its own
/// priority (Linux) it is nicer by 5 than the thread that starts it: on a single core the sampling goes first.
class BackgroundWorker {
 public:
  BackgroundWorker() = default;
  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;
  ~BackgroundWorker();  ///< waits for the job

  /// The result of the job before must have been collected.
  void start(std::function<void()> job);
  [[nodiscard]] bool has_job() const { return has_job_; }  ///< started and not collected
  [[nodiscard]] bool is_done() const;                      ///< nothing is at work
  void wait() const;
  /// Waits and makes room for the next job. Throws what the job threw.
  void collect();

 private:
  void run();

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::function<void()> job_;  ///< waiting or at work
  std::exception_ptr problem_;
  bool at_work_ = false;
  bool stopping_ = false;
  bool has_job_ = false;  ///< of the caller's thread alone
  std::thread thread_;
};

}  // namespace ssjs
