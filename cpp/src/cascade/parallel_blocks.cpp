#include "ssjs/cascade/parallel_blocks.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "ssjs/base/error.hpp"

namespace ssjs {

void parallel_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t)>& work) {
  parallel_blocks(blocks, threads, [&](std::size_t block, std::size_t) { work(block); });
}

void parallel_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t, std::size_t)>& work) {
  if (threads < 1) throw InvalidArgument("threads", threads, "must be at least 1");
  std::atomic<std::size_t> next{0};
  std::mutex guard;
  std::exception_ptr failure;
  std::size_t failed_block = blocks;
  const auto take_blocks = [&](std::size_t thread) {
    for (std::size_t block = next++; block < blocks; block = next++) {
      try {
        work(block, thread);
      } catch (...) {
        next = blocks;
        const std::lock_guard<std::mutex> lock(guard);
        if (block < failed_block) {
          failed_block = block;
          failure = std::current_exception();
        }
      }
    }
  };
  std::vector<std::thread> helpers;
  const std::size_t wanted = std::min(static_cast<std::size_t>(threads), blocks);
  for (std::size_t i = 1; i < wanted; ++i) helpers.emplace_back(take_blocks, i);
  take_blocks(0);
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ssjs
