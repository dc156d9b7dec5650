#pragma once

#include "problem_file/assemble/state_tail.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/terms/terminal_lqr.hpp"

namespace conddp {

/// Bounds on the control, phase by phase; infinite if unbounded.
struct PhaseBounds {
  std::vector<std::vector<double>> lower, upper;
};

/// Bounds of one constraint. Phases that it does not name are unbounded; in phases without some of
/// its controls, it bounds the others.
std::optional<PhaseBounds> build_control_bounds(const ConstraintSpec& constraint,
                                                const ProblemSpec& spec, const Plant& plant,
                                                Diagnostics& out);
PhaseBounds unbounded(const ProblemSpec& spec, const Plant& plant);
/// Narrows `bounds` by `other`; reports an empty interval at `name`.
void intersect(const PhaseBounds& other, const Name& name, const Plant& plant, PhaseBounds& bounds,
               Diagnostics& out);

/// Inputs for building knot models from a problem's terms.
struct PhaseContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const ContactPlan& contacts;
  std::shared_ptr<const System> system;  ///< of the last node
  Integrator integrator;
  const std::vector<NodeTime>& times;  ///< of all nodes
  /// System of contact-implicit steps, whose equations are added as constraints; else null.
  std::shared_ptr<const SteppingSystem> stepping;
  /// True if the integrator collocates, so that the slopes of its stages need collocation
  /// equations.
  bool collocates;
  StateTail tail;

  /// Free duration that scales the running costs of a phase.
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

/// Terms in the knots of a problem; any of the lists may be empty.
struct KnotContents {
  const std::vector<BuiltCost>& costs;
  const std::vector<BuiltConstraint>& constraints;
  const std::vector<BuiltCost>& integrals;
};

/// Builds the phases of a problem. Phases with the same costs, constraints and bounds share one
/// KnotModel. Within a phase, an inactive cost has weight 0 at a knot, and an inactive constraint
/// is switched off.
std::vector<Phase> build_phases(const PhaseContext& context, const KnotContents& contents,
                                const PhaseBounds& bounds, Diagnostics& out);
/// Builds the last node with its own terms, the running costs on swings that end there, and the
/// running constraints that also hold there. Reports contacts that a cost names and the node does
/// not hold. `lqr`: terminal cost of the file's `terminal: {lqr: ...}`, or null.
Phase build_terminal(const PhaseContext& context, const KnotContents& running,
                     const KnotContents& terminal, const TerminalLqr* lqr, Diagnostics& out);

/// Checks the hard constraints on the initial state alone, which no control can influence, and
/// switches off all such constraints.
void settle_initial_state(const std::vector<double>& initial_state,
                          const std::vector<BuiltConstraint>& constraints, double tolerance,
                          std::vector<Phase>& phases, Diagnostics& out);

}  // namespace conddp
