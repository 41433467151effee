/// Work cut into numbered blocks that threads take one after the other.
#pragma once

#include <cstddef>
#include <functional>

namespace ssjs {

/// Calls work(block) once for each block in [0, blocks), on up to `threads` threads (the caller's among them). Blocks are taken in
/// their order, but end in any: results that do not depend on the number of threads are written by block, or do not depend on order.
/// The first exception, by block number, is thrown after all threads have stopped.
void parallel_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t)>& work);

/// The same, telling each call which of the threads, [0, threads), makes it: for memory that a thread uses again and again.
void parallel_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t block, std::size_t thread)>& work);

}  // namespace ssjs
