// From a track table to the input of the fit: displacement, platform, phase at the start.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/files/track_file.h"
#include "fit/gate_timing.h"
#include "fit/measurement.h"
#include "fit/scope_timing.h"

namespace tribotrack::apps {

/// A run's oscilloscope trace, read and searched for its events.
struct ScopeEvidence {
  fit::ScopeEvents events;
  std::optional<fit::SensorClock> sensor;
  /// How its time is tied to the camera's: "sensor": not at all, phi counts from the reference sensor's
  /// pulses; "trigger": both saw one trigger; "lamp": the lamp in the picture gives phi, the trace dtau.
  std::string tie = "sensor";
  std::optional<double> trigger_time;  ///< s, of the oscilloscope's zero in the camera's time
  double tie_sd = 0;                   ///< s
};

/// What is known beforehand of one run's conditions; what is empty is measured from the marker.
struct GivenConditions {
  bool lamp = false;                        ///< a lamp's place in the picture is given
  std::optional<double> angular_frequency;  ///< rad/s
  std::optional<double> phase_shift;        ///< rad
  std::optional<double> phase_at_zero;      ///< rad
  std::optional<double> phi, dtau;          ///< rad, as commanded: only compared with what is seen
  std::optional<ScopeEvidence> scope;
  int cycles = 20;
};

/// What a lossy coder does to the platform's motion as measured.
struct CodedMotion {
  std::string coder;
  /// At the most: of the amplitude, relative, and of the phase, rad. All of it counts in the standard
  /// deviations.
  double attenuation = 0, delay = 0;
  bool exceeds = false;  ///< one of these the 95 % interval of what the track alone tells
  std::string sentence() const;
};

/// Everything measured from one track.
struct RunMeasurement {
  std::optional<fit::PlatformMotion> platform;
  std::optional<fit::Displacement> displacement;   ///< empty where w is neither given nor measured
  std::optional<fit::Estimate> angular_frequency;  ///< the one used: given (sd 0) or measured
  double start_time = 0;                           ///< s, of the first tracked frame
  double phase_at_start = 0;                       ///< wt there, rad
  std::string phase_source;                        ///< "marker", "texture", "given", "assumed 0"
  std::optional<fit::GateTiming> gate;             ///< phi and dtau as they were
  /// What phi counts from: "camera" (the platform's phase in the picture: a turned camera cancels) or
  /// "sensor" (the reference sensor, like a commanded phi).
  std::string gate_reference;
  bool phi_contradicts = false;                ///< what is seen of phi excludes the commanded one
  std::optional<CodedMotion> coded;            ///< where the platform's motion was seen in a lossy recording
  std::optional<fit::PhaseClock> phase_clock;  ///< wt in the camera's time, where it is known
  std::vector<std::string> warnings;
};

/// Throws fit::DataError (track shorter than one cycle) and InvalidInput (measured sense contradicts the
/// given one); `name` stands in their messages.
RunMeasurement measure_run(const std::string& name, const Track& track, const GivenConditions& given);

/// Why amplitudes, w and phases measured are wrong: the platform's motion breaks off and goes on elsewhere.
/// Empty where it does not.
std::string broken_motion(const Track& track, const RunMeasurement& measured);

/// Where a given w lies beyond five standard deviations of the measured one: a sentence.
std::vector<std::string> differences(const std::string& name, const RunMeasurement& measured,
                                     const GivenConditions& given);

/// The gate's timing comes from the lamp's brightness (its width maybe from an oscilloscope): its levels are
/// known.
bool lamp_gave_phi(const fit::GateTiming& gate);

/// The object `measure --json` prints: every quantity that was measured, with its _sd.
Json measurement_json(const RunMeasurement& measurement, const Track& track);
/// Scale, frames and warnings: how every measurement's object ends.
void put_recording(Json& json, const Track& track, const std::vector<std::string>& warnings);

/// A given value that is far from the one seen, by which slip? "9.995 is 62.8 rad/s in Hz", for a campaign
/// key and its given and measured value in the unit of the key; empty where none of the usual slips (another
/// unit, peak to peak, radius for diameter, period for frequency) comes within a tenth. The slips of one
/// quantity differ by 40 % and more.
std::string likely_slip(const std::string& quantity, double given, double measured);

}  // namespace tribotrack::apps
