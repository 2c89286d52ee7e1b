// Tracks and halves whose errors are drawn from known laws.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/track.h"

namespace tribotrack::vision::test {

inline constexpr double kSigma = 0.01;  ///< px, reported

/// Positions of both coordinates by frame and random generator, at 1000 frames/s.
inline Track track_of(int frames, unsigned seed, const std::function<double(int)>& motion,
                      const std::function<double(int, std::mt19937&)>& error) {
  std::mt19937 random(seed);
  Track track;
  for (int k = 0; k < frames; ++k) {
    TrackPoint p;
    p.frame = k;
    p.time_s = 1e-3 * k;
    p.status = TrackStatus::ok;
    p.x = 100 + motion(k) + error(k, random);
    p.y = 80 - 0.7 * motion(k + 3) + error(k, random);
    p.sigma_x = p.sigma_y = kSigma;
    track.points.push_back(p);
  }
  return track;
}

inline double white(std::mt19937& random, double sd = kSigma) {
  return sd * std::normal_distribution<>()(random);
}

/// Halves of the audited frames of a recording, each component of each split by `error` plus an offset of its
/// own that is constant over the recording.
inline std::vector<AuditFrame> halves_of(
    std::int64_t total, unsigned seed, const std::function<double(std::int64_t, int, std::mt19937&)>& error) {
  std::mt19937 random(seed);
  std::vector<AuditFrame> out;
  for (std::int64_t k = 0; k < total; ++k) {
    if (!in_audit(k, total)) continue;
    AuditFrame frame{k, {}, kSigma * kSigma * Eigen::Matrix2d::Identity()};
    int component = 0;
    for (auto* e : {&frame.error.left_right, &frame.error.top_bottom, &frame.error.checkerboard})
      for (Eigen::Index i = 0; i < 2; ++i, ++component)
        (*e)(i) = 0.05 * component + error(k, component, random);
    out.push_back(frame);
  }
  return out;
}

}  // namespace tribotrack::vision::test
