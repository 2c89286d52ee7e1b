#include "vision/io/level_conversion.h"

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {

TRIBOTRACK_CLONES void copy_levels(const std::uint8_t* stored, std::span<float> levels) {
  const std::size_t n = levels.size();
  float* to = levels.data();
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<float>(stored[i]);
}

}  // namespace tribotrack::vision
