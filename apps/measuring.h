// From a track table to what the fit takes: displacement, platform, phase at the start.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/track_file.h"
#include "fit/measurement.h"

namespace tribotrack::apps {

/// What is known beforehand of one run's conditions; what is empty is measured from the marker.
struct GivenConditions {
  std::optional<double> angular_frequency;  ///< rad/s
  std::optional<double> amplitude;          ///< m
  std::optional<double> phase_shift;        ///< rad
  std::optional<double> phase_at_zero;      ///< rad
  int cycles = 20;
};

/// Everything one track tells.
struct RunMeasurement {
  std::optional<fit::PlatformMotion> platform;
  std::optional<fit::Displacement> displacement;   ///< empty where w is neither given nor measured
  std::optional<fit::Estimate> angular_frequency;  ///< the one used: given (sd 0) or measured
  double phase_at_start = 0;                       ///< wt at the first tracked frame, rad
  std::string phase_source;                        ///< "marker", "given", "assumed 0"
  std::vector<std::string> warnings;
};

/// Throws fit::DataError (track shorter than one cycle) and InvalidInput (measured sense contradicts the
/// given one); `name` stands in their messages.
RunMeasurement measure_run(const std::string& name, const TrackFile& track, const GivenConditions& given);

/// The object `measure --json` prints: every quantity that can be told, with its _sd.
Json measurement_json(const RunMeasurement& measurement, const TrackFile& track);

}  // namespace tribotrack::apps
