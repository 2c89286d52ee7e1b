// What is known of each parameter of a fit, and the conditions that its values count from.
#pragma once

#include "fit/problem.h"
#include "fit/tools/transform.h"

namespace tribotrack::fit::internal {

/// Sort of value. A phase is an angle within a turn, a tilt one against the horizontal.
enum class Sort { number, not_negative, positive, phase, tilt };

struct ParameterFacts {
  const char* name;           ///< as in campaigns
  const char* source;         ///< as a source of error in the budget; null: it is one by its prior alone
  Transform::Kind transform;  ///< to the axis on which it is searched for
  Sort sort;
  bool is_angle() const { return sort == Sort::phase || sort == Sort::tilt; }
  /// Its changes are given in per cent of its own value.
  bool is_relative() const { return sort == Sort::positive || sort == Sort::not_negative; }
};
const ParameterFacts& facts(FitParameter parameter);

/// Where a Stribeck term has faded is not known: its prior's mean and sd, relative (FitParameter).
inline constexpr double kStribeckSpeed = 0.25;
/// Friction that falls at less is friction at rest, to all that a displacement tells, and stiff to integrate.
inline constexpr double kLeastStribeckSpeed = 0.01;

/// Conditions of the first driven run, or of the first one where none is driven.
struct Reference {
  double amplitude = 0;           ///< m, of the longer axis
  double angular_frequency = 1;   ///< rad/s
  double gravity = 9.81;          ///< m/s^2
  double tilt_x = 0, tilt_y = 0;  ///< rad
  /// Value of a parameter that is neither fitted nor fixed: 0 where runs have none.
  double as_given(FitParameter parameter) const;
};
Reference reference_of(const Problem& problem);

}  // namespace tribotrack::fit::internal
