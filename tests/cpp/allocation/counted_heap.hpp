/// Counts what a thread takes from the heap. Eigen allocates with malloc and the standard library with operator new, which ends in malloc
/// too: standing in front of malloc sees both. To be included by one source of an executable; shared libraries of that process are seen
/// as well.
#pragma once

#include <cstddef>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SSJS_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SSJS_SANITIZED
#endif
#if defined(__GLIBC__) && !defined(SSJS_SANITIZED)
#define SSJS_COUNTS_ALLOCATIONS  ///< elsewhere the heap cannot be watched: a sanitizer owns it, or the C library is another
#endif

namespace ssjs::testing {

/// Of the thread that asks, since it began.
inline thread_local long allocations = 0;

}  // namespace ssjs::testing

#ifdef SSJS_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* block, std::size_t size);             // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT(bugprone-reserved-identifier)

void* malloc(std::size_t size) noexcept {
  ++ssjs::testing::allocations;
  return __libc_malloc(size);
}
void* realloc(void* block, std::size_t size) noexcept {
  ++ssjs::testing::allocations;
  return __libc_realloc(block, size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++ssjs::testing::allocations;
  return __libc_calloc(count, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++ssjs::testing::allocations;
  return __libc_memalign(alignment, size);
}
}
#endif
