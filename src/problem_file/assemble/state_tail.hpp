#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/step/step.hpp"
#include "problem_file/assemble/initial_choice.hpp"
#include "problem_file/model/spec.hpp"

namespace conddp {

/// Controls that states hold.
enum class HeldControls {
  none,
  previous,  ///< control of the previous knot
  linear,    ///< control at the node, linear in time up to the next node
};

/// Numbers after the system's state at all nodes of a problem, in this order: integrals, choices of
/// the start, controls.
struct StateTail {
  HeldControls controls = HeldControls::none;
  int actuators = 0;
  int integrals = 0;
  const InitialChoice* start = nullptr;  ///< null if the initial state is given

  /// Number of integrals and choices.
  int held() const { return integrals + (start ? start->carried() : 0); }
  int size() const { return held() + (controls == HeldControls::none ? 0 : actuators); }
  bool linear() const { return controls == HeldControls::linear; }
  /// Free duration of a phase, with its index in the tail.
  std::optional<FreeDuration> duration(std::size_t phase) const;

  /// Step of a knot that takes time, or of the last node (Integrator::none).
  Step step(std::shared_ptr<const System> system, Integrator integrator) const;
  /// Step of an instantaneous knot, which passes the tail on.
  Step instant(std::shared_ptr<const System> system, Integrator integrator) const;
  /// Step that chooses the start.
  Step choice() const;
  /// Columns of the tail: of integrals named as `sums`, of choices and of `actuated` controls.
  std::vector<Column> columns(const std::vector<CostSpec>& sums,
                              const std::vector<Column>& actuated) const;
  /// Values of the tail: durations as the file writes them, 0 otherwise.
  std::vector<double> written() const;
};

}  // namespace conddp
