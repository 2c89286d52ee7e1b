#include "apps/figures/thinning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tribotrack::apps {

DrawnPath thinned(const std::vector<double>& x, const std::vector<double>& y, std::size_t most) {
  constexpr double pen_up = std::numeric_limits<double>::quiet_NaN();
  const std::size_t count = std::min(x.size(), y.size());
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  DrawnPath path;
  const auto add = [&](double px, double py) {
    path.x.push_back(px);
    path.y.push_back(py);
  };
  bool gap = false;
  for (std::size_t i = 0; i < count; ++i) {
    const bool measured = std::isfinite(x[i]) && std::isfinite(y[i]);
    gap = gap || !measured;
    if (i % step != 0) continue;
    if (gap) add(pen_up, pen_up);
    if (measured) add(x[i], y[i]);
    gap = false;
  }
  return path;
}

std::vector<std::size_t> envelope(const std::vector<double>& y, std::size_t most) {
  std::vector<std::size_t> places;
  if (y.size() <= most) {
    places.resize(y.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    return places;
  }
  const std::size_t stretches = std::max<std::size_t>(1, most / 2);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t begin = k * y.size() / stretches, end = (k + 1) * y.size() / stretches;
    std::size_t lowest = begin, highest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (!std::isfinite(y[lowest]) || y[i] < y[lowest]) lowest = i;
      if (!std::isfinite(y[highest]) || y[i] > y[highest]) highest = i;
    }
    places.push_back(std::min(lowest, highest));
    if (lowest != highest) places.push_back(std::max(lowest, highest));
  }
  return places;
}

std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& places) {
  std::vector<double> chosen;
  chosen.reserve(places.size());
  for (const std::size_t place : places)
    chosen.push_back(place < values.size() ? values[place] : std::numeric_limits<double>::quiet_NaN());
  return chosen;
}

}  // namespace tribotrack::apps
