#include "apps/bench/claims/claims.h"

#include <array>
#include <cmath>
#include <numbers>

#include "apps/bench/claims/sweeps.h"

namespace tribotrack::bench {

using namespace model;

Scenario paper_conditions(double mu1, double dtau, double phi) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, phi, dtau, 0};
  return s;
}

std::vector<PaperClaim> paper_claims(const ClaimOptions& options) {
  constexpr std::array claims = {
      circular_end_state, full_circle,          linear_in_phase,  v_independent_of_phase, v_over_width,
      v_over_ratio,       v_over_amplitude,     v_over_frequency, v_over_friction,        alpha_over_width,
      alpha_over_ratio,   alpha_over_amplitude, effect_of_tilt};
  std::vector<PaperClaim> found;
  for (const auto claim : claims) {
    found.push_back(claim(options.quick));
    if (options.progress) options.progress(static_cast<int>(found.size()), static_cast<int>(claims.size()));
  }
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
  int best = 1;
  double greatest = 0;
  for (int i = 1; i < kCoarse; ++i)
    if (const double here = v(kTurn * i / kCoarse); here > greatest) {
      greatest = here;
      best = i;
    }
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
    case Verdict::fails:
      return "fails";
  }
  return "";
}

}  // namespace tribotrack::bench
