#include "output/mpc/plant_forces.hpp"

#include <cmath>

namespace conddp {
namespace {

/// The problem whose systems move the plant at a given time.
const ShootingProblem& moving_problem(const LoopTask& task, double time) {
  const PlantPeriod* period = period_at(task.mpc.loop.plant, time);
  return period != nullptr && period->problem ? *period->problem : *task.built.problem;
}

void copy_forces(const std::vector<double>& found, int row, ContactForces& to) {
  for (std::size_t c = 0; c < to.contacts.size() && 3 * c < found.size(); ++c)
    if (const double* f = found.data() + 3 * c; !std::isnan(f[0]))
      to.contacts[c].wrench[row] = {f[0], f[1], f[2], 0, 0, 0};
}

}  // namespace

ContactForces no_plant_forces(const LoopTask& task, int rows) {
  ContactForces forces = no_contact_forces(*task.spec, rows);
  for (ContactForces::OfContact& contact : forces.contacts) contact.torque = false;
  return forces;
}

ContactForces plant_forces(const LoopTask& task, const ClosedLoopResult& result) {
  const int rows = static_cast<int>(result.steps.size());
  ContactForces forces = no_plant_forces(task, rows);
  if (forces.contacts.empty()) return forces;
  const TimeLine line(task.built.problem, task.mpc.controller.hold);
  ContactForceWriter writer;
  for (int row = 0; row < rows; ++row) {
    const PlantStep& step = result.steps[row];
    if (!step.contact_forces.empty()) {
      copy_forces(step.contact_forces, row, forces);
      continue;
    }
    const ShootingProblem& problem = moving_problem(task, step.time);
    writer.write(problem.knot(line.at(step.time).knot).model->system(), step.x.data(),
                 step.u.data(), row, forces);
  }
  return forces;
}

}  // namespace conddp
