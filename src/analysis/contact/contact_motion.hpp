#pragma once

#include <optional>

#include "analysis/contact/stepping_equations.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// A motion that found its own contacts, in the terms of its plant: N steps between N + 1 nodes.
struct ContactMotion {
  ContactPlant plant;
  int first_knot = 0;                 ///< of the problem: 1 where a knot chooses the first state
  std::vector<double> h;              ///< s, one a step
  std::vector<Eigen::VectorXd> q, v;  ///< nq and nv numbers, one a node
  std::vector<Eigen::VectorXd> u;     ///< actuators, one a step
  std::vector<StepForces> forces;     ///< of each step, at its end
  Eigen::VectorXd u_lower, u_upper;   ///< bounds on the actuators

  int steps() const { return static_cast<int>(h.size()); }
  StepStart start(int k) const { return {q[k], v[k], applied(u[k]), h[k]}; }
  Eigen::VectorXd applied(const Eigen::VectorXd& controls) const;
};

/// A trajectory of a contact-implicit problem (SteppingSystem); none of others.
std::optional<ContactMotion> contact_motion(const ShootingProblem& problem,
                                            const Trajectory& trajectory);

}  // namespace conddp
