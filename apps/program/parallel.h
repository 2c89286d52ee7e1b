// Independent pieces of work on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace tribotrack::apps {

/// Calls work(0) .. work(count - 1), each once, on `threads` threads. The first exception is rethrown here
/// after all have ended.
template <class Work>
void for_each_index(long count, int threads, const Work& work) {
  std::atomic<long> next = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto take = [&] {
    for (long index = next++; index < count; index = next++) try {
        work(index);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
  };
  std::vector<std::jthread> workers;
  try {
    for (long k = 1; k < std::min<long>(threads, count); ++k) workers.emplace_back(take);
  } catch (const std::system_error&) {  // no more threads are to be had: those there are do the work
  }
  take();
  workers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tribotrack::apps
