// What `measure` makes of one track.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/files/track_file.h"
#include "apps/text/json.h"
#include "fit/measurement.h"
#include "fit/motion.h"

namespace tribotrack::apps {

/// What motion a track shows, and what to do where it is not the one that was asked for. In
/// `fit::ShownMotion` the platform's, where its mark shows that it circles; else the part's own.
struct TrackMotion {
  fit::ShownMotion shown;
  bool platform_seen = false;  ///< by a mark that circles
  std::string sentence;        ///< what it shows, without a full stop
  /// What gives friction from such a track, or what to film instead.
  std::string remedy() const;
};

/// `platform`: as its mark shows it. A mark that moves and does not circle was moved with the camera.
TrackMotion motion_of(const Track& track, const std::optional<fit::PlatformMotion>& platform);

/// Each a flag of the command line and a keyword in Python; empty: not given.
struct MeasureChoices {
  std::optional<double> omega_rad_s, epsilon_rad;
  int cycles = 20;
  std::optional<double> gravity_m_s2;  ///< of a free slide
  bool free_slide = false;             ///< else where no drive is given or seen
};

struct TrackMeasurement {
  Json json;  ///< the object `measure --json` prints
  std::vector<std::string> warnings;
  Json configuration;   ///< for the meta file
  std::string failure;  ///< what fails its quality gate; empty: nothing
};

/// What the track shows is judged first (fit/motion.h): `motion` and `motion_sentence`. Without a drive that
/// is given or seen mu1 follows where it shows an even slide, else the failure says what it shows and what to
/// do; with one, alpha and v, and the failure where the part shows another motion. `name` begins messages.
/// Throws UsageError for choices that are out of range or contradict each other, InvalidInput and
/// fit::DataError where the track does not show what is asked for.
TrackMeasurement measure_track(const std::string& name, const Track& track, const MeasureChoices& choices);

/// For people, of the object that `measure --json` or `probe --json` prints every quantity, a line each, with
/// units and rounded to the standard deviation. `within` begins their names.
std::string measurement_text(const Json& json, const std::string& within = "");

}  // namespace tribotrack::apps
