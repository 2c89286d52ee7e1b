#include "apps/simulating/simulation.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/program/errors.h"
#include "model/alpha_v.h"
#include "model/steady_orbit.h"

namespace tribotrack::apps {

namespace {

double intervals_of(const model::Scenario& scenario, int samples_per_cycle) {
  return std::ceil(scenario.cycles * samples_per_cycle);
}

}  // namespace

Json simulation_json(const model::Trajectory& trajectory) {
  const auto& scenario = trajectory.scenario();
  const model::Sample end = trajectory.end();
  Json json;
  json["end_x_mm"] = end.position.x() * 1e3;
  json["end_y_mm"] = end.position.y() * 1e3;
  const bool moved = end.position.norm() > 0;
  json["alpha_rad"] = moved ? Json(model::displacement_angle(end.position)) : Json();
  json["v_mm_s"] = model::mean_velocity(end.position, trajectory.end_time()) * 1e3;
  json["cycles"] = scenario.cycles;
  json["stops"] = trajectory.summary().stops;
  json["sticking_fraction"] = trajectory.summary().sticking_fraction;
  json["steps"] = trajectory.summary().steps;
  json["steady"] = Json();
  if (const auto orbit = model::steady_orbit(scenario); orbit && scenario.cycles > 0) {
    constexpr double kRounding = 1e-12;  // of the platform's velocity
    double v = orbit->mean_velocity(scenario.drive.angular_frequency);
    if (v < kRounding * scenario.drive.amplitude * scenario.drive.angular_frequency) v = 0;
    json["steady"] = {{"alpha_rad", v > 0 ? Json(orbit->alpha()) : Json()}, {"v_mm_s", v * 1e3}};
  }
  return json;
}

void for_each_row(const model::Trajectory& trajectory, int samples_per_cycle,
                  const std::function<void(const SimulatedRow&)>& visit) {
  const auto count = static_cast<long>(intervals_of(trajectory.scenario(), samples_per_cycle));
  for (long k = 0; k <= count; ++k) {
    const double time = k == count
                            ? trajectory.end_time()
                            : trajectory.end_time() * static_cast<double>(k) / static_cast<double>(count);
    const model::Sample s = trajectory.at(time);
    visit({s.time, s.position.x() * 1e3, s.position.y() * 1e3, s.velocity.x() * 1e3, s.velocity.y() * 1e3,
           s.mu, s.state == model::State::slip ? "slip" : "stick"});
  }
}

void require_sensible_table(const std::string& name, const model::Scenario& scenario, int samples_per_cycle) {
  constexpr double kBytesPerRow = 120, kLargest = 2e9;
  const double rows = intervals_of(scenario, samples_per_cycle) + 1;
  if (rows * kBytesPerRow < kLargest) return;
  throw InvalidInput(
      fmt::format("{}: the table would have {:.0f} rows and take about {:.3g} GB, of at most {:.0f} GB: "
                  "lower --cycles or --samples-per-cycle",
                  name, rows, 1e-9 * rows * kBytesPerRow, 1e-9 * kLargest));
}

}  // namespace tribotrack::apps
