#pragma once

#include "problem_file/spec/spec.hpp"
#include "problem_file/spec/spec_gait.hpp"
#include "problem_file/values/read_state.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Readers of the parts of a problem file: each fills its structs from a node and reports what is
/// wrong with it. What could not be read keeps its default; callers look at
/// Diagnostics::has_errors() at the end.

// read_robot.cpp, read_actuation.cpp
RobotSpec read_robot(const YamlReader& reader, const std::filesystem::path& folder);
ActuationSpec read_actuation(const YamlReader& reader);

/// What the readers of a file's parts know of the whole.
struct FileContext {
  std::filesystem::path folder;
  ExpressionNamesSpec names;
};

// read_system.cpp
SystemSpec read_system(const YamlReader& reader, const FileContext& file);

// read_expression_system.cpp
void read_expression_system(YamlMap& map, const FileContext& file, ExpressionSystemSpec& system);

// read_library_system.cpp
void read_library_system(YamlMap& map, const std::filesystem::path& folder,
                         LibrarySystemSpec& system);

// read_tables.cpp
std::vector<TableSpec> read_tables(const YamlReader& reader, const std::filesystem::path& folder);

// read_contacts.cpp
std::vector<ContactSpec> read_contacts(const YamlReader& reader);

/// A vector of length 1 along the one given.
std::optional<Vector3<double>> read_direction(const YamlReader& reader);

// read_collision.cpp
CollisionSpec read_collision(const YamlReader& reader);
SphereSpec read_sphere(const YamlReader& reader);
HalfSpaceSpec read_half_space(const YamlReader& reader);

// read_stepping.cpp
std::vector<CandidateSpec> read_candidates(const YamlReader& reader);
SteppingSpec read_stepping(const YamlReader& reader);

TouchedSpec read_touched(const YamlReader& reader);

// read_gait.cpp
/// More cycles than that are an error.
inline constexpr int kMostGaitCycles = 10'000;
/// Under the key `commands`.
std::vector<GaitCommand> read_commands(YamlMap& map);
GaitSpec read_gait(const YamlReader& reader, const std::vector<ContactSpec>& contacts);

// read_phases.cpp
/// More knots than that are an error.
inline constexpr int kMaxKnots = 1'000'000;
std::vector<PhaseSpec> read_phases(const YamlReader& reader);

// read_mesh.cpp
MeshSpec read_mesh(const YamlReader& reader);
/// Cuts each step of the phases that take time; more knots than the mesh allows are an error.
void cut_steps(const MeshSpec& mesh, std::vector<PhaseSpec>& phases, Diagnostics& out);
/// Of a file that collocates, lowers the tolerance of constraints, which the equations of steps
/// are, so far that the error of the mesh is that of its steps.
void tighten_for_mesh(const MeshSpec& mesh, ProblemSpec& spec);

// read_costs.cpp
std::vector<CostSpec> read_costs(const YamlReader& reader, const std::filesystem::path& folder,
                                 bool terminal);
/// Each an expression, or its residual with `rows`, which may leave `residual` out.
std::vector<CostSpec> read_integrals(const YamlReader& reader, const std::filesystem::path& folder);
/// A name or names of phases, at least one.
std::optional<std::vector<Name>> read_phase_names(const YamlReader& reader);
/// Whether the nodes at which its phases end belong to a constraint.
void read_nodes(YamlMap& map, CostSpec& function);
/// The keys that say what a cost or constraint is on, and where: all but weights and activation.
/// False where the residual is not known.
bool read_residual(YamlMap& map, const std::filesystem::path& folder, TermPlace place,
                   CostSpec& cost);

// read_reference.cpp
/// The reference of a cost whose residual and its keys have been read.
std::optional<ReferenceSpec> read_reference(const YamlReader& reader, const CostSpec& cost,
                                            const std::filesystem::path& folder);
/// `{file: ..., columns: [...]}`; the map may have other keys.
std::optional<DataFileSpec> read_data_file(YamlMap& map, const std::filesystem::path& folder);

// read_constraints.cpp
/// Into the spec's control_bounds and constraints, or its terminal_constraints.
void read_constraints(const YamlReader& reader, const std::filesystem::path& folder, bool terminal,
                      ProblemSpec& spec);

// read_terminal_lqr.cpp
TerminalLqrSpec read_terminal_lqr(const YamlReader& reader);

// read_guess.cpp
GuessSpec read_guess(const YamlReader& reader, const std::filesystem::path& folder);

// read_solver.cpp
SolverSpec read_solver(const YamlReader& reader);

// read_mpc.cpp
/// `solver`: the name that the file gives; ipopt, which has no real-time iteration, solves windows
/// to the tolerances unless the section says otherwise.
MpcSpec read_mpc(const YamlReader& reader, const std::filesystem::path& folder, const Name& solver);

}  // namespace conddp
