// The drive in quadruple precision, and where it passes friction.
#pragma once

#include "model/quad_math.h"

namespace tribotrack::model::reference {

/// d(s) = constant + p cos s + q sin s.
struct QuadDrive {
  quad constant_x = 0, constant_y = 0, px = 0, py = 0, qx = 0, qy = 0;
  void at(quad s, quad& x, quad& y) const {
    quad sine, cosine;
    sine_cosine(s, sine, cosine);
    x = constant_x + px * cosine + qx * sine;
    y = constant_y + py * cosine + qy * sine;
  }

  /// |d|^2 - kappa^2: friction holds where it is negative.
  quad excess(quad s, quad kappa) const {
    quad dx, dy;
    at(s, dx, dy);
    return dx * dx + dy * dy - kappa * kappa;
  }
  /// Half of its derivative.
  quad excess_slope(quad s) const {
    quad dx, dy, k, c;
    at(s, dx, dy);
    sine_cosine(s, k, c);
    return dx * (qx * c - px * k) + dy * (qy * c - py * k);
  }

  /// The first phase in [from, to] at which sign * excess grows through sign * level; `to` if none. A grid,
  /// and the peaks between its points: the excess has at most four extrema a cycle.
  quad crossing(quad kappa, quad from, quad to, quad level, int sign) const {
    const auto above = [&](quad s) { return sign * (excess(s, kappa) - level) > 0; };
    const auto climbs = [&](quad s) { return sign * excess_slope(s) > 0; };
    const auto bisect = [](quad low, quad high, auto&& beyond) {
      for (int i = 0; i < 110; ++i) {
        const quad middle = (low + high) / 2;
        (beyond(middle) ? high : low) = middle;
      }
      return high;
    };
    const quad grid = pi() / 200;
    for (quad low = from; low < to;) {
      const quad high = low + grid < to ? low + grid : to;
      if (above(high)) return bisect(low, high, above);
      if (climbs(low) && !climbs(high)) {
        const quad peak = bisect(low, high, [&](quad s) { return !climbs(s); });
        if (above(peak)) return bisect(low, peak, above);
      }
      low = high;
    }
    return to;
  }
};

}  // namespace tribotrack::model::reference
