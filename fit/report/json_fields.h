// The fields of a struct as the keys of a JSON object, named once for both ways: for a struct S stands
//
//   void fields(auto& io, S& s) { io.need("run", s.run); io("deviation", s.deviation); }
//
// by which a Writer makes an object with its keys in that order and a Reader fills S from one. `io(key,
// value)` is what an older file may lack, `io.need(key, value)` what none does.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "fit/fit_result.h"
#include "fit/json.h"

namespace tribotrack::fit::internal {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

using Order = std::vector<FitParameter>;  // of FitResult::parameters: what stands by name in the file

/// Of an enumeration from 0 to the last.
template <class Enum>
std::vector<std::string> names_to(Enum last) {
  std::vector<std::string> words;
  for (int k = 0; k <= static_cast<int>(last); ++k) words.emplace_back(to_string(static_cast<Enum>(k)));
  return words;
}
inline std::vector<std::string> words_of(Verdict) {
  return {"identifiable", "weak", "not identifiable"};
}
inline std::vector<std::string> words_of(Loss) {
  return {"squares", "huber"};
}
inline std::vector<std::string> words_of(model::Start) {
  return {"rest", "circling", "steady"};
}
inline std::vector<std::string> words_of(Agreement) {
  return names_to(Agreement::unknown);
}
inline std::vector<std::string> words_of(Use) {
  return names_to(Use::do_not_use);
}
inline std::vector<std::string> words_of(FitParameter) {
  return names_to(FitParameter::static_friction);
}

class Writer {
 public:
  Writer(Json& object, const Order& order) : json_(object), order_(order) {}

  void operator()(const char* key, auto& value, bool there = true) {
    if (there) json_[key] = written(value);
  }
  void need(const char* key, auto& value) { json_[key] = written(value); }
  void sd(const char* key, double& value) { json_[key] = finite_json(value); }
  /// SI here, by `unit` larger numbers in the file.
  void scaled(const char* key, double& value, double unit, bool there = true) {
    if (there) json_[key] = finite_json(value * unit);
  }
  void scaled(const char* key, std::vector<double>& values, double unit) {
    Json& list = json_[key] = Json::array();
    for (const double value : values) list.push_back(finite_json(value * unit));
  }
  /// One number of each parameter, by their names.
  void by_name(const char* key, auto& values, bool = false) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(values.size()); ++k)
      json_[key][to_string(order_[k])] = finite_json(values[static_cast<Eigen::Index>(k)]);
  }
  void by_name(const char* key, Eigen::MatrixXd& matrix) {
    json_[key] = Json::object();
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      for (Eigen::Index j = 0; j < matrix.cols(); ++j)
        json_[key][name(i)][name(j)] = finite_json(matrix(i, j));
  }
  /// Structs by the name of their parameter.
  template <class T>
  void records(const char* key, std::vector<T>& parameters) {
    json_[key] = Json::object();
    for (T& p : parameters) json_[key][to_string(p.parameter)] = written(p);
  }
  template <class T>
  void those_with(const char*, const char* key, std::vector<T>& runs) {
    json_[key] = written(runs);
  }
  /// Follows from the other fields.
  void derived(const char* key, const Json& value) { json_[key] = value; }
  void check(const char*, const auto&) {}

 private:
  const char* name(Eigen::Index k) const { return to_string(order_[static_cast<std::size_t>(k)]); }

  template <class T>
  Json written(T& value) const {
    if constexpr (std::is_enum_v<T>) {
      return words_of(T{})[static_cast<std::size_t>(value)];
    } else if constexpr (std::is_floating_point_v<T>) {
      return finite_json(value);
    } else if constexpr (requires(Writer & io) { fields(io, value); }) {
      Json object = Json::object();
      Writer inner(object, order_);
      fields(inner, value);
      return object;
    } else {
      return value;
    }
  }
  Json written(Interval& interval) const {
    return Json::array({finite_json(interval.low), finite_json(interval.high)});
  }
  template <class T>
  Json written(std::optional<T>& value) const {
    return value ? written(*value) : Json();
  }
  template <class T>
  Json written(std::vector<T>& values) const {
    Json list = Json::array();
    for (T& value : values) list.push_back(written(value));
    return list;
  }
  template <class T>
  Json written(std::map<FitParameter, T>& values) const {
    Json object = Json::object();
    for (auto& [parameter, value] : values) object[to_string(parameter)] = written(value);
    return object;
  }

  Json& json_;
  const Order& order_;
};

class Reader {
 public:
  Reader(JsonPlace place, Order& order) : place_(std::move(place)), order_(order) { place_.object(); }

