#include "mpc/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace conddp {
namespace {

void check(Integrator integrator, const System& system) {
  const StepKind kind = kIntegrators[static_cast<int>(integrator)].kind;
  const bool discrete = system.kind() == SystemKind::discrete;
  if (discrete != (kind == StepKind::given) || kind == StepKind::none ||
      kind == StepKind::collocation)
    throw std::invalid_argument("the integrator does not serve the system");
  if (kind == StepKind::semi_implicit && system.kind() != SystemKind::second_order)
    throw std::invalid_argument("semi-implicit Euler needs positions and velocities");
}

}  // namespace

Simulation::Stepper::Stepper(const KnotModel& like, Integrator integrator)
    : model(like.shared_system(), integrator, like.control_memory()),
      work(std::make_unique<KnotWorkspace<double>>(model)),
      x(model.nx(), 0.0),
      u(model.nu(), 0.0) {}

Simulation::Simulation(const TimeLine& line, const StepRule& rule) : line_(line), rule_(rule) {
  const ShootingProblem& problem = line.problem();
  std::map<std::pair<const System*, Integrator>, int> known;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    Integrator integrator = model.integrator();
    if (rule.integrator && !problem.takes_no_time(k)) integrator = *rule.integrator;
    if (!problem.takes_no_time(k)) check(integrator, model.system());
    const auto [entry, is_new] =
        known.try_emplace({&model.system(), integrator}, static_cast<int>(steppers_.size()));
    if (is_new) steppers_.push_back(std::make_unique<Stepper>(model, integrator));
    stepper_of_.push_back(entry->second);
  }
}

double Simulation::next_stop(double time) const {
  const double end = line_.at(time).end;
  const double own =
      is_before(time, end) ? end : time + line_.problem().knot(line_.at(time).knot).dt;
  return rule_.dt ? std::min(own, time + *rule_.dt) : own;
}

void Simulation::move(Stepper& stepper, double length, const double* u, double* x) {
  std::copy_n(x, stepper.x.size(), stepper.x.begin());
  if (u != nullptr) std::copy_n(u, stepper.u.size(), stepper.u.begin());
  stepper.model.evaluate(
      KnotInput<double>{stepper.x.data(), stepper.u.data(), nullptr, length, 1.0}, *stepper.work);
  std::copy_n(stepper.work->next().begin(), stepper.x.size(), x);
}

void Simulation::pass_instants(double time, double* x) {
  const auto [first, end] = line_.instants_at(time);
  for (int k = first; k < end; ++k) move(*steppers_[stepper_of_[k]], 0, nullptr, x);
}

void Simulation::step(double time, double length, const double* u, double* x) {
  const TimedKnot at = line_.at(time);
  const double dt = line_.problem().knot(at.knot).dt;
  // A whole knot's step is the knot's own to the last digit.
  if (std::abs(length - dt) < kSameTime) length = dt;
  move(*steppers_[stepper_of_[at.knot]], length, u, x);
}

}  // namespace conddp
