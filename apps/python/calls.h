// What tribotrack/_calling.py calls: a source's path and the keywords as JSON come in; columns, a JSON object
// and sentences of doubt go out. Work runs without Python's lock.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "apps/text/json.h"
#include "vision/picture.h"

namespace tribotrack::python {

/// A function's keywords; what is null is not there. The errors are UsageErrors that name the flag.
class Options {
 public:
  explicit Options(const std::string& json);
  const apps::Json* find(const std::string& name) const;  ///< null: not there
  std::optional<double> number(const std::string& name) const;
  double number_of(const std::string& name,
                   const apps::Json& value) const;  ///< angles of *_rad as texts, too
  std::string text(const std::string& name) const;  ///< empty: not there
  bool truth(const std::string& name) const;
  std::optional<long> whole(const std::string& name) const;
  std::optional<std::vector<double>> numbers(const std::string& name, std::size_t count,
                                             const char* form) const;
  std::optional<vision::Circle> circle(const std::string& name) const;  ///< (x, y, radius), px
  const apps::Json& all() const { return values_; }

 private:
  apps::Json values_;
};

/// How work tells of its progress, from any of its threads.
using Tell = std::function<void(const std::string& stage, std::int64_t done, std::int64_t total)>;

/// Calls `tell` twenty times a second at most; where that raises, the work ends by an exception that is no
/// std::exception: nobody takes it for an error of one run of many. `tell` must outlive it.
Tell teller(const pybind11::function& tell);

template <class Work>
auto without_lock(const pybind11::function& tell, const Work& work) {
  const Tell told = teller(tell);
  const pybind11::gil_scoped_release unlocked;
  return work(told);
}

/// Arrays and lists by their names, an object's text, and why the result should not be used as it is.
using Returned = std::tuple<pybind11::dict, std::string, std::vector<std::string>>;

/// `frames`: None, or an array of grey levels (frames, height, width) in place of the path.
Returned track(const std::string& path, const std::string& options, const pybind11::function& tell,
               const pybind11::object& frames);

inline pybind11::array_t<double> array_of(const std::vector<double>& values) {
  return pybind11::array_t<double>(static_cast<pybind11::ssize_t>(values.size()), values.data());
}

}  // namespace tribotrack::python
