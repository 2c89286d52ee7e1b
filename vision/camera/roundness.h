// Is a disc seen as one? Pixels that are not square and a camera that looks from the side make it an ellipse.
#pragma once

#include <optional>
#include <string>

#include "vision/picture.h"

namespace tribotrack::vision {

/// A sentence where the steepest edges around the disc lie at radii that go with cos 2 theta by more than 3 %
/// (axes that differ by 6 %) and half a pixel, beyond their scatter; nothing where they do not, or lie too
/// near to the picture's rim.
std::optional<std::string> roundness_warning(const Picture& picture, const Circle& disc);

}  // namespace tribotrack::vision
