#pragma once

#include <optional>
#include <vector>

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

/// A run of steps with the same closed candidates.
struct ContactStretch {
  int first = 0, steps = 0;   ///< in steps of the motion
  std::vector<bool> closed;   ///< per candidate
  std::vector<bool> slides;   ///< per candidate: closed and sliding along its surface
  std::vector<bool> landing;  ///< per candidate: closes at the start of the stretch
  /// Forces outside the contacts of the stretch: at landings, and in contacts that are too short.
  struct Push {
    int steps = 0;
    double largest = 0;  ///< N
  };
  std::vector<Push> pushes;  ///< per candidate
  bool lands() const;
};

struct ContactSequenceOptions {
  double gap = 1e-5;    ///< m: a candidate touches below this gap
  double share = 1e-4;  ///< of the weight: a force counts above this share
  double slip = 1e-2;   ///< m/s: a contact slides if it is faster at any node
  int shortest = 2;     ///< steps: shorter contacts and flights are left out
};

/// Contact sequence that a motion found, in the form of a contact schedule. A step has a contact if
/// its force acts and the candidate touches already at the start of the step. A step that ends with
/// a landing is thus a flight step with an impact at its end. Forces in steps without such a
/// contact are reported separately.
std::vector<ContactStretch> contact_sequence(const ContactMotion& motion,
                                             const ContactSequenceOptions& options = {});

}  // namespace conddp
