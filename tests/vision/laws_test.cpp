// Laws of the tracker: what a change of a recording does to its track. They hold for any recording, so they
// need no truth; the recording is rendered analytically, with noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

constexpr double kRadius = 12, kNoise = 1.5, kRate = 500;
constexpr int kFrames = 40;
/// px: what may differ where pixels are the same but lie elsewhere. The registration stops at a step of 1e-4
/// px, of which Gauss-Newton leaves a few hundredths, and the noise is estimated from other pixels (2e-6 px
/// were seen, at standard deviations of 4.5e-3 px).
constexpr double kElsewhere = 1e-5;

using Frames = std::vector<Picture>;

Point truth(int frame) {
  const double turn = 0.31 * frame;
  return {52.3 + 6.7 * std::cos(turn) + 0.031 * frame, 45.8 - 6.7 * std::sin(turn)};
}

/// Grey levels are not rounded, so that I -> a I + b loses nothing. `size` 2: everything twice as large, in
/// pixels twice as fine.
Frames rendered(int size = 1, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kNoise);
  Frames frames;
  for (int k = 0; k < kFrames; ++k) {
    test::TestScene scene;
    scene.width = 104 * size;
    scene.height = 92 * size;
    scene.blur *= size;
    test::TestDisc disc;
    // A pixel's centre has whole coordinates: those of the lower left pixel of 2 x 2 lie a quarter off.
    disc.x = size * truth(k).x + 0.5 * (size - 1);
    disc.y = size * truth(k).y + 0.5 * (size - 1);
    disc.radius = size * kRadius;
    scene.discs = {disc};
    Picture frame = scene.render();
    for (float& level : frame.levels()) level += static_cast<float>(noise(random));
    frames.push_back(std::move(frame));
  }
  return frames;
}

const Frames& recording() {
  static const Frames frames = rendered();
  return frames;
}

std::vector<TrackPoint> tracked(Frames frames, const Circle& disc) {
  MemorySource source(std::move(frames), kRate);
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = disc;
  options.layers = Layers::off;
  TrackResult result = track(source, options);
  EXPECT_EQ(result.summary.ok, kFrames);
  return result.track.points;
}

Circle start(int frame = 0) {
  return {truth(frame).x, truth(frame).y, kRadius};
}

const std::vector<TrackPoint>& ordinary() {
  static const std::vector<TrackPoint> points = tracked(recording(), start());
  return points;
}

/// Every frame with the pixel from(x, y) at (x, y).
Frames moved(int width, int height, const std::function<float(const Picture&, int, int)>& from) {
  Frames frames;
  for (const Picture& frame : recording()) {
    Picture out(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) out.at(x, y) = from(frame, x, y);
    frames.push_back(std::move(out));
  }
  return frames;
}

double largest_distance(const std::vector<TrackPoint>& points, const std::function<Point(Point)>& wanted) {
  double largest = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point w = wanted({ordinary()[k].x, ordinary()[k].y});
    largest = std::max(largest, std::hypot(points[k].x - w.x, points[k].y - w.y));
  }
  return largest;
}

/// rms of the differences' components over their standard deviation, the mean difference removed.
double standardised(const std::vector<Point>& differences, double sigma) {
  Point mean;
  for (const Point& d : differences) {
    mean.x += d.x / static_cast<double>(differences.size());
    mean.y += d.y / static_cast<double>(differences.size());
  }
  double square = 0;
  for (const Point& d : differences) square += std::pow(d.x - mean.x, 2) + std::pow(d.y - mean.y, 2);
  return std::sqrt(square / (2 * static_cast<double>(differences.size() - 1))) / sigma;
}

TEST(TrackerLaws, AShiftByWholePixelsShiftsTheTrack) {
  const int w = recording()[0].width(), h = recording()[0].height();
  for (const auto& [dx, dy] : {std::pair(5, -3), std::pair(-11, 7)}) {
    const auto points = tracked(moved(w, h,
                                      [&, dx = dx, dy = dy](const Picture& p, int x, int y) {
                                        return p.at((x - dx + w) % w, (y - dy + h) % h);
                                      }),
                                {truth(0).x + dx, truth(0).y + dy, kRadius});
    EXPECT_LT(largest_distance(points,
                               [dx = dx, dy = dy](Point p) {
                                 return Point{p.x + dx, p.y + dy};
                               }),
              kElsewhere);
  }
}

