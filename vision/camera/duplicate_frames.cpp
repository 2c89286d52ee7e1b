#include "vision/duplicate_frames.h"

#include <algorithm>
#include <utility>

namespace tribotrack::vision {
namespace {

constexpr std::int64_t kStill = 4;      ///< equal pictures in a row that are no mere repeats
constexpr std::size_t kMostListed = 5;  ///< image numbers written out
constexpr int kRows = 32;               ///< compared first; mostly they decide

bool equal(const Picture& a, const Picture& b) {
  return std::ranges::equal(a.levels(), b.levels());
}

}  // namespace

RepeatedFrames find_repeated_frames(FrameSource& source, std::int64_t max_frames) {
  RepeatedFrames found;
  const std::int64_t count = std::min(max_frames, source.info().frame_count);
  const Rect all = source.bounds();
  const Rect band{0, std::max(0, (all.height - kRows) / 2), all.width, std::min(kRows, all.height)};
  Picture before, now;
  Picture whole_before;
  std::int64_t whole_index = -1;
  std::int64_t run = 0;  // equal pictures up to here
  const auto close_run = [&](std::int64_t last) {
    if (run + 1 >= kStill) {
      found.still.emplace_back(last - run, last);
    } else {
      for (std::int64_t k = last - run + 1; k <= last; ++k) found.repeated.push_back(k);
    }
    run = 0;
  };
  for (std::int64_t k = 0; k < count; ++k) {
    source.read(k, band, now);
    bool same = k > 0 && equal(before, now);
    if (same) {
      // The bands are equal: compare the whole pictures.
      Picture whole;
      if (whole_index != k - 1) source.read(k - 1, all, whole_before);
      source.read(k, all, whole);
      same = equal(whole_before, whole);
      whole_before = std::move(whole);
      whole_index = k;
    }
    if (same)
      ++run;
    else if (k > 0)
      close_run(k - 1);
    std::swap(before, now);
  }
  if (count > 0) close_run(count - 1);
  found.looked_at = count;
  return found;
}

std::vector<std::string> findings(const RepeatedFrames& repeats, const FrameSource& source) {
  std::vector<std::string> out;
  if (!repeats.repeated.empty()) {
    std::string text = std::to_string(repeats.repeated.size()) +
                       (repeats.repeated.size() == 1 ? " picture repeats" : " pictures repeat") +
                       " the one before, level for level: image";
    for (std::size_t k = 0; k < std::min(kMostListed, repeats.repeated.size()); ++k)
      text += (k == 0 ? " " : ", ") + std::to_string(source.number(repeats.repeated[k]));
    if (repeats.repeated.size() > kMostListed) text += " and others";
    if (3 * repeats.repeated.size() > static_cast<std::size_t>(repeats.looked_at))
      text += "; the camera recorded at a lower rate than the pictures are stored at";
    out.push_back(text + "; a repeated picture shows the scene at an earlier time than its own");
  }
  for (std::size_t k = 0; k < std::min(kMostListed, repeats.still.size()); ++k)
    out.push_back(
        "images " + std::to_string(source.number(repeats.still[k].first)) + " to " +
        std::to_string(source.number(repeats.still[k].second)) +
        " are one picture: the recording was paused, or nothing moved and the coding dropped the noise");
  return out;
}

}  // namespace tribotrack::vision
