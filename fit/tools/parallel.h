// A loop over independent items on a few threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace tribotrack::fit::internal {

/// body(i) for i in [0, count); after an exception no further i is begun, and the first one is thrown again
/// when all threads have ended. The threads are started anew: some 20 us, where one evaluation of tracks
/// takes milliseconds, so that a pool would not pay.
template <class Body>
void parallel_for(std::size_t count, int threads, const Body& body) {
  if (threads <= 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i; (i = next++) < count;) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::jthread> pool;
  try {
    for (int t = 1; t < threads; ++t) pool.emplace_back(work);
  } catch (const std::system_error&) {  // no more threads are to be had: those there are do the work
  }
  work();
  pool.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace tribotrack::fit::internal
