#pragma once

#include "problem_file/cost_builder.hpp"

namespace conddp {

/// Bounds on the control, phase by phase; infinite where there is none.
struct PhaseBounds {
  std::vector<std::vector<double>> lower, upper;
};

/// The bounds of one constraint; phases that it does not name have none.
std::optional<PhaseBounds> build_control_bounds(const ControlBoundsSpec& constraint,
                                                const ProblemSpec& spec, const Plant& plant,
                                                Diagnostics& out);
PhaseBounds unbounded(const ProblemSpec& spec, const Plant& plant);
/// Narrows bounds by others; an empty interval is reported at `name`.
void intersect(const PhaseBounds& other, const Name& name, const Plant& plant, PhaseBounds& bounds,
               Diagnostics& out);

/// The indices of the phases named, all if nothing is named; unknown names are reported.
std::vector<bool> phases_named(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec, Diagnostics& out);

/// How knot models are made from a problem's costs.
struct PhaseContext {
  const ProblemSpec& spec;
  const ContactPlan& contacts;
  std::shared_ptr<const System> system;  ///< of the last node
  Integrator integrator;
  bool control_memory;
  const std::vector<double>& times;  ///< of all nodes, s
};

/// The phases of a problem. Phases with the same costs and bounds share one KnotModel; within a
/// phase a cost that is off at a knot has weight 0 there.
std::vector<Phase> build_phases(const PhaseContext& context, const std::vector<BuiltCost>& costs,
                                const PhaseBounds& bounds, Diagnostics& out);
/// The last node with its costs, and with the running ones on swings that end there. Contacts that
/// a cost names and the node does not hold are reported.
Phase build_terminal(const PhaseContext& context, const std::vector<BuiltCost>& running,
                     const std::vector<BuiltCost>& terminal_costs, Diagnostics& out);

}  // namespace conddp
