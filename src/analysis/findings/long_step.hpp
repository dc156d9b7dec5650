#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A step that is too long for its rule: a motion grows that decays or oscillates in time.
struct LongStep {
  int knot = 0;
  double step = 0;     ///< s
  double rate = 0;     ///< absolute value of that motion's eigenvalue, 1/s
  double growth = 0;   ///< growth factor of the motion in the step
  double longest = 0;  ///< longest step that is stable, approximately, s
};

/// The step along a trajectory with the largest growth of such a motion; nullopt if all are stable.
/// - Explicit Runge-Kutta rules: eigenvalues of the linearized motion that decay within a step,
///   outside the rule's region of stability.
/// - Semi-implicit Euler: motions that grow and change their sign at each step.
/// Collocation rules are stable for all decaying motions. Steps are sampled evenly, more of them
/// for smaller states. Steps whose derivatives are not finite do not count.
std::optional<LongStep> long_step(const ShootingProblem& problem, const Trajectory& trajectory);

/// True if a problem file may use collocation: no contact is held, and no system uses time
/// stepping.
bool allows_collocation(const ShootingProblem& problem);

/// Remedy: an implicit rule if the problem allows one, or shorter steps.
std::string remedy_of(const LongStep& step, const ShootingProblem& problem);

}  // namespace conddp
