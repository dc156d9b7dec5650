#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/step/integrator.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// The contacts that each phase and the last node hold, and the systems that hold them.
class ContactPlan {
 public:
  /// Reports unknown names and invalid contacts, and warns of stabilization that is unstable at the
  /// time step. `initial`: state that defines the references of the contacts, unless swings move
  /// them.
  static std::optional<ContactPlan> build(const ProblemSpec& spec, const Plant& plant,
                                          const std::vector<double>& initial, Integrator integrator,
                                          Diagnostics& out);

  /// All contacts of the file, in its order.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// Index of the last node, after those of the phases.
  std::size_t terminal() const { return held_.size() - 1; }
  /// The contacts that a phase holds, as ascending indices into contacts().
  const std::vector<int>& held(std::size_t phase) const { return held_[phase]; }
  /// Index of a contact in the phase's system, nullopt if the phase does not hold it.
  std::optional<int> find(std::size_t phase, int contact) const;
  /// The same for several contacts, nullopt if the phase does not hold all of them.
  std::optional<std::vector<int>> find(std::size_t phase, const std::vector<int>& contacts) const;
  /// The system of a phase; without held contacts the plant's own. Phases with the same contacts
  /// share it.
  const std::shared_ptr<const System>& system(std::size_t phase) const { return systems_[phase]; }

 private:
  /// The contacts of a phase with their kp references there.
  std::vector<Contact> contacts_in(std::size_t phase) const;
  /// Reports a contact between frames with a given placement that the initial state does not have.
  bool check_loops(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                   Diagnostics& out) const;
  bool set_systems(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                   Diagnostics& out);

  std::vector<Contact> contacts_;
  /// Ascending indices into contacts_, for each phase and the last node.
  std::vector<std::vector<int>> held_;
  std::vector<std::shared_ptr<const System>> systems_;
  /// Each contact in each phase: swings move the reference of its kp, and terrain turns its normal.
  std::vector<std::vector<Contact>> by_phase_;
};

/// The chosen contacts, as indices into the file's; unknown names are reported.
std::vector<int> contacts_named(const ContactNames& names, const ProblemSpec& spec,
                                Diagnostics& out);

/// True if ë + kd ė + kp e = 0 decays when integrated with this rule and time step. Without kp a
/// constant error is allowed.
bool is_stable(Integrator integrator, double kp, double kd, double dt);

}  // namespace conddp
