#include "vision/layers/model/model.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/kernels/median.h"
#include "vision/kernels/parallel.h"
#include "vision/kernels/plane.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr float kLeastShare = 0.1F;  ///< of the ground that shows: less would lean on the part's own picture
constexpr float kFramesNeeded = 3;   ///< fewer do not tell how a place's level scatters

/// The mean over 3 x 3 places: the interpolation leans on the neighbours.
Picture box_mean(const Picture& in) {
  Picture out = in;
  cv::blur(matrix_of(in), matrix_of(out), {3, 3}, {-1, -1}, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace

GroundPicture::GroundPicture(const Rect& region)
    : region_(region),
      away_(region),
      beside_(region),
      frames_beside_(region.width, region.height),
      variance_(region.width, region.height) {}

void GroundPicture::add(const Picture& picture, int x, int y, const Point& displacement,
                        const Circle& hidden) {
  const Rect places = places_shown(region_, {x, y, picture.width(), picture.height()}, displacement, 0);
  if (places.width <= 0 || places.height <= 0) return;
  const int u0 = places.x, v0 = places.y, width = places.width, height = places.height;
  Picture moved(width, height);
  QuinticSpline(picture).sample_window(u0 + displacement.x - x, v0 + displacement.y - y, width, height,
                                       moved.levels().data(), nullptr, nullptr);
  // Calls act(level, place in the sums) for what lies beside the hidden circle.
  const auto for_uncovered = [&](const auto& act) {
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i)
        if (!in_circle(hidden, u0 + i + displacement.x, v0 + j + displacement.y))
          act(moved.at(i, j),
              static_cast<std::size_t>(v0 + j - region_.y) * region_.width + (u0 + i - region_.x));
  };
  const std::span<float> sums = away_.sum.levels(), squares = away_.squares.levels(),
                         counts = away_.count.levels();
  double here = 0, before = 0;
  for_uncovered([&](float level, std::size_t at) {
    if (!(counts[at] > 0)) return;
    here += static_cast<double>(level);
    before += static_cast<double>(sums[at] / counts[at]);
  });
  const auto light = static_cast<float>(here > 0 && before > 0 ? before / here : 1);
  for_uncovered([&](float seen, std::size_t at) {
    const float level = light * seen;
    sums[at] += level;
    squares[at] += level * level;
    counts[at] += 1;
  });
}

/// Mean, texture and unrest are those of the places uncovered often enough.
void GroundPicture::finish(double noise_variance) {
  std::vector<double> variances;
  double sum = 0, square = 0;
  const std::span<const float> sums = away_.sum.levels();
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double n = away_.count.levels()[i];
    if (n < kFramesNeeded) continue;
    const double mean = sums[i] / n;
    variances.push_back((away_.squares.levels()[i] / n - mean * mean) * n / (n - 1));
    sum += mean;
    square += mean * mean - noise_variance / n;
  }
  if (!variances.empty()) {
    const auto places = static_cast<double>(variances.size());
    known_share_ = places / static_cast<double>(sums.size());
    mean_ = sum / places;
    texture_ = std::sqrt(std::max(0.0, square / places - mean_ * mean_));
    unrest_ = median(variances);
  }
  form(noise_variance);
}

/// The picture and its variance from the sums.
void GroundPicture::form(double noise_variance) {
  const auto least = static_cast<float>(noise_variance), unseen = static_cast<float>(texture_ * texture_);
  Picture level(region_.width, region_.height),
      in_time(region_.width, region_.height, static_cast<float>(std::max(noise_variance, unrest_)));
  const auto both = [&](Picture PlaceSums::*of, std::size_t i) {
    return (away_.*of).levels()[i] + (beside_.*of).levels()[i];
  };
  for (std::size_t i = 0; i < level.levels().size(); ++i) {
    const float n = both(&PlaceSums::count, i);
    if (!(n > 0)) continue;
    const float mean = both(&PlaceSums::sum, i) / n, square = both(&PlaceSums::squares, i) / n;
    level.levels()[i] = mean - static_cast<float>(mean_);
    // What is seen through little of the share scatters by more, and weighs less: by the number of frames.
    const float frames = away_.count.levels()[i] + frames_beside_.levels()[i];
    if (frames >= kFramesNeeded)
      in_time.levels()[i] = std::max(least, (square - mean * mean) * n / (frames - 1));
  }
  // Before it is seen, a place is of mean level and uncertain by the texture.
  const Picture around = box_mean(in_time);
  for (std::size_t i = 0; i < level.levels().size(); ++i) {
    const float once = std::max(around.levels()[i], in_time.levels()[i]),
                known = both(&PlaceSums::count, i) * unseen;
    level.levels()[i] *= known / (known + once);
    variance_.levels()[i] = unseen * once / (known + once);
  }
  spline_ = QuinticSpline(level);
}

