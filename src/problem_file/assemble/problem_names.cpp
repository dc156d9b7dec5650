#include "problem_file/assemble/problem_names.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/terms/term_residual.hpp"

namespace conddp {
namespace {

using Names = std::vector<std::string>;

/// Names of the rows of a residual on a plant; empty for contact residuals.
Names names_on(const CostSpec& function, const BuiltProblem& built, const Plant& plant) {
  Diagnostics reported_when_built;
  const auto made = make_cost_residual(function, *built.problem_spec, plant, built.problem->ndx(),
                                       reported_when_built);
  return made ? made->rows.names : Names();
}

/// The constraint's entry in the file; null if it has another origin.
const ConstraintSpec* entry_of(const NodeConstraint& constraint, const BuiltProblem& built,
                               const ShootingProblem& problem) {
  const ProblemSpec& spec = *built.problem_spec;
  const auto find = [&](const std::vector<ConstraintSpec>& list) -> const ConstraintSpec* {
    for (const ConstraintSpec& one : list)
      if (one.function.name.value == constraint.term->name) return &one;
    return nullptr;
  };
  // Constraints on running knots can also hold at the last node.
  if (constraint.node == problem.knots())
    if (const ConstraintSpec* found = find(spec.terminal_constraints)) return found;
  return find(spec.constraints);
}

/// Names of the rows that are single columns.
Names names_by_column(const Residual& residual, const Names& columns) {
  Names names;
  for (const RowBlock& block : residual.blocks())
    if (block.rows == 1 && block.columns.size() == 1 &&
        block.columns[0] < static_cast<int>(columns.size()))
      names.push_back(columns[block.columns[0]]);
  return names;
}

Names row_names(const ConstraintSpec& entry, const BuiltProblem& built, const Residual& residual) {
  const auto is_complete = [&](const Names& names) {
    return static_cast<int>(names.size()) == residual.size();
  };
  Names names = names_by_column(residual, tangent_columns(built));
  if (is_complete(names)) return names;
  for (const Plant& plant : built.plant.all_variants())
    if (Names found = names_on(entry.function, built, plant); is_complete(found)) return found;
  names.clear();
  for (int i = 0; i < residual.size(); ++i) names.push_back(std::to_string(i + 1));
  return names;
}

/// The name of a state coordinate as a world axis, empty if uncertain: the part after the name of a
/// floating base, or "x", "y", "z" for the first positions of a double integrator.
std::string axis_of_state(const std::string& row, const BuiltProblem& built) {
  if (built.plant.multibody()) {
    const RobotModel& robot = built.plant.robot();
    const std::size_t slash = row.find('/');
    const auto joint = slash == row.npos ? std::nullopt : robot.find_joint(row.substr(0, slash));
    if (!joint || robot.joints[*joint].type != JointType::floating) return {};
    return row.substr(slash + 1);
  }
  const auto& system = built.facts().system;
  if (!system || !std::holds_alternative<DoubleIntegratorSpec>(system->parameters) ||
      !row.starts_with("q/"))
    return row;
  return row.size() == 3 && row[2] >= '0' && row[2] <= '2' ? std::string(1, "xyz"[row[2] - '0'])
                                                           : std::string();
}

/// 0, 1, 2 for a row that is a position along x, y, z of the world, else −1.
int world_axis(const ConstraintSpec& entry, const BuiltProblem& built, const std::string& row) {
  const ReferenceForm* form = entry.function.definition->reference;
  const bool of_state = entry.bounded || form == &kStateReference;
  if (!of_state && (form == nullptr || !form->is_point)) return -1;
  const std::string axis = of_state ? axis_of_state(row, built) : row;
  return axis == "x" ? 0 : axis == "y" ? 1 : axis == "z" ? 2 : -1;
}

}  // namespace

std::vector<std::string> constraint_row_names(const BuiltProblem& built,
                                              const ShootingProblem& problem,
                                              const NodeConstraint& constraint) {
  const ConstraintSpec* entry = entry_of(constraint, built, problem);
  return entry == nullptr ? Names() : row_names(*entry, built, *constraint.term->residual);
}

std::array<int, 3> rows_by_axis(const BuiltProblem& built, const NodeConstraint& constraint) {
  std::array<int, 3> by_axis{-1, -1, -1};
  const ConstraintSpec* entry = entry_of(constraint, built, *built.problem);
  if (entry == nullptr) return by_axis;
  const Residual& residual = *constraint.term->residual;
  const Names rows = row_names(*entry, built, residual);
  for (int i = 0; i < residual.size() && i < residual.parameter_count(); ++i)
    if (const int axis = world_axis(*entry, built, rows[i]); axis >= 0) by_axis[axis] = i;
  return by_axis;
}

std::vector<std::string> cost_row_names(const BuiltProblem& built, const CostTerm& term,
                                        std::size_t phase) {
  const ProblemSpec& spec = *built.problem_spec;
  const bool terminal = phase == spec.phases.size();
  for (const CostSpec& cost : terminal ? spec.terminal_costs : spec.costs) {
    if (cost.name.value != term.name) continue;
    if (cost.matrix) break;  // each row combines all rows of the residual
    if (Names names = names_on(cost, built, built.plant.in_phase(phase)); !names.empty())
      return names;
  }
  Names names;
  for (int i = 0; i < term.residual->size(); ++i) names.push_back(fmt::format("row {}", i));
  return names;
}

namespace {

/// True if the rows of a constraint are distances of shapes.
bool is_of_shapes(const ConstraintSpec& constraint) {
  return !constraint.bounded && constraint.function.definition->needs.shapes;
}

/// True if a cost or constraint is not limited to some phases or knots.
bool holds_throughout(const CostSpec& c) { return !c.phases && !c.knots; }

/// Records a cost or constraint on friction cones (or wrench cones, which contain them) by contact.
void note_cone(const ProblemSpec& spec, const CostSpec& c, bool constraint, FindingNames& names) {
  if (c.definition == nullptr ||
      (c.definition->name != "friction_cone" && c.definition->name != "wrench_cone"))
    return;
  const ContactNames chosen = c.keys.value(key::contacts);
  for (const ContactSpec& contact : spec.contacts)
    if (chosen.has(contact.name.value))
      names.cones[contact.name.value].push_back({c.name.value, constraint, holds_throughout(c)});
}

/// Records what the file already requests, so that findings need not recommend it.
void note_constraints(const ProblemSpec& spec, FindingNames& names) {
  for (const ConstraintSpec& c : spec.control_bounds)
    if (c.from_urdf && !c.function.phases) names.bounded.insert("control");
  for (const ConstraintSpec& c : spec.constraints) {
    if (!c.bounded) note_cone(spec, c.function, true, names);
    if (!c.bounded || !c.from_urdf || !holds_throughout(c.function)) continue;
    const bool state = c.bounded->value == BoundedQuantity::kState;
    const auto note = [&](BoundedQuantity quantity, const char* name) {
      if (c.bounded->value != quantity && !(state && quantity != BoundedQuantity::kControl)) return;
      names.bounded.insert(name);
      if (c.function.ends.value) names.bounded_to_the_end.insert(name);
    };
    note(BoundedQuantity::kConfiguration, "configuration");
    note(BoundedQuantity::kVelocity, "velocity");
    note(BoundedQuantity::kControl, "control");
  }
  for (const CostSpec& c : spec.costs) note_cone(spec, c, false, names);
}

/// Pairs of shapes, or names or numbers of rows, with their expressions if each row has one.
FindingNames::Rows rows_of(const ConstraintSpec& c, const Names& names) {
  if (is_of_shapes(c)) return {names, "m"};
  const std::vector<ExpressionText> texts = c.function.keys.value(key::expression_rows).texts;
  FindingNames::Rows rows;
  for (std::size_t i = 0; i < names.size(); ++i)
    rows.names.push_back(fmt::format("row {}", names[i]) +
                         (texts.size() == names.size() ? ", " + texts[i].text : ""));
  return rows;
}

}  // namespace

FindingNames finding_names(const BuiltProblem& built) {
  const ProblemSpec& spec = *built.problem_spec;
  FindingNames names;
  note_constraints(spec, names);
  for (const ContactSpec& contact : spec.contacts)
    names.friction[contact.name.value] = contact.friction;
  for (const ContactSpec& contact : spec.contacts)
    if (contact.name.place.path.starts_with("loops."))
      names.contact_keys[contact.name.value] = contact.name.place.path;
  for (const bool terminal : {false, true})
    for (const ConstraintSpec& c : terminal ? spec.terminal_constraints : spec.constraints) {
      if (c.bounded || c.function.definition->of_contacts()) continue;
      const Names rows = names_on(c.function, built, built.plant);
      if (rows.size() > 1 || (is_of_shapes(c) && !rows.empty()))
        names.rows[(terminal ? "terminal/" : "") + c.function.name.value] = rows_of(c, rows);
    }
  return names;
}

std::map<std::string, int> watched_frames(const BuiltProblem& built) {
  const ProblemSpec& spec = *built.problem_spec;
  std::map<std::string, int> frames;
  const auto watch = [&](const CostSpec& cost) {
    const Name* name = cost.keys.find(key::frame);
    if (name == nullptr) return;
    if (const auto frame = built.plant.robot().find_frame(name->value))
      frames[name->value] = *frame;
  };
  for (const CostSpec* cost : spec.all_costs()) watch(*cost);
  for (const ConstraintSpec* constraint : spec.all_constraints()) watch(constraint->function);
  for (const ContactSpec& contact : spec.contacts) frames.erase(contact.frame.value);
  return frames;
}

Place place_of_most_knots(const BuiltProblem& built) {
  const auto knots = [](const PhaseSpec& phase) { return phase.knots.value; };
  return std::ranges::max_element(built.problem_spec->phases, {}, knots)->knots.place;
}

std::vector<std::string> free_parameter_names(const BuiltProblem& built) {
  std::vector<std::string> names;
  for (const FreeParameter& parameter : built.problem_spec->names.free)
    names.push_back(parameter.name.value);
  return names;
}

bool runs_code(const BuiltProblem& built) {
  const ProblemSpec& spec = *built.problem_spec;
  const auto is_compiled = [](const SystemSpec& one) {
    return std::holds_alternative<LibrarySystemSpec>(one.parameters);
  };
  return (spec.system && is_compiled(*spec.system)) || spec.first_use(&ResidualNeeds::code) ||
         std::ranges::any_of(spec.systems, is_compiled, &NamedSystemSpec::system);
}

}  // namespace conddp
