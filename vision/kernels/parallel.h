// A loop over independent items on a few threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace tribotrack::vision {

/// body(i, worker) for i in [0, count), worker in [0, threads): what a worker keeps is used by one thread at
/// a time. Which worker takes an item is left to chance, so a result must not depend on it. The first
/// exception is thrown again after all threads have ended.
void parallel_for(std::size_t count, int threads, const auto& body) {
  if (threads <= 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i, std::size_t{0});
    return;
  }
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex mutex;
  const auto work = [&](std::size_t worker) {
    for (std::size_t i; (i = next++) < count;) {
      try {
        body(i, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::jthread> others;
  try {
    for (int t = 1; t < threads; ++t) others.emplace_back(work, static_cast<std::size_t>(t));
  } catch (const std::system_error&) {  // no more threads are to be had: those there are do the work
  }
  work(0);
  others.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace tribotrack::vision
