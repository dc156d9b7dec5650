#pragma once

#include "base/json/ordered_json.hpp"
#include "problem_file/plant/plant.hpp"
#include "problem_file/values/expand_values.hpp"

namespace conddp {

/// Expanders of the parts of a problem file, one for each reader in read_sections.hpp. Each returns
/// JSON that its reader reads as the same spec, with defaults written out.

// expand_robot.cpp
OrderedJson expand_robot(const RobotSpec& robot);

// expand_system.cpp
OrderedJson expand_system(const SystemSpec& system);
OrderedJson expand_parameters(const NamedParameters& parameters);
OrderedJson expand_tables(const std::vector<TableSpec>& tables);

// expand_contacts.cpp
OrderedJson expand_contacts(const std::vector<ContactSpec>& contacts);

// expand_collision.cpp
OrderedJson expand_collision(const CollisionSpec& collision);
OrderedJson expand_form(const SphereSpec& sphere);
OrderedJson expand_form(const HalfSpaceSpec& half_space);

// expand_stepping.cpp
OrderedJson expand_touched(const TouchedSpec& touched);
OrderedJson expand_candidates(const std::vector<CandidateSpec>& candidates);
OrderedJson expand_stepping(const SteppingSpec& stepping);

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

// expand_guess.cpp
OrderedJson expand_guess(const GuessSpec& guess);

// expand_problem.cpp
OrderedJson expand_terminal_lqr(const TerminalLqrSpec& lqr);

// expand_mpc.cpp
/// The spec must have the section.
OrderedJson expand_mpc(const ProblemSpec& spec, const Plant& plant);

}  // namespace conddp
