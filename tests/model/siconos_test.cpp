// The integrator against Siconos, an independent implementation of set-valued friction, where Debian's
// python3-siconos is installed.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <numbers>
#include <string>

#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

struct Answer {
  int exit_code = -1;
  std::string text;
};

Answer siconos(const Scenario& s, int steps_per_cycle) {
  char command[1000];
  std::snprintf(
      command, sizeof command,
      "/usr/bin/python3 '%s/tests/model/siconos_platform.py' %.17g %.17g %.17g %.17g %.17g %.17g %.17g %d "
      "%d 2>&1",
      TRIBOTRACK_SOURCE_DIR, s.drive.amplitude, s.drive.angular_frequency, s.drive.gravity,
      s.friction.nominal, s.friction.reduced, s.friction.phase, s.friction.pulse_width,
      static_cast<int>(s.cycles), steps_per_cycle);
  Answer answer;
  FILE* pipe = popen(command, "r");
  if (!pipe) return answer;
  char line[500];
  while (std::fgets(line, sizeof line, pipe)) answer.text += line;
  const int status = pclose(pipe);
  answer.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return answer;
}

/// Its error is of first order in the step: from steps h, h/2, h/4 the first two terms are removed.
Vector2d extrapolated(const std::string& text) {
  double x[3], y[3];
  if (std::sscanf(text.c_str(), "%lf %lf %lf %lf %lf %lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]) != 6)
    return Vector2d::Constant(NAN);
  return {(x[0] - 6 * x[1] + 8 * x[2]) / 3, (y[0] - 6 * y[1] + 8 * y[2]) / 3};
}

TEST(Siconos, ComesToTheSameEnd) {
  Scenario slips;
  slips.friction = {0.1, 0.0125, pi / 6, pi / 2, 0};  // edges between steps: a multiple of 12 a cycle
  slips.cycles = 3;
  Scenario sticks = slips;
  sticks.friction = {0.122, 0.01525, pi / 3, pi / 6, 0};
  ASSERT_GT(integrate(sticks).summary().stick_time, 0);
  for (const Scenario& s : {slips, sticks}) {
    const Answer answer = siconos(s, 1200);
    if (answer.exit_code == 77 || answer.exit_code == 127) GTEST_SKIP() << answer.text;
    ASSERT_EQ(answer.exit_code, 0) << answer.text;
    const Vector2d theirs = extrapolated(answer.text), ours = integrate(s).end().position;
    std::printf("mu1 %g: %g m apart of %g m\n", s.friction.nominal, (theirs - ours).norm(), ours.norm());
    EXPECT_LT((theirs - ours).norm(), 1e-6 * ours.norm());
  }
}

}  // namespace
}  // namespace tribotrack::model
