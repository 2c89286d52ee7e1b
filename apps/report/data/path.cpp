#include "apps/report/data/path.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace tribotrack::apps
