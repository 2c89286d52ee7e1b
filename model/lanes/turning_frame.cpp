#include "model/lanes/turning_frame.h"

#include <cmath>

namespace tribotrack::model::internal {

std::optional<TurningFrame> turning_frame(const Scenario& scenario) {
  const SolverInput<double> in = set_up<double>(scenario, {});
  const auto& drive = in.problem.drive;
  const double a = length(drive.p), size = a * a;
  const bool round = a > 0 && drive.constant.x == 0 && drive.constant.y == 0 &&
                     std::fabs(dot(drive.q, drive.q) - size) <= 4e-15 * size &&
                     std::fabs(dot(drive.p, drive.q)) <= 2e-15 * size;
  if (!round) return std::nullopt;
  TurningFrame f;
  f.kappa_nominal = in.problem.kappa_nominal / a;
  f.kappa_reduced = in.problem.kappa_reduced / a;
  f.edges = in.edges;
  f.circling = in.circling;
  f.cycles = in.cycles;
  f.rest = in.rest;
  f.length = a * in.problem.velocity_unit / scenario.drive.angular_frequency;
  f.cosine = drive.p.x / a;
  f.sine = drive.p.y / a;
  f.sense = drive.p.x * drive.q.y - drive.p.y * drive.q.x > 0 ? 1 : -1;
  const Pair<double> u = in.velocity;
  f.velocity = {(u.x * f.cosine + u.y * f.sine) / a, f.sense * (u.y * f.cosine - u.x * f.sine) / a};
  return f;
}

}  // namespace tribotrack::model::internal
