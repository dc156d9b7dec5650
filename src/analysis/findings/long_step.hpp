#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A step on which a motion grows that decays or oscillates in time: it is too long for its rule.
struct LongStep {
  int knot = 0;
  double step = 0;     ///< s
  double rate = 0;     ///< of that motion, 1/s: the absolute value of its eigenvalue
  double growth = 0;   ///< what the step multiplies the motion by
  double longest = 0;  ///< s: steps up to about this are stable
};

/// The step along a trajectory on which such a motion grows most; nothing where there is none.
/// - Explicit Runge-Kutta rules: eigenvalues of the linearized motion that decay within a step,
///   outside the rule's region of stability.
/// - Semi-implicit Euler: motions that grow and change their sign at each step.
/// Collocation rules are stable for all that decays. Steps are sampled evenly, the more of them the
/// smaller the state; those at which derivatives are not finite do not count.
std::optional<LongStep> long_step(const ShootingProblem& problem, const Trajectory& trajectory);

/// Whether a problem file may have collocation: where no contact is held, and nothing steps in
/// time.
bool allows_collocation(const ShootingProblem& problem);

/// What helps: an implicit rule where the problem may have one, or shorter steps.
std::string remedy_of(const LongStep& step, const ShootingProblem& problem);

}  // namespace conddp
