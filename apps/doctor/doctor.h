// Is everything there that the program needs, and how much of the machine may it use?
#pragma once

#include <string>
#include <vector>

namespace tribotrack::apps {

struct Finding {
  std::string what;    ///< "video files"
  std::string state;   ///< "libavformat 59.27.100"
  std::string remedy;  ///< empty: all is well
  bool needed = true;  ///< else only a comfort is missing
};

/// `threads`: what the program would use.
std::vector<Finding> examine(int threads);

}  // namespace tribotrack::apps
