#include "apps/python/released.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <system_error>
#include <thread>

namespace tribotrack::python {

namespace py = pybind11;

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{50};
constexpr std::chrono::milliseconds kPatience{100};  ///< with work that was asked to stop

/// Asks the work to stop. No std::exception: nobody takes it for an error of one run of many.
struct Stop {};

struct Told {
  std::string stage;
  std::int64_t done = 0, total = 0;
};

/// What the working and the waiting thread share.
struct Task {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::exception_ptr failure;
  std::optional<Told> told;  ///< the latest, not yet passed on
  std::atomic<bool> stop = false;

  void tell(const std::string& stage, std::int64_t finished, std::int64_t total) {
    if (stop) throw Stop{};
    const std::lock_guard lock(mutex);
    told = Told{stage, finished, total};
  }
  void finish(std::exception_ptr with) {
    const std::lock_guard lock(mutex);
    failure = std::move(with);
    done = true;
    changed.notify_all();
  }
};

/// Work that was asked to stop and has not yet: its thread, and what must live until it ends.
struct Stopped {
  std::thread thread;
  std::shared_ptr<Task> task;
  std::shared_ptr<void> kept;
};

/// Touched with Python's lock only.
std::list<Stopped>& stopped_work() {
  static std::list<Stopped> all;
  return all;
}

bool ended(Task& task) {
  const std::lock_guard lock(task.mutex);
  return task.done;
}

void collect_ended() {
  auto& all = stopped_work();
  for (auto one = all.begin(); one != all.end();) {
    if (!ended(*one->task)) {
      ++one;
      continue;
    }
    one->thread.join();
    one = all.erase(one);
  }
}

/// True where the task ended within `time`; hands out what it told since.
bool wait(Task& task, std::chrono::milliseconds time, std::optional<Told>& told) {
  const py::gil_scoped_release unlocked;
  std::unique_lock lock(task.mutex);
  const bool done = task.changed.wait_for(lock, time, [&] { return task.done; });
  told = std::exchange(task.told, std::nullopt);
  return done;
}

void look_after(Task& task, const py::object& progress) {
  std::optional<Told> told;
  for (bool done = false; !done;) {
    done = wait(task, kBetweenLooks, told);
    if (told && !progress.is_none()) progress(told->stage, told->done, told->total);
    if (!done && PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

}  // namespace

void release(const std::function<void(const Tell&)>& work, const py::object& progress,
             const std::shared_ptr<void>& kept) {
  collect_ended();
  const auto task = std::make_shared<Task>();
  std::thread thread;
  try {
    thread = std::thread([task, begun = work]() mutable {
      std::exception_ptr failure;
      try {
        begun([&task](const std::string& stage, std::int64_t done, std::int64_t total) {
          task->tell(stage, done, total);
        });
      } catch (...) {
        failure = std::current_exception();
      }
      begun = nullptr;  // what it holds ends before `kept` does
      task->finish(failure);
    });
  } catch (const std::system_error&) {  // no more threads are to be had: this one does the work
    const py::gil_scoped_release unlocked;
    return work([](const std::string&, std::int64_t, std::int64_t) {});
  }
  try {
    look_after(*task, progress);
  } catch (...) {
    task->stop = true;
    std::optional<Told> ignored;
    if (wait(*task, kPatience, ignored))
      thread.join();
    else
      stopped_work().push_back({std::move(thread), task, kept});
    throw;
  }
  thread.join();
  if (task->failure) std::rethrow_exception(task->failure);
}

void wait_for_stopped_work() {
  std::list<Stopped> all;
  all.swap(stopped_work());
  const py::gil_scoped_release unlocked;
  for (Stopped& one : all) one.thread.join();
}  // takes the lock again before `all` ends: what is kept may be Python's

}  // namespace tribotrack::python
