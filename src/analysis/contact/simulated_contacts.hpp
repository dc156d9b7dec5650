#pragma once

#include <vector>

#include "analysis/contact/contact_simulator.hpp"
#include "mpc/plant_motion.hpp"

namespace conddp {

/// A plant of a closed loop whose contacts open, close and slip by themselves, step by step of
/// ContactSimulator, whatever the phases say. States are those of the robot (q, v), then
/// remembered controls.
class SimulatedContacts final : public PlantMotion {
 public:
  /// `dt`: the longest step, s; `contact_of`: the bit of each candidate in closed_contacts();
  /// `remembered`: how many numbers at the end of a state are the control that was applied last.
  SimulatedContacts(const ContactPlant& plant, double dt, std::vector<int> contact_of,
                    int remembered);

  double next_stop(double time) const override { return time + dt_; }
  void pass_instants(double /*time*/, double* /*x*/) override {}
  /// A step that leaves the finite numbers makes all of x not a number.
  void step(double time, double length, const double* u, double* x) override;
  std::uint32_t closed_contacts() const override { return closed_; }

 private:
  ContactPlant plant_;
  double dt_;
  std::vector<int> contact_of_;
  int remembered_;
  ContactSimulator simulator_;
  std::uint32_t closed_ = 0;
};

}  // namespace conddp
