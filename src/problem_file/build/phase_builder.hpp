#pragma once

#include "problem_file/build/state_tail.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/terms/terminal_lqr.hpp"

namespace conddp {

/// Bounds on the control, phase by phase; infinite where there is none.
struct PhaseBounds {
  std::vector<std::vector<double>> lower, upper;
};

/// The bounds of one constraint; phases that it does not name have none, and phases without one of
/// its controls those on the others.
std::optional<PhaseBounds> build_control_bounds(const ControlBoundsSpec& constraint,
                                                const ProblemSpec& spec, const Plant& plant,
                                                Diagnostics& out);
PhaseBounds unbounded(const ProblemSpec& spec, const Plant& plant);
/// Narrows bounds by others; an empty interval is reported at `name`.
void intersect(const PhaseBounds& other, const Name& name, const Plant& plant, PhaseBounds& bounds,
               Diagnostics& out);

/// How knot models are made from a problem's costs.
struct PhaseContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const ContactPlan& contacts;
  std::shared_ptr<const System> system;  ///< of the last node
  Integrator integrator;
  const std::vector<NodeTime>& times;  ///< of all nodes
  /// Where steps are contact-implicit: adds what they have to obey.
  std::shared_ptr<const SteppingSystem> stepping;
  /// Whether the integrator collocates, so that slopes of its stages have something to obey.
  bool collocates;
  StateTail tail;

  /// Free duration with which the running costs of a phase grow.
  std::optional<FreeDuration> cost_growth(std::size_t phase) const {
    return spec.costs_are_rates() ? tail.duration(phase) : std::nullopt;
  }
  /// Columns of that duration.
  std::optional<DurationColumn> cost_duration(std::size_t phase) const {
    const std::optional<FreeDuration> free = cost_growth(phase);
    if (!free) return std::nullopt;
    return DurationColumn{system->nx() + free->choice, system->ndx() + free->choice, free->written};
  }
};

/// What stands in the knots of a problem. Vectors that are left out are empty.
struct KnotContents {
  const std::vector<BuiltCost>& costs;
  const std::vector<BuiltConstraint>& constraints;
  const std::vector<BuiltCost>& integrals;
};

/// The phases of a problem. Phases with the same costs, constraints and bounds share one KnotModel;
/// within a phase a cost that is off at a knot has weight 0 there, a constraint its switch off.
std::vector<Phase> build_phases(const PhaseContext& context, const KnotContents& contents,
                                const PhaseBounds& bounds, Diagnostics& out);
/// The last node with its costs and constraints, with the running costs on swings that end there
/// and the running constraints that hold there too. Contacts that a cost names and the node does
/// not hold are reported. `lqr`: what the file's `terminal: {lqr: ...}` stands for, or null.
Phase build_terminal(const PhaseContext& context, const KnotContents& running,
                     const KnotContents& terminal, const TerminalLqr* lqr, Diagnostics& out);

/// Constraints on the initial state alone cannot be influenced: checks those that are hard, and
/// switches them off.
void settle_initial_state(const std::vector<double>& initial_state,
                          const std::vector<BuiltConstraint>& constraints, double tolerance,
                          std::vector<Phase>& phases, Diagnostics& out);

}  // namespace conddp
