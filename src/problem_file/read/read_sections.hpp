#pragma once

#include "problem_file/model/spec.hpp"
#include "problem_file/model/spec_gait.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

/// Descriptions of the parts of a problem file and forms of their values. Reading fills structs and
/// reports errors; values that could not be read keep their defaults, and callers check
/// Diagnostics::has_errors() at the end.

// problem_keys.cpp
void describe(Keys& keys, ProblemSpec& spec);

// read_robot.cpp, read_actuation.cpp
void describe(Keys& keys, RobotSpec& robot);
void describe(Keys& keys, FrameSpec& frame);
void describe(Keys& keys, WrenchSpec& wrench);
/// `full`, `none`, or the actuators.
struct ActuationForm {
  bool read(const YamlReader& reader, ActuationSpec& actuation) const;
  std::optional<OrderedJson> expand(const ActuationSpec& actuation) const;
  OrderedJson schema(const ActuationSpec& value, SchemaDefinitions& definitions) const;
};

// read_system.cpp
void describe(Keys& keys, SystemSpec& system);
/// A system of the type with this index in kSystemTypes, with the type's default parameters.
SystemSpec default_system(std::size_t type);
/// A system of any type; `names` are those of the file.
struct SystemForm {
  const ExpressionNamesSpec& names;
  bool read(const YamlReader& reader, SystemSpec& system) const;
  std::optional<OrderedJson> expand(const SystemSpec& system) const { return expand_map(system); }
  OrderedJson schema(const SystemSpec& value, SchemaDefinitions& definitions) const;
};

// read_own_system.cpp
void describe_parameters(Keys& keys, ExpressionSystemSpec& system);
void describe_parameters(Keys& keys, LibrarySystemSpec& system);
/// Parses the expressions of a system that has been read, or loads its library.
void settle_own_system(const YamlReader& reader, const ExpressionNamesSpec& names,
                       SystemSpec& system);

// read_tables.cpp
void describe(Keys& keys, TableSpec& table);
struct TablesForm : EntriesForm<TableSpec> {
  TablesForm();
  OrderedJson schema(const std::vector<TableSpec>& value, SchemaDefinitions& definitions) const;
};

// read_contacts.cpp
/// Contacts by name; `defaults` is for all.
struct ContactsForm {
  bool read(const YamlReader& reader, std::vector<ContactSpec>& contacts) const;
  std::optional<OrderedJson> expand(const std::vector<ContactSpec>& contacts) const;
  OrderedJson schema(const std::vector<ContactSpec>& value, SchemaDefinitions& definitions) const;
};

// read_collision.cpp
void describe(Keys& keys, LoopSpec& loop);
void describe(Keys& keys, CollisionSpec& collision);
void describe(Keys& keys, SphereSpec& sphere);
void describe(Keys& keys, HalfSpaceSpec& half_space);
void describe(Keys& keys, BoxSpec& box);
/// Reports a shape without one of these forms, or with several.
void check_form(YamlMap* map, std::initializer_list<const char*> forms, const char* hint);
/// Reports names of shapes, obstacles and pieces of the terrain that others have, or that are
/// patterns.
void check_shape_names(const ProblemSpec& spec, Diagnostics& out);

// read_terrain.cpp
void describe(Keys& keys, TerrainPieceSpec& piece);
/// Without a `ground` of its own, a plant with simulated contacts has the boxes and half-spaces of
/// the terrain.
void stand_on_terrain(const YamlReader& mpc, ProblemSpec& spec);
void describe(Keys& keys, CapsuleSpec& capsule);
void describe(Keys& keys, CylinderSpec& cylinder);
void describe(Keys& keys, HullSpec& hull);
/// The keys of convex bodies, alternatives of a variant.
template <class Form>
void describe_bodies(Keys& keys, Form& form) {
  keys({"sphere"}, form, AlternativeForm<SphereSpec>{});
  keys({"capsule"}, form, AlternativeForm<CapsuleSpec>{});
  keys({"box"}, form, AlternativeForm<BoxSpec>{});
  keys({"cylinder"}, form, AlternativeForm<CylinderSpec>{});
  keys({"hull"}, form, AlternativeForm<HullSpec>{});
}

// read_drawing.cpp
void describe(Keys& keys, DrawingSpec& drawing);

// read_stepping.cpp
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
/// The gait of feet among these contacts.
struct GaitForm {
  const std::vector<ContactSpec>& contacts;
  bool read(const YamlReader& reader, GaitSpec& gait) const;
  /// Expanded files have phases instead.
  std::optional<OrderedJson> expand(const GaitSpec& /*gait*/) const { return std::nullopt; }
  OrderedJson schema(GaitSpec gait, SchemaDefinitions& definitions) const;
};

// read_phases.cpp
/// Phases in the order of time.
struct PhasesForm {
  bool with_contacts;        ///< expanded phases name their contacts
  bool before_gait = false;  ///< a gait makes the phases that follow
  bool read(const YamlReader& reader, std::vector<PhaseSpec>& phases) const;
  std::optional<OrderedJson> expand(const std::vector<PhaseSpec>& phases) const;
  OrderedJson schema(const std::vector<PhaseSpec>& value, SchemaDefinitions& definitions) const;
};

// read_mesh.cpp
void describe(Keys& keys, MeshSpec& mesh);

// read_costs.cpp
/// A cost; `where` says where it stands.
void describe(Keys& keys, CostSpec& cost);
/// Each integral is an expression, or a mapping with `rows`.
struct IntegralsForm {
  bool read(const YamlReader& reader, std::vector<CostSpec>& integrals) const;
  std::optional<OrderedJson> expand(const std::vector<CostSpec>& integrals) const;
  OrderedJson schema(const std::vector<CostSpec>& value, SchemaDefinitions& definitions) const;
};
/// Describes the residual of a cost or constraint and its keys. False for an unknown residual.
bool describe_function(Keys& keys, std::string_view says, CostSpec& cost);
void describe_phases(Keys& keys, std::string_view says, std::optional<std::vector<Name>>& phases);
void describe_knots(Keys& keys, std::string_view says, CostSpec& cost);

// read_reference.cpp
void describe(Keys& keys, DataFileSpec& file);
/// The reference of a cost whose residual and keys are known.
struct OriginForm {
  bool read(const YamlReader& reader, CostSpec& cost) const;
  std::optional<OrderedJson> expand(const CostSpec& cost) const;
  OrderedJson schema(const CostSpec& cost, SchemaDefinitions& definitions) const;
};

// read_constraints.cpp
/// Constraints by name, on running knots or at the last node.
struct ConstraintsForm {
  bool last_node = false;
  bool read(const YamlReader& reader, std::vector<ConstraintSpec>& all) const;
  std::optional<OrderedJson> expand(const std::vector<ConstraintSpec>& all) const;
  OrderedJson schema(const std::vector<ConstraintSpec>& value,
                     SchemaDefinitions& definitions) const;
};

// read_terminal_lqr.cpp
/// An equilibrium, or a regulator about it.
struct LqrForm {
  bool read(const YamlReader& reader, TerminalLqrSpec& lqr) const;
  std::optional<OrderedJson> expand(const TerminalLqrSpec& lqr) const;
  OrderedJson schema(const TerminalLqrSpec& value, SchemaDefinitions& definitions) const;
};

// read_guess.cpp
void describe(Keys& keys, GuessSpec& guess);

// read_solver.cpp
void describe(Keys& keys, SolverOptions& options);
void describe(Keys& keys, SolverSpec& solver);

// read_mpc.cpp
void describe(Keys& keys, MpcSpec& mpc);

}  // namespace conddp
