#include "analysis/contact/contact_motion.hpp"

#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// Components along the normal and the tangents.
Eigen::Vector3d force_of(const SteppingLayout::Candidate& at, const Eigen::VectorXd& w) {
  Eigen::Vector3d force(w[at.force], 0, 0);
  for (int i = 0; i < at.friction.count; i += 2)
    force[1 + i / 2] = w[at.friction.force[i]] - w[at.friction.force[i + 1]];
  for (int i = 0; at.cone.present && i < 2; ++i) force[1 + i] = w[at.cone.force[i]];
  return force;
}

/// Extracts the forces from the controls of a step.
StepForces forces_of(const SteppingSystem& system, const Eigen::VectorXd& w) {
  const SteppingLayout& layout = system.layout();
  const ImplicitContacts& contacts = system.contacts();
  StepForces forces(contacts);
  for (std::size_t c = 0; c < layout.candidates.size(); ++c)
    forces.contact.col(c) = force_of(layout.candidates[c], w);
  for (const SteppingLayout::Stop& stop : layout.stops)
    for (std::size_t s = 0; s < contacts.stops.size(); ++s)
      if (contacts.stops[s].joint == stop.joint)
        (stop.upper ? forces.stop_upper : forces.stop_lower)[s] = w[stop.force];
  for (std::size_t f = 0; f < layout.frictions.size(); ++f)
    forces.friction[f] = w[layout.frictions[f].force[0]] - w[layout.frictions[f].force[1]];
  return forces;
}

}  // namespace

std::optional<ContactMotion> contact_motion(const ShootingProblem& problem,
                                            const Trajectory& trajectory) {
  const int first = problem.phases().front().instant ? 1 : 0;
  const KnotModel& model = *problem.knot(first).model;
  const auto* system = model.system().as_stepping();
  if (system == nullptr) return std::nullopt;
  ContactMotion motion;
  motion.first_knot = first;
  motion.plant = contact_plant(system->multibody(), system->contacts());
  const int nq = system->nq(), nv = system->nv(), actuators = system->layout().actuators;
  const auto bounds = [&](const auto& all) {
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(all.data(), actuators));
  };
  motion.u_lower = bounds(model.control_lower());
  motion.u_upper = bounds(model.control_upper());
  for (int k = first; k <= problem.knots(); ++k) {
    motion.q.push_back(trajectory.x(k).head(nq));
    motion.v.push_back(trajectory.x(k).segment(nq, nv));
    if (k == problem.knots()) break;
    motion.h.push_back(
        problem.knot(k).model->step().time_step(problem.knot(k).dt, trajectory.x(k).data()));
    motion.u.push_back(trajectory.u(k).head(actuators));
    motion.forces.push_back(forces_of(*system, trajectory.u(k)));
  }
  return motion;
}

}  // namespace conddp
