#include "vision/edge/chamfer.h"

#include <algorithm>
#include <cmath>

#include "vision/edge/samples.h"

namespace tribotrack::vision {
namespace {

constexpr double kShows = 3;       ///< px: three blurs of a lens that is as sharp as its pixels
constexpr double kWidest = 0.07;   ///< of the radius: chamfers of turned and punched parts reach so far
constexpr std::size_t kMost = 32;  ///< frames: their mean's noise is below what no field explains
constexpr double kCell = 0.5;      ///< px: as a quarter of one to some hundredths of a pixel of the edge
constexpr int kBeyondSeen = 4;     ///< px beyond the widest chamfer that are looked at
constexpr double kOfBlur = 0.5;    ///< what the likelihood of fields that are not Gaussian leaves of an edge

/// Rings of each width about where an edge is seen. The likelihood has a minimum for each of the edges that a
/// ring's can be taken for: half a pixel wide at the sharpest.
std::vector<RimOptics> rings(double widest, double blur) {
  std::vector<RimOptics> out;
  for (double width = 0; width <= widest + 0.5; width += 0.5)
    for (double edge = width / 2 - 1; edge <= width + 1; edge += 0.25) out.push_back({edge, blur, width});
  return out;
}

std::optional<RimOptics> optics_of_mean(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                                        double radius, double blur, double noise_variance) {
  RayGrid grid = ray_grid(radius);
  grid.outside = kBeyondSeen + static_cast<int>(std::ceil(kWidest * radius));
  RaySampler sampler(grid);
  std::vector<float> mean(grid.size(), 0), level(grid.size());
  std::size_t count = 0;
  const std::size_t step = std::max<std::size_t>(1, frames.size() / kMost);
  Picture picture;
  for (std::size_t k = 0; k < frames.size(); k += step) {
    const Rect window = sampler.window(frames[k].centre);
    if (!source.bounds().contains(window)) continue;
    source.read(frames[k].index, window, picture);
    sampler.sample(QuinticSpline(picture), window, frames[k].centre, {level.data(), nullptr, nullptr});
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += level[i];
    ++count;
  }
  if (count == 0) return std::nullopt;
  for (float& m : mean) m /= static_cast<float>(count);
  const RaySamples rays = samples_of_mean(grid, mean, noise_variance, count);
  return likeliest_optics(RayFields(grid, kCell), rays, rings(kWidest * radius, blur),
                          RayFields::Beside::chamfer);
}

}  // namespace

OuterEdge outer_edge(FrameSource& source, const std::vector<FirstPassFrame>& frames, double radius,
                     double blur, double noise_variance, std::optional<double> chamfer) {
  if (chamfer) return {0.5 * *chamfer, *chamfer / std::sqrt(12.0), *chamfer, false};
  const double widest = std::min(kWidest * radius, kShows);
  if (kWidest * radius > kShows)
    if (const auto rim = optics_of_mean(source, frames, radius, blur, noise_variance);
        rim && rim->chamfer > kShows)
      return {rim->edge, kOfBlur * rim->blur, rim->chamfer, true};
  return {widest / 3, widest / std::sqrt(18.0), widest, false};
}

}  // namespace tribotrack::vision
