#include "vision/layers/model/ground.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

namespace tribotrack::vision {
namespace {

constexpr int kFramesNeeded = 3;          ///< fewer do not make a picture worth the name
constexpr std::size_t kThinned = 5;       ///< places of which one is asked for the usual level
constexpr double kStandsOut = 10;         ///< times the texture's spread
constexpr int kStandingEdge = 3;          ///< px about it that are half covered
constexpr double kMostStandingOut = 0.1;  ///< of the ground: more is the ground
constexpr int kFillRings = 8;             ///< px of smooth continuation into what was never seen
/// A texture that is not known pulls alike in all pixels of a patch: where it is not known it counts as so
/// many times its variance in each, or the disc is drawn to what its leading rim would see on even ground.
constexpr double kAlike = 10;

/// Unknown pixels next to known ones take their mean; repeated, so that the spline does not ring.
void continue_smoothly(Picture& levels, Picture known) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < levels.levels().size(); ++i) {
    sum += known.levels()[i] * levels.levels()[i];
    count += known.levels()[i];
  }
  const auto mean = static_cast<float>(count > 0 ? sum / count : 0);
  for (std::size_t i = 0; i < levels.levels().size(); ++i)
    if (known.levels()[i] == 0) levels.levels()[i] = mean;
  for (int ring = 0; ring < kFillRings; ++ring) {
    const Picture before = known;
    for (int y = 0; y < levels.height(); ++y)
      for (int x = 0; x < levels.width(); ++x) {
        if (before.at(x, y) > 0) continue;
        float near = 0;
        float seen = 0;
        for (int v = std::max(0, y - 1); v <= std::min(levels.height() - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(levels.width() - 1, x + 1); ++u) {
            near += before.at(u, v) * levels.at(u, v);
            seen += before.at(u, v);
          }
        if (seen == 0) continue;
        levels.at(x, y) = near / seen;
        known.at(x, y) = 1;
      }
  }
}

}  // namespace

GroundPicture::GroundPicture(const Rect& region)
    : region_(region),
      sum_(region.width, region.height),
      squares_(region.width, region.height),
      count_(region.width, region.height),
      through_(region.width, region.height),
      squares_through_(region.width, region.height),
      known_(region.width, region.height),
      variance_(region.width, region.height) {}

void GroundPicture::hold_to(Picture usual, double tolerance) {
  usual_ = std::move(usual);
  tolerance_ = static_cast<float>(tolerance);
  held_ = looked_at_ = 0;
  for (Picture* p : {&sum_, &squares_, &count_}) std::ranges::fill(p->levels(), 0.0F);
}

template <class Uncovered>
void GroundPicture::add_held(const Uncovered& uncovered) {
  constexpr int kStep = 7;
  std::vector<float> ratios;
  uncovered([&](const float* row, int from, int to, std::size_t at) {
    for (int i = from; i < to; i += kStep)
      if (row[i] > 0) ratios.push_back(usual_.levels()[at + static_cast<std::size_t>(i)] / row[i]);
  });
  if (ratios.empty()) return;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const float light = *middle;
  uncovered([&](const float* row, int from, int to, std::size_t at) {
    for (int i = from; i < to; ++i) {
      const std::size_t k = at + static_cast<std::size_t>(i);
      const float level = light * row[i];
      ++looked_at_;
      if (std::abs(level - usual_.levels()[k]) > tolerance_) continue;
      ++held_;
      sum_.levels()[k] += level;
      squares_.levels()[k] += level * level;
      count_.levels()[k] += 1;
    }
  });
}

