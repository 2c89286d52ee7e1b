#include "apps/python/released.h"

#include <atomic>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "apps/recording/track.h"
#include "fit/measurement.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;

namespace {

py::object type_named(const char* name) {
  return py::module_::import("tribotrack._errors").attr(name);
}

py::object made(const char* type, const std::exception& error) {
  return type_named(type)(in_keywords(error.what()));
}

void raise(const py::object& exception) {
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

py::object ambiguous(const apps::AmbiguousPart& error) {
  py::object exception = made("AmbiguousPartError", error);
  py::list discs;
  for (const vision::Circle& disc : error.discs) discs.append(py::make_tuple(disc.x, disc.y, disc.radius));
  exception.attr("frame") = error.frame;
  exception.attr("discs_px") = discs;
  return exception;
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const MissingFile& missing) {
    raise(made("MissingFileError", missing));
  } catch (const apps::AmbiguousPart& question) {
    raise(ambiguous(question));
  } catch (const apps::UsageError& refused) {
    raise(made("InputError", refused));
  } catch (const apps::InvalidInput& refused) {
    raise(made("InputError", refused));
  } catch (const vision::InputError& refused) {
    raise(made("InputError", refused));
  } catch (const fit::DataError& refused) {
    raise(made("InputError", refused));
  } catch (const std::invalid_argument& refused) {  // model::InvalidParameter, too
    raise(made("InputError", refused));
  } catch (const model::StepLimitExceeded& refused) {
    raise(made("InputError", refused));
  }
}

bool starts_word(const std::string& text, std::size_t at) {
  return at == 0 || text[at - 1] == ' ' || text[at - 1] == '(' || text[at - 1] == '`';
}

}  // namespace

std::string in_keywords(const std::string& sentence) {
  std::string said;
  for (std::size_t at = 0; at < sentence.size();) {
    const bool flag = sentence.compare(at, 2, "--") == 0 && starts_word(sentence, at) &&
                      at + 2 < sentence.size() && std::islower(static_cast<unsigned char>(sentence[at + 2]));
    if (!flag) {
      said += sentence[at++];
      continue;
    }
    for (at += 2; at < sentence.size(); ++at) {
      const auto c = static_cast<unsigned char>(sentence[at]);
      if (std::islower(c) || std::isdigit(c))
        said += sentence[at];
      else if (c == '-')
        said += '_';
      else
        break;
    }
    const bool value = at + 1 < sentence.size() && sentence[at] == ' ' &&
                       std::isdigit(static_cast<unsigned char>(sentence[at + 1]));
    if (value) said += '=', ++at;
  }
  return said;
}

void require_there(const std::filesystem::path& file, const std::exception& error) {
  std::error_code unknown;
  if (!std::filesystem::exists(file, unknown)) throw MissingFile(error.what());
}

void translate_errors() {
  py::register_exception_translator(&translate);
}

void warn_of_quality(const std::string& sentence) {
  if (PyErr_WarnEx(type_named("QualityWarning").ptr(), in_keywords(sentence).c_str(), 2) != 0)
    throw py::error_already_set();
}

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
