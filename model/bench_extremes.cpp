// The table of stiff and extreme cases: each with a law that must hold there.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "model/bench.h"
#include "model/displacement_angle.h"
#include "model/internal/paired_timing.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

/// How far a law is from holding.
struct Law {
  std::string text;
  double allowed = 0;
  std::function<double(const Scenario&, const Vector2d& end)> violation;
};

struct Case {
  std::string name;
  Scenario scenario;
  Law law;
};

Vector2d end_of(const Scenario& scenario) {
  return integrate(scenario).end().position;
}

double relative(const Vector2d& difference, const Vector2d& to) {
  const double size = to.norm();
  return difference.norm() == 0 ? 0
                                : difference.norm() / (size > 0 ? size : std::numeric_limits<double>::min());
}

/// (A, w) -> (A/9, 3w) leaves x/A as a function of wt: a = A w^2, and with it every ratio to mu g, stays.
Law scaling() {
  return {"(A/9, 3w): x/A unchanged", 1e-11, [](const Scenario& s, const Vector2d& end) {
            Scenario twin = s;
            twin.drive.amplitude /= 9;
            twin.drive.amplitude_y /= 9;
            twin.drive.angular_frequency *= 3;
            twin.initial_velocity /= 3;
            twin.duration /= 3;
            return relative(9 * end_of(twin) - end, end);
          }};
}

/// The end point of a neighbouring scenario, which must agree.
Law same_as(const std::string& text, const Scenario& other, double allowed) {
  return {text, allowed, [other](const Scenario&, const Vector2d& end) {
            const Vector2d there = end_of(other);
            return relative(end - there, there);
          }};
}

Law ends_at(const std::string& text, const Vector2d& place, double allowed = 1e-11) {
  return {text, allowed,
          [place](const Scenario&, const Vector2d& end) { return relative(end - place, place); }};
}

Law never_moves() {
  return {"never moves", 0, [](const Scenario&, const Vector2d& end) { return end.norm(); }};
}

class Cases {
 public:
  explicit Cases(bool quick) {
    base_.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
    base_.cycles = quick ? 2 : 20;
    a_ = base_.drive.amplitude * std::pow(base_.drive.angular_frequency, 2);
    threshold_ = a_ / base_.drive.gravity;
    add("ordinary", base_, scaling());
    friction();
    marginal();
    pulses();
    drives();
    starts();
    tilts();
    many_cycles(quick);
  }
  std::vector<Case> take() { return std::move(cases_); }

 private:
  void add(const std::string& name, const Scenario& scenario, const Law& law) {
    cases_.push_back({name, scenario, law});
  }
  Scenario with_mu(double mu1, double mu2) const {
    Scenario s = base_;
    s.friction.nominal = mu1;
    s.friction.reduced = mu2;
    return s;
  }

  void friction() {
    add("mu2 = 0", with_mu(0.1, 0), scaling());
    add("mu1/mu2 = 1e6", with_mu(0.1, 1e-7), scaling());
    Scenario constant = with_mu(0.1, 0.1);
    constant.friction.pulse_width = 0;
    add("mu1 = mu2", with_mu(0.1, 0.1), same_as("as without pulses", constant, 1e-11));
    add("mu1 = 0, mu2 > 0", with_mu(0, 0.0125), scaling());
    const double time = base_.end_time();
    add("mu1 = mu2 = 0", with_mu(0, 0),
        ends_at("drifts by -A w t in y", {0, -base_.drive.amplitude * base_.drive.angular_frequency * time},
                1e-11));
    Scenario weak_drive = with_mu(0.1, 0.0125);
    weak_drive.friction.nominal = 1e3 * threshold_;
    weak_drive.friction.reduced = 125 * threshold_;
    add("a/(mu1 g) = 1e-3", weak_drive, never_moves());
    add("a/(mu1 g) = 1e4", with_mu(1e-4 * threshold_, 1.25e-5 * threshold_), scaling());
    add("mu1 g = 2 a", with_mu(2 * threshold_, 0.0125), scaling());
    add("mu1 g = 2 a (1 + 1e-9)", with_mu(2 * threshold_ * (1 + 1e-9), 0.0125),
        same_as("as at 2 a", with_mu(2 * threshold_, 0.0125), 1e-8));
    add("mu1 g = 2 a (1 - 1e-9)", with_mu(2 * threshold_ * (1 - 1e-9), 0.0125),
        same_as("as at 2 a", with_mu(2 * threshold_, 0.0125), 1e-8));
    add("mu1 g = 100 a", with_mu(100 * threshold_, 0.0125), scaling());
  }