TEST(TrackerLaws, GainAndOffsetOfTheLightChangeNothing) {
  // Levels are kept to 2^-24 of themselves: as much noise as 1e-5 levels, against the 1.5 that cost 0.01 px.
  const int w = recording()[0].width(), h = recording()[0].height();
  for (const auto& [gain, offset] : {std::pair(1.25F, 17.0F), std::pair(0.5F, 40.0F)}) {
    const auto points = tracked(moved(w, h,
                                      [gain = gain, offset = offset](const Picture& p, int x, int y) {
                                        return gain * p.at(x, y) + offset;
                                      }),
                                start());
    EXPECT_LT(largest_distance(points, [](Point p) { return p; }), 1e-6) << gain << ' ' << offset;
  }
}

TEST(TrackerLaws, AMirroredRecordingHasAMirroredTrack) {
  const int w = recording()[0].width(), h = recording()[0].height();
  const auto across = tracked(moved(w, h, [&](const Picture& p, int x, int y) { return p.at(w - 1 - x, y); }),
                              {w - 1 - truth(0).x, truth(0).y, kRadius});
  EXPECT_LT(largest_distance(across, [&](Point p) { return Point{w - 1 - p.x, p.y}; }), kElsewhere);
  const auto upside_down =
      tracked(moved(w, h, [&](const Picture& p, int x, int y) { return p.at(x, h - 1 - y); }),
              {truth(0).x, h - 1 - truth(0).y, kRadius});
  EXPECT_LT(largest_distance(upside_down, [&](Point p) { return Point{p.x, h - 1 - p.y}; }), kElsewhere);
}

TEST(TrackerLaws, ARecordingTurnedByARightAngleHasATurnedTrack) {
  const int w = recording()[0].width(), h = recording()[0].height();
  const auto points = tracked(moved(h, w, [&](const Picture& p, int x, int y) { return p.at(y, h - 1 - x); }),
                              {h - 1 - truth(0).y, truth(0).x, kRadius});
  EXPECT_LT(largest_distance(points, [&](Point p) { return Point{h - 1 - p.y, p.x}; }), kElsewhere);
}

TEST(TrackerLaws, FramesInReverseOrderGiveTheSamePlaces) {
  Frames reversed(recording().rbegin(), recording().rend());
  const auto points = tracked(std::move(reversed), start(kFrames - 1));
  std::vector<Point> differences;
  for (int k = 1; k + 1 < kFrames; ++k) {  // both templates' own frames left out
    const TrackPoint& one = ordinary()[static_cast<std::size_t>(k)];
    const TrackPoint& other = points[static_cast<std::size_t>(kFrames - 1 - k)];
    differences.push_back({one.x - other.x, one.y - other.y});
  }
  // The noise of a frame is common to both, and the templates' is a mean offset.
  EXPECT_LT(standardised(differences, ordinary()[5].sigma_x), 1);
}

TEST(TrackerLaws, TwiceTheSizeIsTwiceThePlace) {
  const auto points = tracked(rendered(2, 2), {2 * truth(0).x + 0.5, 2 * truth(0).y + 0.5, 2 * kRadius});
  std::vector<Point> differences;
  for (std::size_t k = 1; k < kFrames; ++k)
    differences.push_back({points[k].x - 2 * ordinary()[k].x - 0.5, points[k].y - 2 * ordinary()[k].y - 0.5});
  const double sigma = std::hypot(points[5].sigma_x, 2 * ordinary()[5].sigma_x);
  // Independent noise: 78 components of mean square 1, four standard deviations either way.
  const double share = standardised(differences, sigma);
  EXPECT_NEAR(share * share, 1, 4 * std::sqrt(2.0 / 76));
}

}  // namespace
}  // namespace tribotrack::vision
