// The libraries behind vision/, for whoever asks what a program stands on.
#pragma once

#include <string>

namespace tribotrack::vision {

/// "OpenCV 4.6.0, libavformat 59.27.100, libavcodec 59.37.100", as the program was compiled.
std::string libraries();

}  // namespace tribotrack::vision
