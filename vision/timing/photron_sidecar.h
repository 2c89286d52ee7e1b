// The text files Photron cameras leave beside their recordings.
#pragma once

#include <filesystem>
#include <optional>

#include "vision/time_base.h"

namespace tribotrack::vision {

/// The .cih or .cihx beside `recording`, with the same name, if there is one that can be read.
std::optional<std::filesystem::path> photron_sidecar(const std::filesystem::path& recording);

/// The capture rate in the .cih ("Record Rate(fps) : 7000") or .cihx (<recordRate>7000</recordRate>) beside
/// `recording`. Nothing where there is none; a rejected candidate where it states no
/// rate.
std::optional<TimeBaseCandidate> photron_sidecar_rate(const std::filesystem::path& recording);

}  // namespace tribotrack::vision
