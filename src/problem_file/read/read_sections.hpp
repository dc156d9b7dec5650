#pragma once

#include "problem_file/spec/spec.hpp"
#include "problem_file/spec/spec_gait.hpp"
#include "problem_file/values/read_state.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Readers of the parts of a problem file. Each fills its structs from a node and reports errors.
/// Values that could not be read keep their defaults; callers check Diagnostics::has_errors() at
/// the end.

// read_robot.cpp, read_actuation.cpp
RobotSpec read_robot(const YamlReader& reader, const std::filesystem::path& folder);
ActuationSpec read_actuation(const YamlReader& reader);

/// Properties of the file that readers of its parts need.
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

/// A unit vector along the given vector.
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
/// Maximum number of gait cycles.
inline constexpr int kMostGaitCycles = 10'000;
/// Reads the key `commands`.
std::vector<GaitCommand> read_commands(YamlMap& map);
GaitSpec read_gait(const YamlReader& reader, const std::vector<ContactSpec>& contacts);

// read_phases.cpp
/// Maximum number of knots.
inline constexpr int kMaxKnots = 1'000'000;
std::vector<PhaseSpec> read_phases(const YamlReader& reader);

// read_mesh.cpp
MeshSpec read_mesh(const YamlReader& reader);
/// Subdivides each step of the phases that take time; exceeding the mesh's knot limit is an error.
void cut_steps(const MeshSpec& mesh, std::vector<PhaseSpec>& phases, Diagnostics& out);
/// With collocation, lowers the constraint tolerance, which also applies to the equations of the
/// steps, so far that the error of the mesh is that of its steps.
void tighten_for_mesh(const MeshSpec& mesh, ProblemSpec& spec);

// read_costs.cpp
std::vector<CostSpec> read_costs(const YamlReader& reader, const std::filesystem::path& folder,
                                 bool terminal);
/// Each integral is an expression, or a residual with `rows`, whose key `residual` is optional.
std::vector<CostSpec> read_integrals(const YamlReader& reader, const std::filesystem::path& folder);
/// A name or names of phases, at least one.
std::optional<std::vector<Name>> read_phase_names(const YamlReader& reader);
/// Reads whether a constraint also applies to the nodes at the end of its phases.
void read_nodes(YamlMap& map, CostSpec& function);
/// Reads the keys that define the function of a cost or constraint and where it applies: all except
/// weights and activation. False for an unknown residual.
bool read_residual(YamlMap& map, const std::filesystem::path& folder, TermPlace place,
                   CostSpec& cost);

// read_reference.cpp
/// The reference of a cost whose residual and keys have been read.
std::optional<ReferenceSpec> read_reference(const YamlReader& reader, const CostSpec& cost,
                                            const std::filesystem::path& folder);
/// `{file: ..., columns: [...]}`; the map may have other keys.
std::optional<DataFileSpec> read_data_file(YamlMap& map, const std::filesystem::path& folder);

// read_constraints.cpp
/// Adds to the spec's control_bounds and constraints, or to its terminal_constraints.
void read_constraints(const YamlReader& reader, const std::filesystem::path& folder, bool terminal,
                      ProblemSpec& spec);

// read_terminal_lqr.cpp
TerminalLqrSpec read_terminal_lqr(const YamlReader& reader);

// read_guess.cpp
GuessSpec read_guess(const YamlReader& reader, const std::filesystem::path& folder);

// read_solver.cpp
SolverSpec read_solver(const YamlReader& reader);

// read_mpc.cpp
/// `solver`: name in the file. By default ipopt, which has no real-time iteration, solves windows
/// to its tolerances.
MpcSpec read_mpc(const YamlReader& reader, const std::filesystem::path& folder, const Name& solver);

}  // namespace conddp
