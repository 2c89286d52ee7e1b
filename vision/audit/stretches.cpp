#include "vision/audit/stretches.h"

namespace tribotrack::vision {

std::vector<Stretch> stretches(const Track& track) {
  std::vector<Stretch> out;
  bool open = false;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok || !(p.sigma_x > 0 && p.sigma_y > 0)) {
      open = false;
      continue;
    }
    if (!open) out.emplace_back();
    open = true;
    Stretch& s = out.back();
    s.x.push_back(p.x);
    s.y.push_back(p.y);
    s.sigma_x.push_back(p.sigma_x);
    s.sigma_y.push_back(p.sigma_y);
  }
  return out;
}

}  // namespace tribotrack::vision