void GroundPicture::add(const Picture& picture, int x, int y, const Point& displacement,
                        const Circle& hidden) {
  // Places u of the platform with u + p inside the window.
  const int u0 = std::max(region_.x, static_cast<int>(std::ceil(x - displacement.x)));
  const int v0 = std::max(region_.y, static_cast<int>(std::ceil(y - displacement.y)));
  const int u1 = std::min(region_.x + region_.width - 1,
                          static_cast<int>(std::floor(x + picture.width() - 1 - displacement.x)));
  const int v1 = std::min(region_.y + region_.height - 1,
                          static_cast<int>(std::floor(y + picture.height() - 1 - displacement.y)));
  if (u1 < u0 || v1 < v0) return;
  const int width = u1 - u0 + 1;
  const int height = v1 - v0 + 1;
  Picture moved(width, height);
  QuinticSpline(picture).sample_window(u0 + displacement.x - x, v0 + displacement.y - y, width, height,
                                       moved.levels().data(), nullptr, nullptr);
  // Spans of each row beside the hidden circle: act(row of `moved`, first column, last + 1, place in sums).
  const auto uncovered = [&](const auto& act) {
    for (int j = 0; j < height; ++j) {
      const double dy = v0 + j + displacement.y - hidden.y;
      const double square = hidden.radius * hidden.radius - dy * dy;
      const auto at = static_cast<std::size_t>(v0 + j - region_.y) * region_.width + (u0 - region_.x);
      const float* row = moved.row(j).data();
      if (square < 0) {
        act(row, 0, width, at);
        continue;
      }
      const double middle = hidden.x - displacement.x - u0, half = std::sqrt(square);
      act(row, 0, std::clamp(static_cast<int>(std::ceil(middle - half)), 0, width), at);
      act(row, std::clamp(static_cast<int>(std::floor(middle + half)) + 1, 0, width), width, at);
    }
  };
  if (!usual_.empty()) return add_held(uncovered);
  float* sums = sum_.levels().data();
  float* squares = squares_.levels().data();
  float* counts = count_.levels().data();
  double here = 0;
  double before = 0;
  uncovered([&](const float* row, int from, int to, std::size_t at) {
    // Eight sums beside each other, which the compiler takes at once.
    float level[8] = {}, mean[8] = {};
    int i = from;
    for (; i + 8 <= to; i += 8)
      for (int k = 0; k < 8; ++k) {
        const float n = counts[at + i + k];
        level[k] += n > 0 ? row[i + k] : 0.0F;
        mean[k] += sums[at + i + k] / std::max(n, 1.0F);
      }
    for (; i < to; ++i) {
      const float n = counts[at + i];
      level[0] += n > 0 ? row[i] : 0.0F;
      mean[0] += sums[at + i] / std::max(n, 1.0F);
    }
    here += std::accumulate(std::begin(level), std::end(level), 0.0F);
    before += std::accumulate(std::begin(mean), std::end(mean), 0.0F);
  });
  const auto light = static_cast<float>(here > 0 && before > 0 ? before / here : 1);
  uncovered([&](const float* row, int from, int to, std::size_t at) {
    for (int i = from; i < to; ++i) {
      const float level = light * row[i];
      sums[at + i] += level;
      squares[at + i] += level * level;
      counts[at + i] += 1;
    }
  });
}

void GroundPicture::forget_rim() {
  std::fill(through_.levels().begin(), through_.levels().end(), 0.0F);
  std::fill(squares_through_.levels().begin(), squares_through_.levels().end(), 0.0F);
}

void GroundPicture::set_light(const StaticIllumination& light, std::span<const Point> displacements) {
  light_gain_ = Picture(region_.width, region_.height);
  light_offset_ = light_hidden_ = light_gain_;
  const Rect& from = light.region();
  const auto share = 1 / static_cast<float>(displacements.size());
  for (const Point& p : displacements) {
    const double left = region_.x + p.x - from.x, top = region_.y + p.y - from.y;
    const int ix = static_cast<int>(std::floor(left)), iy = static_cast<int>(std::floor(top));
    const auto fx = static_cast<float>(left - ix), fy = static_cast<float>(top - iy);
    for (int j = 0; j < region_.height; ++j)
      for (int i = 0; i < region_.width; ++i) {
        const int x0 = std::clamp(ix + i, 0, from.width - 1), x1 = std::clamp(ix + i + 1, 0, from.width - 1);
        const int y0 = std::clamp(iy + j, 0, from.height - 1),
                  y1 = std::clamp(iy + j + 1, 0, from.height - 1);
        const auto at = [&](const Picture& q) {
          return share * ((1 - fy) * ((1 - fx) * q.at(x0, y0) + fx * q.at(x1, y0)) +
                          fy * ((1 - fx) * q.at(x0, y1) + fx * q.at(x1, y1)));
        };
        light_gain_.at(i, j) += at(light.gain());
        light_offset_.at(i, j) += at(light.offset());
        light_hidden_.at(i, j) += at(light.hidden());
      }
  }
}

