#include "vision/bad_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kNoises = 8;  ///< 1e6 pixels of Gaussian noise never stand out so far
constexpr float kSpreads = 2;

/// By how much the level exceeds all its four neighbours but one (negative: falls short of all but one).
float stands_out(float here, float a, float b, float c, float d) {
  const float second_highest =
      std::max(std::min(std::max(a, b), std::max(c, d)), std::max(std::min(a, b), std::min(c, d)));
  const float second_lowest =
      std::min(std::max(std::min(a, b), std::min(c, d)), std::min(std::max(a, b), std::max(c, d)));
  return std::max(here - second_highest, 0.0F) + std::min(here - second_lowest, 0.0F);
}

/// The eight neighbours, in order of their levels; fewer at the picture's edge.
struct Neighbours {
  std::array<float, 8> levels{};
  std::size_t count = 0;
  Neighbours(const Picture& picture, Pixel p) {
    for (int y = std::max(0, p.y - 1); y <= std::min(picture.height() - 1, p.y + 1); ++y)
      for (int x = std::max(0, p.x - 1); x <= std::min(picture.width() - 1, p.x + 1); ++x)
        if (x != p.x || y != p.y) levels[count++] = picture.at(x, y);
    std::sort(levels.begin(), levels.begin() + static_cast<std::ptrdiff_t>(count));
  }
  float low() const { return levels[1]; }
  float high() const { return levels[count - 2]; }
};

/// +1 bright, -1 dark, 0 as its neighbours.
int side_of(const Picture& picture, Pixel p, float least) {
  const Neighbours around(picture, p);
  const float here = picture.at(p.x, p.y);
  const float step = least + kSpreads * (around.high() - around.low());
  return here > around.high() + step ? 1 : here < around.low() - step ? -1 : 0;
}

/// A first look along the rows of one picture, without branches.
std::vector<Pixel> candidates(const Picture& picture, float least) {
  std::vector<Pixel> found;
  const auto width = static_cast<std::size_t>(picture.width());
  std::vector<float> step(width);
  for (int y = 1; y + 1 < picture.height(); ++y) {
    const float* above = picture.row(y - 1).data();
    const float* here = picture.row(y).data();
    const float* below = picture.row(y + 1).data();
    float most = 0;
    for (std::size_t x = 1; x + 1 < width; ++x) {
      step[x] = std::abs(stands_out(here[x], above[x], below[x], here[x - 1], here[x + 1]));
      most = std::max(most, step[x]);
    }
    if (most <= least) continue;
    for (std::size_t x = 1; x + 1 < width; ++x)
      if (step[x] > least) found.push_back({static_cast<int>(x), y});
  }
  return found;
}

bool is_before(const Pixel& a, const Pixel& b) {
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

std::vector<Pixel> find_bad_pixels(std::span<const Picture> pictures, double noise_variance) {
  if (pictures.size() < 2 || pictures.front().width() < 3 || pictures.front().height() < 3) return {};
  const auto least = static_cast<float>(kNoises * std::sqrt(noise_variance));
  std::vector<Pixel> found = candidates(pictures.front(), least);
  std::erase_if(found, [&](const Pixel& p) {
    const int side = side_of(pictures.front(), p, least);
    return side == 0 || !std::all_of(pictures.begin() + 1, pictures.end(),
                                     [&](const Picture& other) { return side_of(other, p, least) == side; });
  });
  return found;
}

MendedSource::MendedSource(FrameSource& source, std::vector<Pixel> bad)
    : source_(source), bad_(std::move(bad)) {
  info_ = source.info();
  std::sort(bad_.begin(), bad_.end(), is_before);
  for (const Pixel& p : bad_) {
    std::vector<Pixel>& around = healthy_.emplace_back();
    for (int reach = 1; around.empty() && reach <= 3; ++reach)
      for (int y = p.y - reach; y <= p.y + reach; ++y)
        for (int x = p.x - reach; x <= p.x + reach; ++x)
          if (bounds().contains({x, y, 1, 1}) &&
              !std::binary_search(bad_.begin(), bad_.end(), Pixel{x, y}, is_before))
            around.push_back({x, y});
  }
}

void MendedSource::read(std::int64_t index, const Rect& window, Picture& picture) {
  source_.read(index, window, picture);
  const auto first = std::lower_bound(bad_.begin(), bad_.end(), Pixel{window.x, window.y}, is_before);
  for (auto p = first; p != bad_.end() && p->y < window.y + window.height; ++p) {
    if (p->x < window.x || p->x >= window.x + window.width) continue;
    std::vector<float> levels;
    for (const Pixel& q : healthy_[static_cast<std::size_t>(p - bad_.begin())])
      if (window.contains({q.x, q.y, 1, 1})) levels.push_back(picture.at(q.x - window.x, q.y - window.y));
    if (levels.empty()) continue;
    const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
    std::nth_element(levels.begin(), middle, levels.end());
    picture.at(p->x - window.x, p->y - window.y) = *middle;
  }
}

}  // namespace tribotrack::vision
