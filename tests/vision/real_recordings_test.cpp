// Tracks of sliding carrom men against a circle fit: coded pictures that nobody here made. Skipped unless
// TRIBOTRACK_REAL_DATA names their folder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "vision/circle_fit_judge.h"
#include "vision/recordings.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

/// A man, where it is in the first frame, and the frames in which it is judged.
struct Man {
  std::string name, file;
  Circle first;
  std::int64_t start, from, to;
};

void PrintTo(const Man& man, std::ostream* out) {
  *out << man.name;
}

/// Positions of one man in consecutive frames, x then y.
using Path = Eigen::MatrixX2d;

/// Noise of a coordinate by second differences, px: whatever moves smoothly drops out.
double noise(const Path& p) {
  const Eigen::Index n = p.rows() - 2;
  return std::sqrt((p.topRows(n) - 2 * p.middleRows(1, n) + p.bottomRows(n)).squaredNorm() /
                   (6.0 * 2 * static_cast<double>(n)));
}

/// What a polynomial of the sixth degree in time leaves.
Path residual(const Path& p) {
  Eigen::MatrixXd powers(p.rows(), 7);
  for (Eigen::Index k = 0; k < p.rows(); ++k)
    for (int j = 0; j < 7; ++j)
      powers(k, j) =
          std::cos(j * std::acos(std::clamp(
                           2.0 * static_cast<double>(k) / static_cast<double>(p.rows() - 1) - 1, -1.0, 1.0)));
  return p - powers * powers.householderQr().solve(p).eval();
}

double lag_one(const Eigen::VectorXd& r) {
  const Eigen::Index n = r.size() - 1;
  return r.head(n).dot(r.tail(n)) / r.squaredNorm();
}

class CarromMen : public testing::TestWithParam<std::tuple<Man, Layers>> {};

TEST_P(CarromMen, AreTrackedAsWellAsByACircleFitWithATrueSd) {
  if (real_data().empty()) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA names no folder";
  const auto& [man, layers] = GetParam();
  SourceOptions rate;
  rate.frame_rate_hz = 240;
  const auto source = open_source(real_data() / "carrom" / man.file, rate);
  TrackOptions options;
  options.target = {Target::Kind::disc, man.first, {}};
  options.first_frame = man.start;
  options.last_frame = man.to;
  options.layers = layers;
  const TrackResult result = track(*source, options);

  const auto count = static_cast<Eigen::Index>(man.to - man.from + 1);
  Path ours(count, 2), sd(count, 2), judged(count, 2);
  for (Eigen::Index k = 0; k < count; ++k) {
    const TrackPoint& p = result.track.points[static_cast<std::size_t>(man.from - man.start + k)];
    ASSERT_EQ(p.status, TrackStatus::ok) << "frame " << p.frame;
    const Circle c = test::circle_fit(source->read(p.frame), {p.x, p.y, result.summary.disc.radius});
    ours.row(k) << p.x, p.y;
    sd.row(k) << p.sigma_x, p.sigma_y;
    judged.row(k) << c.x, c.y;
  }
  const Path left = residual(ours);
  const double ratio = std::sqrt((left.array() / sd.array()).square().mean() * static_cast<double>(count) /
                                 static_cast<double>(count - 7));
  const double lag = std::min(lag_one(left.col(0)), lag_one(left.col(1)));
  EXPECT_LE(noise(ours), noise(judged));
  EXPECT_GT(lag, -0.2);
  EXPECT_GT(ratio, 0.8);
  EXPECT_LT(ratio, 1.3);
}

const Man kMen[] = {
    {"HeadOnSlides", "HeadOn.MP4", {151, 87, 9}, 188, 192, 272},
    {"HeadOnRests", "HeadOn.MP4", {151, 87, 9}, 120, 120, 186},
    {"RotationComesIn", "Rotation.MP4", {33, 74, 9}, 202, 204, 238},
    {"RotationStrikerSlidesOn", "Rotation.MP4", {33, 74, 9}, 202, 246, 335},
    {"RotationStruckManSlides", "Rotation.MP4", {160.5, 113, 9}, 246, 248, 335},
    {"RotationRests", "Rotation.MP4", {33, 74, 9}, 202, 500, 700},
};

INSTANTIATE_TEST_SUITE_P(Default, CarromMen,
                         testing::Combine(testing::ValuesIn(kMen), testing::Values(Layers::automatic)),
                         [](const auto& test) { return std::get<0>(test.param).name; });

}  // namespace
}  // namespace tribotrack::vision
