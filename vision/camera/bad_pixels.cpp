#include "vision/camera/bad_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/kernels/median.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr double kNoises = 8;  ///< 1e6 pixels of Gaussian noise never stand out so far
constexpr float kSpreads = 2;

/// By how much the levels of a row exceed all their four neighbours but one (negative: fall short of all but
/// one), its two ends left out. Whether any is further off than `least`.
TRIBOTRACK_CLONES bool stand_out(const float* above, const float* here, const float* below, std::size_t width,
                                 float least, float* steps) {
  const auto low = [](float a, float b) { return a < b ? a : b; };
  const auto high = [](float a, float b) { return a < b ? b : a; };
  int any = 0;
  for (std::size_t x = 1; x + 1 < width; ++x) {
    const float a = above[x], b = below[x], c = here[x - 1], d = here[x + 1];
    const float second_highest = high(low(high(a, b), high(c, d)), high(low(a, b), low(c, d)));
    const float second_lowest = low(high(low(a, b), low(c, d)), low(high(a, b), high(c, d)));
    const float step = high(here[x] - second_highest, 0.0F) + low(here[x] - second_lowest, 0.0F);
    steps[x] = step;
    any |= (step > least) | (step < -least);
  }
  return any != 0;
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

/// A first look along the rows of one picture.
std::vector<Pixel> candidates(const Picture& picture, float least) {
  std::vector<Pixel> found;
  const auto width = static_cast<std::size_t>(picture.width());
  std::vector<float> steps(width);
  for (int y = 1; y + 1 < picture.height(); ++y) {
    if (!stand_out(picture.row(y - 1).data(), picture.row(y).data(), picture.row(y + 1).data(), width, least,
                   steps.data()))
      continue;
    for (std::size_t x = 1; x + 1 < width; ++x)
      if (std::abs(steps[x]) > least) found.push_back({static_cast<int>(x), y});
  }
  return found;
}

bool is_before(const Pixel& a, const Pixel& b) {
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

BadPixelSearch::BadPixelSearch(const Picture& picture, double noise_variance)
    : least_(static_cast<float>(kNoises * std::sqrt(noise_variance))) {
  if (picture.width() < 3 || picture.height() < 3) return;
  for (const Pixel& p : candidates(picture, least_))
    if (const int side = side_of(picture, p, least_); side != 0) {
      found_.push_back(p);
      sides_.push_back(side);
    }
}

void BadPixelSearch::look(const Picture& picture) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < found_.size(); ++k) {
    if (side_of(picture, found_[k], least_) != sides_[k]) continue;
    found_[kept] = found_[k];
    sides_[kept++] = sides_[k];
  }
  found_.resize(kept);
  sides_.resize(kept);
  ++others_;
}

std::vector<Pixel> BadPixelSearch::found() const {
  return others_ > 0 ? found_ : std::vector<Pixel>();
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
    picture.at(p->x - window.x, p->y - window.y) = median(levels);
  }
}

}  // namespace tribotrack::vision
