// The text files Photron cameras leave beside their recordings.
#pragma once

#include <filesystem>
#include <optional>

#include "vision/time_base.h"

namespace tribotrack::vision {

/// The capture rate in the .cih ("Record Rate(fps) : 7000") or .cihx (<recordRate>7000</recordRate>) beside
/// `recording`, with the same name. Nothing where there is none; a rejected candidate where it states no
/// rate.
std::optional<TimeBaseCandidate> photron_sidecar_rate(const std::filesystem::path& recording);

}  // namespace tribotrack::vision
