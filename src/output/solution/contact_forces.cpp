#include "output/solution/contact_forces.hpp"

#include <map>
#include <memory>

#include "systems/multibody/multibody.hpp"

namespace conddp {

namespace {

void set_wrench(const std::string& name, int knot, const Force<double>& f, ContactForces& forces) {
  for (ContactForces::OfContact& contact : forces.contacts)
    if (contact.name == name) contact.wrench[knot] = {f[0], f[1], f[2], f[3], f[4], f[5]};
}

}  // namespace

ContactForces contact_forces(const ProblemSpec& spec, const ShootingProblem& problem,
                             const Trajectory& trajectory) {
  ContactForces forces;
  for (const ContactSpec& named : spec.contacts) {
    auto& contact = forces.contacts.emplace_back();
    contact.name = named.name.value;
    contact.torque = named.kind == ContactKind::surface;
    contact.wrench.resize(problem.knots());
  }
  std::map<const System*, std::unique_ptr<SystemData<double>>> memory;
  for (int k = 0; k < problem.knots() && !forces.contacts.empty(); ++k) {
    const auto* system = problem.knot(k).model->system().as_multibody();
    if (system == nullptr || system->contacts().empty()) continue;
    auto& data = memory[system];
    if (!data) data = system->create_data(double{});
    system->evaluate(trajectory.x(k).data(), trajectory.u(k).data(), *data);
    const auto& held = static_cast<const MultibodySystem::Data<double>&>(*data).contacts.contacts;
    for (int i = 0; i < system->contacts().count(); ++i)
      set_wrench(system->contacts().contacts()[i].name, k, contact_force_in_world(held[i]), forces);
  }
  return forces;
}

}  // namespace conddp