void GroundPicture::leave_out_what_stands_out(double noise_variance) {
  std::vector<float> levels, deviations;
  const auto sums = sum_.levels(), counts = count_.levels();
  const auto median = [](std::vector<float>& from) {
    const auto middle = from.begin() + static_cast<std::ptrdiff_t>(from.size() / 2);
    std::nth_element(from.begin(), middle, from.end());
    return *middle;
  };
  for (std::size_t i = 0; i < sums.size(); i += kThinned)
    if (counts[i] >= kFramesNeeded) levels.push_back(sums[i] / counts[i]);
  if (levels.empty()) return;
  const float usual = median(levels);
  for (const float level : levels) deviations.push_back(std::abs(level - usual));
  const double spread = std::max(1.4826 * static_cast<double>(median(deviations)), std::sqrt(noise_variance));
  const auto far = static_cast<float>(kStandsOut * spread);
  Picture out(region_.width, region_.height);
  double places = 0, all = 0;
  for (int y = 0; y < region_.height; ++y)
    for (int x = 0; x < region_.width; ++x) {
      if (!(count_.at(x, y) >= kFramesNeeded)) continue;
      ++all;
      if (std::abs(sum_.at(x, y) / count_.at(x, y) - usual) <= far) continue;
      ++places;
      for (int v = std::max(0, y - kStandingEdge); v <= std::min(region_.height - 1, y + kStandingEdge); ++v)
        for (int u = std::max(0, x - kStandingEdge); u <= std::min(region_.width - 1, x + kStandingEdge); ++u)
          out.at(u, v) = 1;
    }
  if (places > 0 && places < kMostStandingOut * all) standing_out_ = std::move(out);
}

/// Mean, texture and unrest of the places uncovered often enough.
void GroundPicture::summarise(const Picture& enough, const Picture& level, double noise_variance) {
  std::vector<float> variances;
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < sum_.levels().size(); ++i) {
    if (enough.levels()[i] == 0) continue;
    const double n = count_.levels()[i];
    const double mean = sum_.levels()[i] / n, shown = level.levels()[i];
    variances.push_back(static_cast<float>((squares_.levels()[i] / n - mean * mean) * n / (n - 1)));
    sum += shown;
    square += shown * shown;
  }
  if (variances.empty()) return;
  const auto places = static_cast<double>(variances.size());
  mean_ = sum / places;
  texture_ = std::sqrt(std::max(0.0, square / places - mean_ * mean_ - noise_variance / kFramesNeeded));
  const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
  std::nth_element(variances.begin(), middle, variances.end());
  unrest_ = *middle;
}

/// The least of `seen` and the mean of `own` over 3 x 3 places: down the columns, then across.
void GroundPicture::lean_on_neighbours(const Picture& seen, const Picture& own) {
  const auto width = static_cast<std::size_t>(region_.width);
  // A column more at either end, so that all places have two neighbours.
  std::vector<float> least(width + 2), sum(width + 2), count(width + 2);
  for (int y = 0; y < region_.height; ++y) {
    const int top = std::max(0, y - 1), bottom = std::min(region_.height - 1, y + 1);
    std::ranges::fill(least, 1.0F);
    std::ranges::fill(sum, 0.0F);
    std::ranges::fill(count, 0.0F);
    for (int v = top; v <= bottom; ++v) {
      const float* s = seen.row(v).data();
      const float* o = own.row(v).data();
      for (std::size_t x = 0; x < width; ++x) {
        least[x + 1] = std::min(least[x + 1], s[x]);
        sum[x + 1] += o[x];
        count[x + 1] += 1;
      }
    }
    float* known = known_.row(y).data();
    float* variance = variance_.row(y).data();
    for (std::size_t x = 0; x < width; ++x) {
      known[x] = std::min(std::min(least[x], least[x + 1]), least[x + 2]);
      variance[x] = (sum[x] + sum[x + 1] + sum[x + 2]) / (count[x] + count[x + 1] + count[x + 2]);
    }
  }
}

