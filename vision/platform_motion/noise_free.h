// A mean picture freed of the noise that is left in it.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

/// What is broad (light) by a mean over kBroad px; the rest by Wiener's filter: every spatial frequency is
/// kept by the share of its power that is not the noise's, the power a mean over neighbouring frequencies. A
/// brushed ground lies on few frequencies, so most of the noise goes; slopes of what is left are slopes of
/// the ground. What is not `known` (0) is filled from what is, again and again (Papoulis, IEEE Trans.
/// Circuits Syst. 22, 1975): a step there would look like a texture. `noise_variance` of a pixel, grey
/// levels^2.
/// `before`: a like picture, to fill from at first.
Picture noise_free(const Picture& picture, const Picture& known, double noise_variance,
                   const Picture* before = nullptr);

}  // namespace tribotrack::vision
