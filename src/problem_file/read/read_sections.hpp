#pragma once

#include "problem_file/spec/spec.hpp"
#include "problem_file/spec/spec_gait.hpp"
#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/key_forms.hpp"
#include "problem_file/values/read_state.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Readers of the parts of a problem file. Each fills its structs from a node and reports errors.
/// Values that could not be read keep their defaults; callers check Diagnostics::has_errors() at
/// the end.

// read_robot.cpp, read_actuation.cpp
RobotSpec read_robot(const YamlReader& reader, const std::filesystem::path& folder);
void describe(Keys& keys, RobotSpec& robot);
void describe(Keys& keys, WrenchSpec& wrench);
/// `full`, `none`, or the actuators.
struct ActuationForm {
  bool read(const YamlReader& reader, ActuationSpec& actuation) const;
  std::optional<OrderedJson> expand(const ActuationSpec& actuation) const;
  OrderedJson schema(const ActuationSpec& value, SchemaDefinitions& definitions) const;
};

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
/// Contacts by name; `defaults` is for all.
struct ContactsForm {
  bool read(const YamlReader& reader, std::vector<ContactSpec>& contacts) const;
  std::optional<OrderedJson> expand(const std::vector<ContactSpec>& contacts) const;
  OrderedJson schema(const std::vector<ContactSpec>& value, SchemaDefinitions& definitions) const;
};

// read_collision.cpp
void describe(Keys& keys, CollisionSpec& collision);
void describe(Keys& keys, SphereSpec& sphere);
void describe(Keys& keys, HalfSpaceSpec& half_space);

// read_stepping.cpp
inline constexpr EntriesForm<CandidateSpec> kCandidates{&CandidateSpec::name};
void describe(Keys& keys, CandidateSpec& candidate);
void describe(Keys& keys, SteppingSpec& stepping);
/// `ground`, or a shape.
struct TouchedForm {
  bool read(const YamlReader& reader, TouchedSpec& touched) const;
  std::optional<OrderedJson> expand(const TouchedSpec& touched) const;
  OrderedJson schema(const TouchedSpec& value, SchemaDefinitions& definitions) const;
};

// read_gait.cpp
/// Maximum number of gait cycles.
inline constexpr int kMostGaitCycles = 10'000;
/// Commands in the order of their times. Expanded files have none.
struct CommandsForm {
  bool read(const YamlReader& reader, std::vector<GaitCommand>& commands) const;
  std::optional<OrderedJson> expand(const std::vector<GaitCommand>& /*commands*/) const {
    return std::nullopt;
  }
  OrderedJson schema(const std::vector<GaitCommand>& value, SchemaDefinitions& definitions) const;
};
void describe(Keys& keys, GaitSpec& gait, const std::vector<ContactSpec>& contacts);
GaitSpec read_gait(const YamlReader& reader, const std::vector<ContactSpec>& contacts);

// read_phases.cpp
void describe(Keys& keys, RefineSpec& refine);
void describe(Keys& keys, FreeDurationSpec& free);
/// `spec` is needed to expand the names of all contacts.
void describe(Keys& keys, PhaseSpec& phase, const ProblemSpec* spec);
/// `before_gait`: a gait makes the phases that follow.
std::vector<PhaseSpec> read_phases(const YamlReader& reader, bool before_gait);

// read_mesh.cpp
void describe(Keys& keys, MeshSpec& mesh);
MeshSpec read_mesh(const YamlReader& reader);

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
/// An equilibrium, or a regulator about it.
struct LqrForm {
  bool read(const YamlReader& reader, TerminalLqrSpec& lqr) const;
  std::optional<OrderedJson> expand(const TerminalLqrSpec& lqr) const;
  OrderedJson schema(const TerminalLqrSpec& value, SchemaDefinitions& definitions) const;
};

// read_guess.cpp
void describe(Keys& keys, GuessSpec& guess, const std::filesystem::path& folder);

// read_problem.cpp
void describe(Keys& keys, Perturbation& perturbation);

// read_solver.cpp
void describe(Keys& keys, SolverOptions& options);
void describe(Keys& keys, SolverSpec& solver);

// read_mpc.cpp
void describe(Keys& keys, MpcSpec& mpc, const std::filesystem::path& folder);
/// `solver`: name in the file. By default ipopt, which has no real-time iteration, solves windows
/// to its tolerances.
MpcSpec read_mpc(const YamlReader& reader, const std::filesystem::path& folder, const Name& solver);

}  // namespace conddp