void GroundPicture::finish(double noise_variance) {
  Picture enough(region_.width, region_.height), level(region_.width, region_.height);
  for (std::size_t i = 0; i < sum_.levels().size(); ++i) {
    // What stands in the picture stands before the places that move through it.
    const bool known = count_.levels()[i] >= kFramesNeeded && !not_ground(i);
    enough.levels()[i] = known ? 1.0F : 0.0F;
    level.levels()[i] = known ? sum_.levels()[i] / count_.levels()[i] : 0.0F;
    if (known && !light_gain_.empty())
      level.levels()[i] = (level.levels()[i] - light_offset_.levels()[i]) / light_gain_.levels()[i];
  }
  summarise(enough, level, noise_variance);
  continue_smoothly(level, enough);
  unseen_variance_ = std::max(kAlike * texture_ * texture_, 0.01 * noise_variance);
  const auto prior = static_cast<float>(noise_variance / unseen_variance_);
  const auto noise = static_cast<float>(noise_variance);
  Picture own(region_.width, region_.height), seen_enough(region_.width, region_.height);
  for (std::size_t i = 0; i < level.levels().size(); ++i) {
    const float counted = not_ground(i) ? 0 : count_.levels()[i];
    const float seen = counted + squares_through_.levels()[i];
    // A place uncovered often enough owes nothing to the prior.
    const float held = enough.levels()[i] > 0 ? 0 : prior;
    const bool as_seen = light_gain_.empty() && counted > 0;
    const float sum = as_seen ? sum_.levels()[i] : counted * level.levels()[i];
    level.levels()[i] = (sum + through_.levels()[i] + held * level.levels()[i]) / (seen + held);
    own.levels()[i] = noise / (seen + prior);
    seen_enough.levels()[i] = seen >= kFramesNeeded ? 1.0F : 0.0F;
  }
  // The interpolation leans on the neighbours.
  lean_on_neighbours(seen_enough, own);
  spline_ = QuinticSpline(level);
}

void GroundPicture::sample(double x0, double y0, int width, int height, float* value, float* known,
                           float* slope_x, float* slope_y) const {
  const double left = x0 - region_.x;
  const double top = y0 - region_.y;
  const int near_x = static_cast<int>(std::lround(left));
  const int near_y = static_cast<int>(std::lround(top));
  const bool inside = near_x >= -4 && near_y >= -4 && near_x + width <= region_.width + 4 &&
                      near_y + height <= region_.height + 4;
  if (inside) {
    spline_.sample_window(left, top, width, height, value, slope_x, slope_y);
  } else {
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i) {
        const SplineSample at = spline_.sample(left + i, top + j);
        value[j * width + i] = static_cast<float>(at.value);
        if (slope_x) slope_x[j * width + i] = static_cast<float>(at.slope_x);
        if (slope_y) slope_y[j * width + i] = static_cast<float>(at.slope_y);
      }
  }
  const int first = std::clamp(-near_x, 0, width), last = std::clamp(region_.width - near_x, first, width);
  std::fill_n(known, static_cast<std::size_t>(width) * height, 0.0F);
  for (int j = std::max(0, -near_y); j < std::min(height, region_.height - near_y); ++j)
    std::copy_n(known_.row(near_y + j).begin() + near_x + first, last - first,
                known + static_cast<std::ptrdiff_t>(j) * width + first);
}

void GroundPicture::sample_tiles(double x0, double y0, const std::vector<TilePlace>& tiles,
                                 std::vector<const float*>& corners, TileArrays& arrays,
                                 std::vector<float>& known) const {
  const double left = x0 - region_.x, top = y0 - region_.y;
  const int ix = static_cast<int>(std::floor(left)), iy = static_cast<int>(std::floor(top));
  const int near_x = static_cast<int>(std::lround(left)), near_y = static_cast<int>(std::lround(top));
  std::fill(known.begin(), known.end(), 0.0F);
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    // Far outside, where nothing is known, the spline is that of the border.
    corners[t] = spline_.coefficient(std::clamp(ix + tiles[t].x, -8, region_.width),
                                     std::clamp(iy + tiles[t].y, -8, region_.height));
    const int x = near_x + tiles[t].x, y = near_y + tiles[t].y;
    const int first = std::clamp(-x, 0, kTile), last = std::clamp(region_.width - x, first, kTile);
    for (int j = std::max(0, -y); j < std::min(kTile, region_.height - y); ++j)
      std::copy_n(known_.row(y + j).begin() + x + first, last - first,
                  known.begin() + static_cast<std::ptrdiff_t>(t * kTilePixels) + j * kTile + first);
  }
  tile_kernels().sample(corners, spline_.stride(), spline_taps(left - ix, top - iy), 0, true, arrays);
}

}  // namespace tribotrack::vision
