#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/knot/integrator.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Which contacts each phase of a problem and its last node hold, and the systems that hold them.
class ContactPlan {
 public:
  /// Unknown names, contacts that cannot be, and stabilisation that the time step does not carry
  /// are reported. `initial`: the state from which contacts take their references, unless
  /// swings lead them elsewhere.
  static std::optional<ContactPlan> build(const ProblemSpec& spec, const Plant& plant,
                                          const std::vector<double>& initial, Integrator integrator,
                                          Diagnostics& out);

  /// All contacts of the file, in its order.
  const std::vector<Contact>& contacts() const { return contacts_; }
  /// The last node's number where a phase is asked for.
  std::size_t terminal() const { return held_.size() - 1; }
  /// The contacts that a phase holds, as indices into contacts(), ascending.
  const std::vector<int>& held(std::size_t phase) const { return held_[phase]; }
  /// Where a contact stands in the phase's system, nullopt if the phase does not hold it.
  std::optional<int> find(std::size_t phase, int contact) const;
  /// The same of several, nullopt if the phase does not hold all of them.
  std::optional<std::vector<int>> find(std::size_t phase, const std::vector<int>& contacts) const;
  /// The system of a phase: the plant's own there where nothing is held. Phases with the same
  /// contacts share it.
  const std::shared_ptr<const System>& system(std::size_t phase) const { return systems_[phase]; }

 private:
  /// The contacts of a phase, each with the place that kp draws it to there.
  std::vector<Contact> contacts_in(std::size_t phase) const;
  bool set_systems(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                   Diagnostics& out);

  std::vector<Contact> contacts_;
  /// Per phase and at the last node: indices into contacts_, ascending.
  std::vector<std::vector<int>> held_;
  std::vector<std::shared_ptr<const System>> systems_;
  /// Per contact and phase: where kp draws it to.
  std::vector<std::vector<Vector3<double>>> places_;
};

/// The contacts chosen, as indices into the file's; unknown names are reported.
std::vector<int> contacts_named(const ContactNames& names, const ProblemSpec& spec,
                                Diagnostics& out);

/// Whether ë + kd ė + kp e = 0 dies away when integrated with this rule and time step (a constant
/// error without kp counts as that).
bool is_stable(Integrator integrator, double kp, double kd, double dt);

}  // namespace conddp
