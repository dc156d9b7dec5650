#include "problem_file/assemble/state_tail.hpp"

namespace conddp {

std::optional<FreeDuration> StateTail::duration(std::size_t phase) const {
  std::optional<FreeDuration> free = start ? start->durations[phase] : std::nullopt;
  if (free) free->choice += integrals;
  return free;
}

Step StateTail::step(std::shared_ptr<const System> system, Integrator integrator) const {
  Step step(std::move(system), integrator);
  step.hold(held());
  if (controls == HeldControls::previous) step.remember_controls(0, actuators);
  if (linear()) step.make_controls_linear();
  return step;
}

Step StateTail::instant(std::shared_ptr<const System> system, Integrator integrator) const {
  return Step(std::move(system), integrator).hold(size());
}

/// The last choices are the held controls if these are free.
Step StateTail::choice() const {
  const int chosen = start->system->nu();
  Step step(start->system, Integrator::explicit_euler);
  step.hold(integrals);
  if (start->remembered) step.remember_controls(0, chosen);
  if (controls == HeldControls::none || start->first_controls > 0) return step;
  return start->previous_controls > 0 ? step.remember_controls(chosen - actuators, actuators)
                                      : step.hold(actuators);
}

std::vector<Column> StateTail::columns(const std::vector<CostSpec>& sums,
                                       const std::vector<Column>& actuated) const {
  std::vector<Column> columns;
  for (const CostSpec& integral : sums) columns.push_back({integral.name.value, "1"});
  for (int i = 0; start != nullptr && i < start->carried(); ++i) {
    const Column& chosen = start->system->control_columns()[i];
    columns.push_back({"start/" + chosen.name, chosen.unit});
  }
  if (controls == HeldControls::none) return columns;
  for (const Column& control : actuated)
    columns.push_back({(linear() ? "" : "previous/") + control.name, control.unit});
  return columns;
}

std::vector<double> StateTail::written() const {
  std::vector<double> values(size(), 0.0);
  for (std::size_t p = 0; start != nullptr && p < start->durations.size(); ++p)
    if (const auto free = duration(p)) values[free->choice] = free->written;
  return values;
}

}  // namespace conddp
