// The frames of a recording that a survey looks for lamps and discs in.
#pragma once

#include <cstdint>
#include <vector>

namespace tribotrack::vision {

/// Of the first `span` frames at most `most`, in rising order. Their distances do not repeat (multiples of
/// the golden section), so that no lamp's frequency is missed for being in step with them.
std::vector<std::int64_t> spread_frames(std::int64_t span, int most);

}  // namespace tribotrack::vision
