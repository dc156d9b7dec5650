#include "mpc/plant_motion.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

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

Simulation::Stepper::Stepper(Step rule)
    : step(std::move(rule)), work(step), x(step.nx(), 0.0), u(step.nu(), 0.0) {}

Simulation::Simulation(const TimeLine& line, const StepRule& rule) : line_(line), rule_(rule) {
  const ShootingProblem& problem = line.problem();
  // Knots with integrals have steppers of their own model.
  std::map<std::tuple<const System*, Integrator, const Step*>, int> known;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    Integrator integrator = model.integrator();
    if (rule.integrator && !problem.takes_no_time(k)) integrator = *rule.integrator;
    if (!problem.takes_no_time(k)) check(integrator, model.system());
    const auto [entry, is_new] = known.try_emplace(
        {&model.system(), integrator, model.step().integrals().empty() ? nullptr : &model.step()},
        static_cast<int>(steppers_.size()));
    if (is_new) steppers_.push_back(std::make_unique<Stepper>(model.step().with(integrator)));
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
  std::copy_n(x, stepper.x.size(), stepper.x.begin());
  if (u != nullptr) std::copy_n(u, stepper.u.size(), stepper.u.begin());
  const StepInput<double> in{stepper.x.data(), stepper.u.data(),
                             line_.problem().knot(knot).parameters, length};
  stepper.step.begin(in, stepper.work, false);
  stepper.step.take(in, stepper.work, false);
  std::copy_n(stepper.work.next().begin(), stepper.x.size(), x);
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

const PlantPeriod* period_at(std::span<const PlantPeriod> periods, double time) {
  const PlantPeriod* current = nullptr;
  for (const PlantPeriod& period : periods)
    if (current == nullptr || !is_before(time, period.from)) current = &period;
  return current;
}

PlantMotions::PlantMotions(std::span<const PlantPeriod> periods, const StepRule& step,
                           const TimeLine& model) {
  if (periods.empty()) add(0, std::make_shared<Simulation>(model, step));
  for (const PlantPeriod& period : periods) {
    if (period.motion != nullptr) {
      add(period.from, period.motion);
      continue;
    }
    const ShootingProblem& problem = *period.problem;
    if (problem.times() != model.problem().times() || problem.nx() != model.problem().nx())
      throw std::invalid_argument("the plant has other states or times than the model");
    lines_.push_back(std::make_unique<TimeLine>(period.problem, model.is_held()));
    add(period.from, std::make_shared<Simulation>(*lines_.back(), step));
  }
  if (begins_.front() > 0) throw std::invalid_argument("the plant's first period begins at time 0");
}

PlantMotion& PlantMotions::at(double time) const {
  std::size_t current = 0;
  for (std::size_t i = 1; i < begins_.size(); ++i)
    if (!is_before(time, begins_[i])) current = i;
  return *motions_[current];
}

void PlantMotions::add(double from, std::shared_ptr<PlantMotion> motion) {
  begins_.push_back(from);
  motions_.push_back(std::move(motion));
}

}  // namespace conddp
