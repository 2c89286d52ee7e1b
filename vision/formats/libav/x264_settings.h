// The settings that x264 writes into its streams, as its encoder takes them.
#pragma once

#include <string>

namespace tribotrack::vision {

/// "name=value:name=value" for libx264's option x264-params, from the text "x264 - core 164 ... options:
/// cabac=1 ref=3 ..." (x264: common/base.c, x264_param2string and x264_param_parse, whose names differ).
/// What does not change the pictures (threads), is left out, and a mean
/// rate over a whole file becomes a constant quantiser's: the nearest there is in a short one.
std::string x264_parameters(const std::string& settings);

/// Largest number of B frames in a row.
int b_frames_of(const std::string& settings);

}  // namespace tribotrack::vision
