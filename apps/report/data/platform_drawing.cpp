#include "apps/report/data/platform_drawing.h"

#include <cmath>

#include "fit/gate_timing.h"
#include "fit/measurement.h"

namespace tribotrack::apps {
namespace {

void add_orbit(const TrackFile& track, const fit::PlatformMotion& motion, ReportPlatform& platform) {
  const fit::PlatformPicture picture = fit::picture_of(track.table, motion);
  for (std::size_t k = 0; k < picture.orbit.size(); ++k) {
    platform.orbit_x_mm.push_back(picture.orbit[k].x() * 1e3);
    platform.orbit_y_mm.push_back(picture.orbit[k].y() * 1e3);
    platform.time_s.push_back(track.table.time[k]);
    platform.phase_left_mrad.push_back(picture.phase_left[k] * 1e3);
  }
  for (const Eigen::Vector2d& m : picture.model) {
    platform.model_x_mm.push_back(m.x() * 1e3);
    platform.model_y_mm.push_back(m.y() * 1e3);
  }
}

void add_lamp(const fit::LampRecord& lamp, const fit::PlatformMotion& motion, ReportPlatform& platform) {
  const fit::PhaseClock clock{motion.angular_frequency.value, motion.phase_at_zero.value, 0};
  fit::GateTiming gate;
  gate.phi.value = platform.phi_rad;
  gate.dtau.value = platform.dtau_rad;
  gate.off_level = platform.lamp_off_level;
  gate.on_level = platform.lamp_on_level;
  const fit::FoldedLamp folded = fit::fold_lamp(lamp, clock, gate);
  platform.gate_phase_rad = folded.phase;
  platform.gate_share = folded.share;
  const fit::FoldedLamp model = fit::modelled_lamp(lamp, clock, gate);
  platform.gate_model_phase_rad = model.phase;
  platform.gate_model_share = model.share;
}

}  // namespace

void add_drawings(const TrackFile& track, ReportPlatform& platform) {
  if (!std::isfinite(platform.amplitude_mm) || track.table.marker.empty()) return;
  fit::PlatformMotion motion;
  motion.amplitude.value = platform.amplitude_mm * 1e-3;
  motion.amplitude_y.value = platform.amplitude_y_mm * 1e-3;
  motion.angular_frequency.value = platform.w_rad_s;
  motion.phase_shift.value = platform.epsilon_rad;
  motion.phase_at_zero.value = platform.phase_at_zero_rad;
  add_orbit(track, motion, platform);
  const bool lamp_gave_phi = std::isfinite(platform.lamp_on_level) && std::isfinite(platform.phi_rad);
  if (lamp_gave_phi && !track.lamp.time.empty()) add_lamp(track.lamp, motion, platform);
}

}  // namespace tribotrack::apps
