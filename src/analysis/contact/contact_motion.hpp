#pragma once

#include <optional>

#include "analysis/contact/stepping_equations.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// A contact-implicit motion in the terms of its plant: N steps between N + 1 nodes.
struct ContactMotion {
  ContactPlant plant;
  int first_knot = 0;                 ///< in the problem: 1 if a knot chooses the initial state
  std::vector<double> h;              ///< s, one per step
  std::vector<Eigen::VectorXd> q, v;  ///< nq and nv numbers, one vector per node
  std::vector<Eigen::VectorXd> u;     ///< actuators, one vector per step
  std::vector<StepForces> forces;     ///< forces of each step, at its end
  Eigen::VectorXd u_lower, u_upper;   ///< bounds on the actuators

  int steps() const { return static_cast<int>(h.size()); }
  StepStart start(int k) const { return {q[k], v[k], applied(u[k]), h[k]}; }
  Eigen::VectorXd applied(const Eigen::VectorXd& controls) const;
};

/// Motion of a contact-implicit problem (SteppingSystem); nullopt for other problems.
std::optional<ContactMotion> contact_motion(const ShootingProblem& problem,
                                            const Trajectory& trajectory);

}  // namespace conddp