  void marginal() {
    const Scenario exact = with_mu(threshold_, threshold_ / 8);
    add("a = mu1 g", exact, scaling());
    for (const double offset : {1e-3, 1e-6, 1e-9, 1e-12})
      for (const double side : {1.0, -1.0}) {
        const double mu = threshold_ / (1 + side * offset);
        char name[64];
        std::snprintf(name, sizeof name, "a/(mu1 g) = 1 %c %g", side > 0 ? '+' : '-', offset);
        // The path's own dependence on mu1 is of the order of its relative change.
        add(name, with_mu(mu, threshold_ / 8),
            same_as("as at 1, times 100 offsets", exact, 100 * offset + 1e-11));
      }
  }

  void pulses() {
    const auto with_pulse = [this](double phi, double dtau) {
      Scenario s = base_;
      s.friction.phase = phi;
      s.friction.pulse_width = dtau;
      return s;
    };
    const Scenario none = with_mu(0.1, 0.1), always = with_mu(0.0125, 0.0125);
    add("dtau = 0", with_pulse(0.5, 0), same_as("as at constant mu1", none, 1e-11));
    add("dtau = 1e-9", with_pulse(0.5, 1e-9), same_as("as at constant mu1", none, 1e-6));
    add("dtau = 2 pi", with_pulse(0.5, 2 * pi), same_as("as at constant mu2", always, 1e-11));
    add("dtau = 2 pi - 1e-9", with_pulse(0.5, 2 * pi - 1e-9), same_as("as at constant mu2", always, 1e-6));
    add("phi = 0", with_pulse(0, pi / 2), scaling());
    add("phi = 2 pi", with_pulse(2 * pi, pi / 2), same_as("as at phi = 0", with_pulse(0, pi / 2), 1e-11));
    add("phi = -37.5", with_pulse(-37.5, pi / 2),
        same_as("as at phi + 12 pi", with_pulse(-37.5 + 12 * pi, pi / 2), 1e-11));
    const double reduced = std::fmod(1e6, 2 * pi);
    // The place of the edge is known to 1e6 epsilon only.
    add("phi = 1e6", with_pulse(1e6, pi / 2),
        same_as("as at phi mod 2 pi", with_pulse(reduced, pi / 2), 1e-8));
    add("closing edge on the cycle's end", with_pulse(1.5 * pi, pi / 2), scaling());
  }

  void drives() {
    const auto with_epsilon = [this](double epsilon) {
      Scenario s = base_;
      s.drive.phase_shift = epsilon;
      return s;
    };
    const auto on_line = [](double slope) {
      return Law{slope > 0 ? "stays on the line y = x" : "stays on the line y = -x", 1e-11,
                 [slope](const Scenario&, const Vector2d& end) {
                   return relative(Vector2d(end.y() - slope * end.x(), 0), end);
                 }};
    };
    add("epsilon = 0", with_epsilon(0), on_line(1));
    add("epsilon = pi", with_epsilon(pi), on_line(-1));
    add("epsilon = 1e-8", with_epsilon(1e-8), same_as("as at 0", with_epsilon(0), 1e-5));
    add("epsilon = pi/2 + 1e-12", with_epsilon(pi / 2 + 1e-12), same_as("as at pi/2", base_, 1e-10));
    add("epsilon = pi/2 - 1e-12", with_epsilon(pi / 2 - 1e-12), same_as("as at pi/2", base_, 1e-10));
    // Counter-clockwise is the mirror image of cos(wt + pi/2).
    const Vector2d end = end_of(base_);
    add("epsilon = -pi/2", with_epsilon(-pi / 2), ends_at("mirror image of pi/2", {end.x(), -end.y()}));
    for (const double w : {1e-3, 1e5}) {
      Scenario s = base_;
      s.drive.angular_frequency = w;
      const double a = s.drive.amplitude * w * w;
      s.friction.nominal = 0.9 * a / s.drive.gravity;
      s.friction.reduced = s.friction.nominal / 8;
      add(w < 1 ? "w = 1e-3 rad/s" : "w = 1e5 rad/s", s, scaling());
    }
    for (const double amplitude : {1e-9, 1.0}) {
      Scenario s = base_;
      s.drive.amplitude = s.drive.amplitude_y = amplitude;
      const double a = amplitude * std::pow(s.drive.angular_frequency, 2);
      s.friction.nominal = 0.9 * a / s.drive.gravity;
      s.friction.reduced = s.friction.nominal / 8;
      add(amplitude < 1 ? "A = 1 nm" : "A = 1 m", s, scaling());
    }
  }