namespace {

/// A row of a window's places beside the part.
struct RowBeside {
  const float *seen, *shown, *through;  ///< I, F and alpha
  float u, v;                           ///< of the first place on the part's grid
  float gain, slope_x, slope_y, under;  ///< a, a s, b
  float mean, hidden_square;
  int count;
};

TRIBOTRACK_CLONES
void see_row(const RowBeside& row, float* sum, float* squares, float* count, float* frames) {
  const RowBeside w = row;  // what the loop writes does not change these
  const float v_square = w.v * w.v;
#pragma GCC ivdep
  for (int i = 0; i < w.count; ++i) {
    const float u = w.u + static_cast<float>(i);
    const float shine = w.gain + w.slope_x * u + w.slope_y * w.v;
    const float through = w.through[i] > kLeastShare ? w.through[i] : kLeastShare;
    const float ground = (w.seen[i] - shine * (w.shown[i] - w.mean * through)) / (w.under * through);
    const float shows = w.through[i] < kLeastShare ? 0.0F : 1.0F;
    const float ok = u * u + v_square > w.hidden_square ? 0.0F : shows;
    const float weight = ok * through * through;
    sum[i] += weight * ground;
    squares[i] += weight * ground * ground;
    count[i] += weight;
    frames[i] += ok;
  }
}

}  // namespace

/// By bands of rows, each of which sees all windows.
void GroundPicture::see_beside(WindowSpan windows, const PartPictures& part, double hidden,
                               double noise_variance, int threads) {
  constexpr int kBand = 32;
  beside_ = PlaceSums(region_);
  frames_beside_ = Picture(region_.width, region_.height);
  const QuinticSpline level(part.level), share(part.share);
  const auto bands = static_cast<std::size_t>((region_.height + kBand - 1) / kBand);
  parallel_for(bands, threads, [&](std::size_t band, std::size_t) {
    const Rect rows{region_.x, region_.y + static_cast<int>(band) * kBand, region_.width,
                    std::min(kBand, region_.height - static_cast<int>(band) * kBand)};
    for (const KeptWindow* window : windows) see_beside(*window, part.half, level, share, hidden, rows);
  });
  form(noise_variance);
}

/// What a window shows of these rows of the region.
void GroundPicture::see_beside(const KeptWindow& w, int part_half, const QuinticSpline& level,
                               const QuinticSpline& share, double hidden, const Rect& rows) {
  thread_local std::vector<float> seen, shown, through;
  const LayeredState& s = w.state;
  const int half = part_half - 1;
  // Places of the ground about the part that lie in the window.
  const double x = s.centre.x - s.ground.x, y = s.centre.y - s.ground.y;
  const Rect places = common({static_cast<int>(std::lround(x)) - half,
                              static_cast<int>(std::lround(y)) - half, 2 * half + 1, 2 * half + 1},
                             common(rows, {static_cast<int>(std::ceil(w.x - s.ground.x)),
                                           static_cast<int>(std::ceil(w.y - s.ground.y)),
                                           w.picture.width() - 1, w.picture.height() - 1}));
  if (places.width <= 0 || places.height <= 0) return;
  const auto width = static_cast<std::size_t>(places.width);
  for (auto* of : {&seen, &shown, &through}) of->resize(width * static_cast<std::size_t>(places.height));
  const double u0 = places.x - x, v0 = places.y - y;  // on the part's grid
  w.spline.sample_window(places.x + s.ground.x - w.x, places.y + s.ground.y - w.y, places.width,
                         places.height, seen.data(), nullptr, nullptr);
  level.sample_window(u0 + part_half, v0 + part_half, places.width, places.height, shown.data(), nullptr,
                      nullptr);
  share.sample_window(u0 + part_half, v0 + part_half, places.width, places.height, through.data(), nullptr,
                      nullptr);
  for (int j = 0; j < places.height; ++j) {
    const std::size_t here = static_cast<std::size_t>(j) * width;
    const auto at =
        static_cast<std::size_t>(places.y + j - region_.y) * static_cast<std::size_t>(region_.width) +
        static_cast<std::size_t>(places.x - region_.x);
    see_row({seen.data() + here, shown.data() + here, through.data() + here, static_cast<float>(u0),
             static_cast<float>(v0 + j), static_cast<float>(s.gain), static_cast<float>(s.gain * s.slope_x),
             static_cast<float>(s.gain * s.slope_y), static_cast<float>(s.ground_gain),
             static_cast<float>(mean_), static_cast<float>(hidden * hidden), places.width},
            beside_.sum.levels().data() + at, beside_.squares.levels().data() + at,
            beside_.count.levels().data() + at, frames_beside_.levels().data() + at);
  }
}

void GroundPicture::sample(double x0, double y0, int width, int height, float* level, float* variance,
                           float* slope_x, float* slope_y) const {
  const double left = x0 - region_.x, top = y0 - region_.y;
  const int x = static_cast<int>(std::lround(left)), y = static_cast<int>(std::lround(top));
  const bool inside =
      x >= -4 && y >= -4 && x + width <= region_.width + 4 && y + height <= region_.height + 4;
  if (inside) spline_.sample_window(left, top, width, height, level, slope_x, slope_y);
  for (int j = 0; j < height; ++j) {
    const auto row = variance_.row(std::clamp(y + j, 0, region_.height - 1));
    for (int i = 0; i < width; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(j) * width + i;
      variance[at] = row[static_cast<std::size_t>(std::clamp(x + i, 0, region_.width - 1))];
      if (inside) continue;
      const SplineSample s = spline_.sample(left + i, top + j);
      level[at] = static_cast<float>(s.value);
      slope_x[at] = static_cast<float>(s.slope_x);
      slope_y[at] = static_cast<float>(s.slope_y);
    }
  }
}

}  // namespace tribotrack::vision
