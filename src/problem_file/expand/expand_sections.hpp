#pragma once

#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"
#include "problem_file/values/expand_values.hpp"

namespace conddp {

/// Expanders of the parts of a problem file, one for each reader in read_sections.hpp. Each returns
/// JSON that its reader reads as the same spec, with defaults written out.

// expand_system.cpp
OrderedJson expand_system(const SystemSpec& system);
OrderedJson expand_parameters(const NamedParameters& parameters);
OrderedJson expand_tables(const std::vector<TableSpec>& tables);

// expand_costs.cpp
OrderedJson expand_costs(const std::vector<CostSpec>& costs, const ProblemSpec& spec,
                         const Plant& plant, bool terminal);
OrderedJson expand_constraints(const ProblemSpec& spec, const Plant& plant);
OrderedJson expand_terminal_constraints(const ProblemSpec& spec, const Plant& plant);
/// The phases named, by default all phases that take time.
OrderedJson expand_phase_names(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec);

// expand_reference.cpp
/// Null for a cost without a reference.
OrderedJson expand_reference(const CostSpec& cost);

// expand_core.cpp
/// The problem that solvers see: states, and for each phase its step, costs, constraints and
/// bounds.
OrderedJson expand_core(const BuiltProblem& built);

// expand_mpc.cpp
/// The spec must have the section.
OrderedJson expand_mpc(const ProblemSpec& spec, const Plant& plant);

}  // namespace conddp
