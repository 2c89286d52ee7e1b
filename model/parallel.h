// A loop over independent items on a few threads, for model, fit and apps (vision has its own, whose workers
// are numbered). oneTBB's would do but where the system refuses a thread: its workers then end the program.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <limits>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace tribotrack {

/// How many threads a loop may use that is called from here: those of a loop within a loop are its share of
/// the outer one's, so that together they are no more than were asked for.
inline int& threads_allowed() {
  static thread_local int allowed = std::numeric_limits<int>::max();
  return allowed;
}

/// body(i) for i in [0, count); after an exception no further i is begun, and the first one is thrown again
/// when all threads have ended. The threads are started anew: some 20 us, where one evaluation of tracks
/// takes milliseconds, so that a pool would not pay.
void parallel_for(std::size_t count, int threads, const auto& body) {
  threads = std::min(threads, threads_allowed());
  if (threads <= 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  const int workers = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(threads), count));
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto work = [&] {
    const int before = std::exchange(threads_allowed(), std::max(1, threads / workers));
    for (std::size_t i; (i = next++) < count;) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
    threads_allowed() = before;
  };
  std::vector<std::jthread> pool;
  try {
    for (int t = 1; t < workers; ++t) pool.emplace_back(work);
  } catch (const std::system_error&) {  // no more threads are to be had: those there are do the work
  }
  work();
  pool.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace tribotrack
