#include "output/solution/contact_forces.hpp"

#include <span>

#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

void set_wrench(const std::string& name, int knot, const Force<double>& f, ContactForces& forces) {
  for (ContactForces::OfContact& contact : forces.contacts)
    if (contact.name == name) contact.wrench[knot] = {f[0], f[1], f[2], f[3], f[4], f[5]};
}

}  // namespace

ContactForces no_contact_forces(const BuiltProblem& built, int rows) {
  ContactForces forces;
  for (const ContactSpec& named : built.facts().contacts) {
    auto& contact = forces.contacts.emplace_back();
    contact.name = named.name.value;
    contact.torque = named.kind == ContactKind::surface;
    contact.wrench.resize(rows);
  }
  return forces;
}

void ContactForceWriter::write(const System& system, const double* x, const double* u, int row,
                               ContactForces& to) {
  const MultibodySystem* robot = system.as_multibody();
  if (robot == nullptr || robot->contacts().empty()) return;
  auto& data = memory_[robot];
  if (!data) data = robot->create_data(double{});
  robot->evaluate(x, u, *data);
  const auto& held = static_cast<const MultibodySystem::Data<double>&>(*data).contacts.contacts;
  for (int i = 0; i < robot->contacts().count(); ++i)
    set_wrench(robot->contacts().contacts()[i].name, row, contact_force_in_world(held[i]), to);
}

ContactForces contact_forces(const BuiltProblem& built, const NodeValues& values) {
  const ShootingProblem& problem = *built.problem;
  ContactForces forces = no_contact_forces(built, problem.knots());
  for (int k = 0; k < problem.knots(); ++k) {
    const std::span<const HeldContact> held = values.contacts(k);
    if (held.empty()) continue;
    const ContactSet& contacts = problem.knot(k).model->system().as_multibody()->contacts();
    for (std::size_t i = 0; i < held.size(); ++i)
      set_wrench(contacts.contacts()[i].name, k, held[i].force, forces);
  }
  return forces;
}

}  // namespace conddp
