#include <cstdio>

#include "fit/measurement.h"
#include "model/trajectory.h"
#include "vision/frame_source.h"

int main(int argc, char** argv) {
  tribotrack::model::Scenario scenario;
  scenario.friction = {.nominal = 0.1, .reduced = 0.0125, .phase = 0.5, .pulse_width = 1.5707963267948966};
  const auto end = tribotrack::model::integrate(scenario).end();
  std::printf("%.9f %.9f mm\n", end.position.x() * 1e3, end.position.y() * 1e3);
  const auto displacement =
      tribotrack::fit::displacement_from_alpha_v({5.93, 0.02}, {1.78e-3, 4e-5}, 62.8, 20);
  std::printf("%.6f mm\n", displacement.vector.norm() * 1e3);
  return argc > 1 ? tribotrack::vision::open_source(argv[1])->info().width : 0;
}
