#include "apps/bench/claims/claims.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>

#include "apps/bench/claims/sweeps.h"
#include "model/parallel.h"

namespace tribotrack::bench {

using namespace model;

Scenario paper_conditions(double mu1, double dtau, double phi) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, phi, dtau, 0};
  return s;
}

std::vector<PaperClaim> paper_claims(const ClaimOptions& options) {
  // In the order of the paper's figures.
  constexpr std::array claims = {circular_end_state,   keeps_moving,         displacement_over_width,
                                 alpha_by_phase,       full_circle,          less_stretched,
                                 v_over_width,         v_over_ratio,         v_over_amplitude,
                                 v_over_frequency,     v_over_friction,      v_independent_of_phase,
                                 linear_in_phase,      alpha_over_width,     alpha_over_amplitude,
                                 alpha_over_frequency, alpha_over_ratio,     effect_of_tilt,
                                 v_in_experiment,      further_in_experiment};
  std::vector<PaperClaim> found(claims.size());
  std::mutex mutex;
  int done = 0;
  parallel_for(claims.size(), options.threads, [&](std::size_t place) {
    found[place] = claims[place](options.quick);
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress) options.progress(done, static_cast<int>(claims.size()));
  });
  return found;
}

/// Coarsely, then by golden sections: v has one maximum in dtau.
double width_of_greatest_v(Scenario s, bool steady) {
  const auto v = [&](double dtau) {
    s.friction.pulse_width = dtau;
    return (steady ? steady_drift(s) : drift_from_rest(s)).v;
  };
  constexpr double kTurn = 2 * std::numbers::pi;
  constexpr int kCoarse = 64;
  std::vector<Scenario> coarse(kCoarse - 1, s);
  for (int i = 1; i < kCoarse; ++i)
    coarse[static_cast<std::size_t>(i - 1)].friction.pulse_width = kTurn * i / kCoarse;
  const std::vector<double> coarse_v = steady ? steady_v(coarse) : v_from_rest(coarse);
  const auto best = static_cast<int>(std::ranges::max_element(coarse_v) - coarse_v.begin()) + 1;
  double low = kTurn * (best - 1) / kCoarse, high = kTurn * (best + 1) / kCoarse;
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double a = high - golden * (high - low), b = low + golden * (high - low), va = v(a), vb = v(b);
  while (high - low > 1e-6) {
    if (va > vb) {
      high = b;
      b = a;
      vb = va;
      a = high - golden * (high - low);
      va = v(a);
    } else {
      low = a;
      a = b;
      va = vb;
      b = low + golden * (high - low);
      vb = v(b);
    }
  }
  return (low + high) / 2;
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::exact:
      return "exact";
    case Verdict::holds:
      return "holds";
    case Verdict::holds_in_part:
      return "holds in part";
    case Verdict::refuted:
      return "refuted";
  }
  return "";
}

}  // namespace tribotrack::bench
