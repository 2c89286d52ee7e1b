// Follows a disc through a recording, with the standard deviation of every position. Use:
//   track                    a rendered recording whose truth is known: errors beside standard deviations
//   track VIDEO X Y RADIUS   yours, the disc as it lies in the first frame, px; writes frame,x_px,y_px,sds
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <vector>

#include "vision/frame_source.h"
#include "vision/scene.h"
#include "vision/tracker.h"

using namespace tribotrack::vision;

namespace {

/// A disc that circles slowly, seen 120 times at 1000 frames/s.
ScenePose truth(double t) {
  return {{160 + 12 * std::cos(40 * t), 120 - 12 * std::sin(40 * t)}, 0.2 * t, {}};
}

TrackResult track_rendered() {
  const SceneRenderer renderer{Scene{}};  // a scratched disc of 30 px on a brushed platform
  std::vector<Picture> frames;
  for (int k = 0; k < 120; ++k) frames.push_back(renderer.render(k, k / 1000.0, 200e-6, truth));
  MemorySource source(std::move(frames), 1000);
  TrackOptions options;
  options.target = {Target::Kind::disc, {172, 120, 30}, {}};
  return track(source, options);
}

/// Template matching finds how far the disc has moved: the error is that of the way from the first frame, in
/// which both ends err, so that sqrt 2 standard deviations are right.
void print_errors(const TrackResult& result) {
  const Point start = truth(0).disc;
  double squares = 0;
  std::vector<double> sds;
  const TrackPoint& first = result.track.points.front();
  for (const TrackPoint& p : result.track.points) {
    if (p.status != TrackStatus::ok) continue;
    const ScenePose at = truth(p.time_s);
    squares += std::pow(p.x - first.x - (at.disc.x - start.x), 2);
    sds.push_back(p.sigma_x);
  }
  std::nth_element(sds.begin(), sds.begin() + static_cast<std::ptrdiff_t>(sds.size() / 2), sds.end());
  std::printf("%zu of %zu frames; error of x %.4f px rms, standard deviation %.4f px\n", sds.size(),
              result.track.points.size(), std::sqrt(squares / static_cast<double>(sds.size())),
              sds[sds.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 1 && argc != 5) {
    std::fprintf(stderr, "use: track [VIDEO X Y RADIUS]\n");
    return 2;
  }
  if (argc == 1) {
    print_errors(track_rendered());
    return 0;
  }
  const auto source = open_source(argv[1]);
  TrackOptions options;
  options.target = {Target::Kind::disc, {std::atof(argv[2]), std::atof(argv[3]), std::atof(argv[4])}, {}};
  const TrackResult result = track(*source, options);
  std::fprintf(stderr, "%s\n", result.summary.brief_report().c_str());
  std::printf("frame,x_px,y_px,sigma_x_px,sigma_y_px\n");
  for (const TrackPoint& p : result.track.points)
    if (p.status == TrackStatus::ok)  // other frames have no position
      std::printf("%lld,%.5f,%.5f,%.5f,%.5f\n", static_cast<long long>(p.frame), p.x, p.y, p.sigma_x,
                  p.sigma_y);
  return result.summary.gate_passed ? 0 : 1;
} catch (const std::exception& error) {  // InputError: one sentence with file, place and remedy
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
