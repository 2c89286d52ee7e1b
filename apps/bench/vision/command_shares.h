// Which share of a whole command each stage takes, as `tribotrack track --explain` tells it.
#pragma once

#include <string>

namespace tribotrack::bench {

/// Of the wall time from start to end with one thread. `track --explain` prints the times behind them.
struct CommandShares {
  double starting = 0;   ///< loading libraries, the command line
  double hashing = 0;    ///< of the input, for the meta file
  double reading = 0;    ///< and decoding
  double looking = 0;    ///< noise and bad pixels of the camera, finding the disc, its template
  double part = 0;       ///< first pass: registering the part
  double mark = 0;       ///< first pass: registering mark or ground
  double learning = 0;   ///< the layers' pictures
  double measuring = 0;  ///< in the layers' pictures
  double radius = 0;     ///< of the disc, in the first pass
  double rotation = 0;   ///< by rings, where the template does not tell it; reading not included
  double audit = 0;
  double writing = 0;  ///< table and meta file
  double rest = 0;     ///< what no stage tells of, the process's end
};

/// The shares told by the table of times that `track --explain` prints, of a command that took `wall` s.
CommandShares shares_from(const std::string& explanation, double wall);

}  // namespace tribotrack::bench
