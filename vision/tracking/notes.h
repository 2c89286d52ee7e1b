// What a track's summary reports: counts, the plan's stages, warnings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "vision/tracker.h"

namespace tribotrack::vision {

/// Frames by their status, and the quality gate.
FrameCounts count(const Track& track, double max_lost_share);

/// What the ground shows; `learnt_from` frames, 0: it is not followed.
PlanStage ground_marker_stage(const std::string& ground, int learnt_from);
std::string no_rim_warning(const char* what, const Circle& given);
/// A disc that was found, not given, and never moves may be a mark on the table.
std::optional<std::string> stillness_warning(const Track& track, const Circle& disc);
/// One that goes where the ground or the mark goes may be fixed to it.
std::optional<std::string> carried_warning(const Track& track, const Circle& disc);

/// What is taken for a part that has left and come back, from point number `begin` until it is lost again,
/// must move, or else it is a mark on the ground: then those points become lost, and it is said.
std::optional<std::string> without_a_mark(Track& track, std::size_t begin);

/// Appends all of them, or the one that there may be.
template <class Item, class Items>
void add(std::vector<Item>& to, const Items& items) {
  if constexpr (std::is_same_v<Items, std::optional<Item>>) {
    if (items) to.push_back(*items);
  } else {
    to.insert(to.end(), items.begin(), items.end());
  }
}

}  // namespace tribotrack::vision
