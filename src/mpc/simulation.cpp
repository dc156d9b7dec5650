#include "mpc/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

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

/// Copies a model without its costs and constraints.
KnotModel bare_model(const KnotModel& like, Integrator integrator) {
  KnotModel model(like.shared_system(), integrator, like.control_memory(), like.carried_numbers());
  for (const IntegralTerm& term : like.integrals())
    model.add_integral(term.name, term.residual, term.number);
  return model;
}

}  // namespace

Simulation::Stepper::Stepper(const KnotModel& like, Integrator integrator)
    : model(bare_model(like, integrator)),
      work(std::make_unique<KnotWorkspace<double>>(model)),
      x(model.nx(), 0.0),
      u(model.nu(), 0.0),
      parameters(model.parameter_count(), 0.0) {}

void Simulation::Stepper::read_integrals(const KnotView& knot) {
  const std::vector<IntegralTerm>&own = model.integrals(), &given = knot.model->integrals();
  for (std::size_t i = 0; i < own.size(); ++i)
    std::copy_n(knot.parameters + given[i].parameters, own[i].residual->parameter_count(),
                parameters.begin() + own[i].parameters);
}

Simulation::Simulation(const TimeLine& line, const StepRule& rule) : line_(line), rule_(rule) {
  const ShootingProblem& problem = line.problem();
  // Knots with integrals have steppers of their own model.
  std::map<std::tuple<const System*, Integrator, const KnotModel*>, int> known;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    Integrator integrator = model.integrator();
    if (rule.integrator && !problem.takes_no_time(k)) integrator = *rule.integrator;
    if (!problem.takes_no_time(k)) check(integrator, model.system());
    const auto [entry, is_new] = known.try_emplace(
        {&model.system(), integrator, model.integrals().empty() ? nullptr : &model},
        static_cast<int>(steppers_.size()));
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

void Simulation::move(int knot, double length, const double* u, double* x) {
  Stepper& stepper = *steppers_[stepper_of_[knot]];
  stepper.read_integrals(line_.problem().knot(knot));
  std::copy_n(x, stepper.x.size(), stepper.x.begin());
  if (u != nullptr) std::copy_n(u, stepper.u.size(), stepper.u.begin());
  stepper.model.evaluate(
      KnotInput<double>{stepper.x.data(), stepper.u.data(), stepper.parameters.data(), length, 1.0},
      *stepper.work);
  std::copy_n(stepper.work->next().begin(), stepper.x.size(), x);
}

void Simulation::pass_instants(double time, double* x) {
  const auto [first, end] = line_.instants_at(time);
  for (int k = first; k < end; ++k) move(k, 0, nullptr, x);
}

void Simulation::step(double time, double length, const double* u, double* x) {
  const TimedKnot at = line_.at(time);
  const double dt = line_.problem().knot(at.knot).dt;
  // A step over a whole knot equals the knot's own to the last digit.
  if (std::abs(length - dt) < kSameTime) length = dt;
  move(at.knot, length, u, x);
}

}  // namespace conddp
