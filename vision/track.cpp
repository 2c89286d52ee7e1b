#include "vision/track.h"

namespace tribotrack::vision {

const char* to_string(TrackStatus status) {
  switch (status) {
    case TrackStatus::ok:
      return "ok";
    case TrackStatus::edge:
      return "edge";
    case TrackStatus::lost:
      break;
  }
  return "lost";
}

}  // namespace tribotrack::vision