  /// A number or interval that is not there is NaN.
  template <class T>
  void operator()(const char* key, T& value, bool = true) {
    if (const auto found = place_.find(key)) return read(*found, value);
    if constexpr (std::is_floating_point_v<T>) value = kNoNumber;
    if constexpr (std::is_same_v<T, Interval>) value = {kNoNumber, kNoNumber};
  }
  void need(const char* key, auto& value) { read(place_.at(key), value); }
  void sd(const char* key, double& value) {
    const JsonPlace place = place_.at(key);
    value = place.number_or_null();
    if (value < 0) place.refuse("0 or more");
  }
  void scaled(const char* key, double& value, double unit, bool = true) {
    value = place_.number(key, kNoNumber) * (1 / unit);
  }
  void scaled(const char* key, std::vector<double>& values, double unit) {
    (*this)(key, values);
    for (double& value : values) value *= 1 / unit;
  }
  /// Where there is none all are NaN, or, if it `may_lack`, there is none.
  void by_name(const char* key, auto& values, bool may_lack = false) {
    const auto found = place_.find(key);
    if (!found && may_lack) return;
    values.resize(static_cast<Eigen::Index>(order_.size()));
    for (std::size_t k = 0; k < order_.size(); ++k)
      values[static_cast<Eigen::Index>(k)] =
          found ? found->number(to_string(order_[k]), kNoNumber) : kNoNumber;
  }
  void by_name(const char* key, Eigen::MatrixXd& matrix) {
    const JsonPlace place = place_.at(key);
    const auto n = static_cast<Eigen::Index>(order_.size());
    matrix.resize(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) matrix(i, j) = place.at(name(i)).at(name(j)).number_or_null();
  }
  template <class T>
  void records(const char* key, std::vector<T>& parameters) {
    const JsonPlace place = place_.at(key);
    parameters.clear();
    for (const auto& [parameter, p] : named(place)) {
      parameters.emplace_back().parameter = parameter;
      order_.push_back(parameter);
      read(p, parameters.back());
    }
    if (parameters.empty()) place.refuse("an object with the fitted parameters");
  }
  /// Of a list those that hold `member`.
  template <class T>
  void those_with(const char* member, const char* key, std::vector<T>& runs) {
    runs.clear();
    for (const JsonPlace& run : place_.items(key))
      if (run.find(member)) read(run, runs.emplace_back());
  }
  void derived(const char*, const Json&) {}
  void check(const char* key, const auto& test) { test(place_.at(key)); }

 private:
  const char* name(Eigen::Index k) const { return to_string(order_[static_cast<std::size_t>(k)]); }

  template <class Enum>
  static std::optional<Enum> meant(const std::string& word) {
    const std::vector<std::string> words = words_of(Enum{});
    const auto found = std::ranges::find(words, word);
    if (found == words.end()) return std::nullopt;
    return static_cast<Enum>(found - words.begin());
  }
  std::vector<std::pair<FitParameter, JsonPlace>> named(const JsonPlace& place) const {
    std::vector<std::pair<FitParameter, JsonPlace>> all;
    for (const auto& item : place.object().value.items()) {
      const auto parameter = meant<FitParameter>(item.key());
      if (!parameter) place.refuse("an object of fitted parameters by their names");
      all.emplace_back(*parameter, place.at(item.key()));
    }
    return all;
  }

  template <class T>
  void read(const JsonPlace& place, T& value) const {
    if constexpr (std::is_enum_v<T>) {
      if (const auto known = meant<T>(place.text())) {
        value = *known;
        return;
      }
      std::string list;
      const std::vector<std::string> words = words_of(T{});
      for (std::size_t k = 0; k < words.size(); ++k)
        list += fmt::format("{}\"{}\"", k == 0 ? "" : k + 1 < words.size() ? ", " : " or ", words[k]);
      place.refuse(list);
    } else if constexpr (std::is_same_v<T, bool>) {
      value = place.boolean();
    } else if constexpr (std::is_same_v<T, std::size_t> || std::is_same_v<T, unsigned>) {
      const std::int64_t count = place.whole();
      if (count < 0 || count > std::numeric_limits<std::uint32_t>::max())
        place.refuse("0 or more, below 2^32");
      value = static_cast<T>(count);
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
      value = place.whole();
    } else if constexpr (std::is_integral_v<T>) {
      value = place.integer();
    } else if constexpr (std::is_floating_point_v<T>) {
      value = place.number_or_null();
    } else if constexpr (std::is_same_v<T, std::string>) {
      value = place.text();
    } else {
      Reader inner(place, order_);
      fields(inner, value);
    }
  }
  void read(const JsonPlace& place, Interval& interval) const {
    if (!place.value.is_array() || place.value.size() != 2) place.refuse("a list of two numbers");
    interval = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    if (!place.value[0].is_null()) interval.low = place.at(std::size_t{0}).number();
    if (!place.value[1].is_null()) interval.high = place.at(1).number();
    if (interval.low > interval.high) place.refuse("an interval, the low end first");
  }
  template <class T>
  void read(const JsonPlace& place, std::optional<T>& value) const {
    read(place, value.emplace());
  }
  template <class T>
  void read(const JsonPlace& place, std::vector<T>& values) const {
    values.clear();
    for (const JsonPlace& item : place.items()) read(item, values.emplace_back());
  }
  template <class T>
  void read(const JsonPlace& place, std::map<FitParameter, T>& values) const {
    values.clear();
    for (const auto& [parameter, item] : named(place)) read(item, values[parameter]);
  }
  void read(const JsonPlace& place, std::map<std::string, double>& values) const {
    values.clear();
    for (const auto& item : place.object().value.items())
      values[item.key()] = place.at(item.key()).number_or_null();
  }

  JsonPlace place_;
  Order& order_;
};

}  // namespace tribotrack::fit::internal