  void starts() {
    const double speed = base_.drive.amplitude * base_.drive.angular_frequency;
    for (const double miss : {1e-3, 1e-8, 1e-14}) {
      // A drive along a line, the velocity against it and slightly beside it: u misses 0 by about `miss`.
      Scenario s = base_;
      s.drive.phase_shift = 0;
      const Vector2d along = Vector2d(1, 1).normalized(), across = Vector2d(-1, 1).normalized();
      s.initial_velocity = speed * (-0.3 * along + miss * across);
      char name[64];
      std::snprintf(name, sizeof name, "u misses 0 by %g of A w", miss);
      add(name, s, scaling());
    }
    Scenario tiny = base_;
    tiny.initial_velocity = {1e-300, 0};
    add("initial speed 1e-300 m/s", tiny, same_as("as from rest", base_, 1e-11));
    Scenario fast = base_;
    fast.initial_velocity = {1e3, 0};
    add("initial speed 1e3 m/s", fast, scaling());
    Scenario slide = base_;
    slide.drive.amplitude = slide.drive.amplitude_y = 0;
    slide.friction.pulse_width = 0;
    slide.initial_velocity = {0.3, 0.4};
    slide.duration = 2;
    // u^2 / (2 mu g) along u.
    const double path = 0.25 / (2 * 0.1 * slide.drive.gravity);
    add("A = 0, free slide to its stop", slide,
        ends_at("stops after u^2/(2 mu g)", {0.6 * path, 0.8 * path}));
  }

  void tilts() {
    for (const double side : {-1.0, 1.0}) {
      Scenario s = base_;
      s.drive.amplitude = s.drive.amplitude_y = 0;
      s.friction.pulse_width = 0;
      s.drive.tilt_x = std::asin(s.friction.nominal * (1 + side * 1e-6));
      s.duration = 2;
      const double g = s.drive.gravity;
      const double left = g * std::sin(s.drive.tilt_x) - s.friction.nominal * g;
      if (side < 0)
        add("A = 0, tilt 1e-6 below sliding", s, never_moves());
      else  // the difference of two nearly equal numbers: good to epsilon / 1e-6
        add("A = 0, tilt 1e-6 above sliding", s,
            ends_at("slides (g sin tilt - mu g) t^2/2", {0.5 * left * s.duration * s.duration, 0}, 1e-9));
    }
  }

  void many_cycles(bool quick) {
    // Once periodic, every cycle adds the same drift.
    Scenario s = base_;
    s.cycles = quick ? 100 : 1000000;
    add(quick ? "100 cycles" : "1e6 cycles", s,
        {"last half adds (cycles/2) drifts of the periodic orbit", 1e-10,
         [](const Scenario& scenario, const Vector2d& end) {
           Scenario half = scenario;
           half.cycles /= 2;
           const auto orbit = steady_orbit(scenario);
           if (!orbit) return std::numeric_limits<double>::infinity();
           return relative(end - end_of(half) - half.cycles * orbit->drift, end);
         }});
  }

  Scenario base_;
  double a_ = 0, threshold_ = 0;
  std::vector<Case> cases_;
};

ModelExtremeRow judge(const Case& c) {
  ModelExtremeRow row;
  row.name = c.name;
  row.invariant = c.law.text;
  row.allowed = c.law.allowed;
  try {
    const Trajectory trajectory = integrate(c.scenario);
    const Sample end = trajectory.end();
    row.end = end.position;
    row.finite = end.position.allFinite() && end.velocity.allFinite();
    row.steps = trajectory.summary().steps;
    row.stops = trajectory.summary().stops;
    row.violation = c.law.violation(c.scenario, end.position);
    row.held = row.finite && row.violation <= row.allowed;
  } catch (const std::exception& error) {
    row.failure = error.what();
    row.violation = std::numeric_limits<double>::infinity();
  }
  return row;
}

double cycles_of(const Scenario& s) {
  return s.end_time() * s.drive.angular_frequency / (2 * pi);
}

}  // namespace

std::vector<ModelExtremeRow> bench_model_extremes(const ModelBenchOptions& options) {
  const std::vector<Case> cases = Cases(options.quick).take();
  std::vector<ModelExtremeRow> rows;
  std::vector<std::function<void()>> competitors;
  for (const Case& c : cases) {
    rows.push_back(judge(c));
    const bool failed = !rows.back().failure.empty();
    competitors.push_back([&c, failed] {
      if (!failed) integrate(c.scenario);
    });
    if (options.progress) options.progress(static_cast<int>(rows.size()), static_cast<int>(cases.size()));
  }
  internal::PairedTiming timing;
  timing.rounds = options.quick ? 3 : 21;
  timing.budget_s = options.quick ? 0.01 : 0.1;
  const auto times = internal::paired_medians(competitors, timing);
  const double ordinary = times.front().seconds / cycles_of(cases.front().scenario);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time = times[k].seconds;
    rows[k].ratio_per_cycle = times[k].seconds / cycles_of(cases[k].scenario) / ordinary;
  }
  return rows;
}

}  // namespace tribotrack::model
