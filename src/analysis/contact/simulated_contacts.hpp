#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "analysis/contact/contact_simulator.hpp"
#include "mpc/plant_motion.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Plant of a closed loop whose contacts open, close and slip by themselves in steps of
/// ContactSimulator, independently of the phases. States are those of the robot (q, v), then
/// remembered controls.
///
/// A step first includes the candidates near its start. If another candidate overlaps at its end,
/// the step is repeated with that one as well, so that it is a step of all candidates.
class SimulatedContacts final : public PlantMotion {
 public:
  /// `dt`: the longest step, s. `contact_of`: the contact of each candidate, from 0 on, which is
  /// its bit in closed_contacts(). `remembered`: number of entries at the end of a state that hold
  /// the control applied last.
  SimulatedContacts(const ContactPlant& plant, double dt, std::vector<int> contact_of,
                    int remembered);

  double next_stop(double time) const override { return time + dt_; }
  void pass_instants(double /*time*/, double* /*x*/) override {}
  /// A failed step sets all of x to NaN.
  void step(double time, double length, const double* u, double* x) override;
  std::uint32_t closed_contacts() const override { return closed_; }
  std::string_view failure() const override;
  std::span<const double> contact_forces() const override { return forces_; }

 private:
  void use(std::vector<std::size_t> candidates);
  std::vector<std::size_t> near(const double* q, const std::vector<std::size_t>& more, double gap);
  ContactStep step(const StepStart& start);
  void find_contacts(const ContactStep& taken);

  ContactPlant plant_;
  double dt_;
  std::vector<int> contact_of_;
  int remembered_;
  ContactMechanics<double> mechanics_;
  std::vector<std::size_t> near_;  ///< candidates in the simulator, in order
  std::optional<ContactSimulator> simulator_;
  std::uint32_t closed_ = 0;
  bool failed_ = false;
  std::vector<double> forces_;  ///< three numbers per contact
};

/// Simulation of a contact-implicit problem by ContactSimulator from the guess's first state, under
/// the guess's actuator controls, or with `policy` under its gains about the guess: states,
/// accelerations, forces and slacks of every step satisfy the stepping equations and their
/// complementarity. Nothing for other problems, and where a step has no solution.
std::optional<Trajectory> simulated_guess(const ShootingProblem& problem, const Trajectory& guess,
                                          const Feedback* policy = nullptr);

}  // namespace conddp
