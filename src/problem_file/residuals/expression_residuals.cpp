#include <fmt/format.h>

#include "ocp/residuals/expression_residual.hpp"
#include "problem_file/model/expression_source.hpp"
#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

/// A residual that expressions name.
struct Operand : CostSpec {};

/// Other residuals by their names in expressions.
const Key<std::vector<Operand>> kOperands{"of", std::vector<Operand>()};

}  // namespace

static void describe(Keys& keys, Operand& operand) {
  keys.about({.definition = "operand",
              .title = "Residual that expressions name",
              .examples = R"([{"residual": "frame_position", "frame": "tool"}])"});
  operand.where.kind = TermPlace::Kind::kOperand;
  describe_residual(keys, operand, "Which one; its own keys stand beside it");
}

namespace {

constexpr const char* kSupported =
    "frames, center of mass, momentum, distances, forces and velocities of contacts";

/// A residual whose rows, measured from zero, have names in expressions.
std::optional<ExpressionOperand> make_operand(const CostSpec& operand,
                                              const ResidualContext& context) {
  const ResidualDefinition& definition = *operand.definition;
  const ResidualNeeds& needs = definition.needs;
  const auto fail = [&](std::string message, std::string hint) {
    context.out.error(operand.residual.place, std::move(message), std::move(hint));
    return std::nullopt;
  };
  if (definition.of_contacts() || needs.previous_control || needs.chosen_start)
    return fail(
        fmt::format("'{}' is not a quantity of one state and control, which expressions read",
                    definition.name),
        kSupported);
  if (needs.robot && !context.plant.multibody())
    return fail(fmt::format("the residual '{}' needs a robot; this is a closed-form system",
                            definition.name),
                "expressions name the columns of the system themselves");
  if (operand.names_previous_control)
    return fail("a residual that another one names has no 'previous'",
                "write 'previous[...]' into the rows that name it");
  auto made = definition.make(
      {operand, context.spec, context.plant, context.contacts, context.ndx, context.out});
  if (!made) return std::nullopt;
  if (made->time != TimeParameters::kNone)
    return fail("a residual that another one names has no time 't'",
                "write 't' into the rows that name it");
  return ExpressionOperand{operand.name.value, std::move(made->residual),
                           made->parameters.neutral(), std::move(made->rows.names)};
}

/// The file's only system of expressions, or null. Definitions of several systems may differ, so
/// residuals cannot use them.
const ExpressionSystemSpec* own_system(const ProblemSpec& spec) {
  return spec.system && spec.systems.empty()
             ? std::get_if<ExpressionSystemSpec>(&spec.system->parameters)
             : nullptr;
}

/// The control of the preceding knot, which follows the system's state: `previous[force]`, or
/// `previous[knee]` for a column u/knee.
KnotName previous_control(const ResidualContext& context) {
  const Plant& plant = context.plant;
  const int last = plant.system->nx() + context.ndx - plant.system->ndx();
  const int first = last - plant.actuated().nu();
  KnotName name{.name = std::string(kPreviousControl), .unit = "", .numbers = {}, .parts = {}};
  for (const Column& column : plant.actuated().control_columns()) {
    const int index = static_cast<int>(name.numbers.size());
    name.parts.push_back({column.name.substr(column.name.find('/') + 1), index});
    name.numbers.push_back({false, first + index});
  }
  return name;
}

/// Indices of the free durations in the state, in the order of the phases. They follow the chosen
/// coordinates.
std::vector<int> free_durations(const ResidualContext& context) {
  std::vector<int> durations;
  if (!context.plant.start) return durations;
  const ChosenStart& start = *context.plant.start;
  int next = context.plant.system->nx() + start.before + static_cast<int>(start.coordinates.size());
  for (const PhaseSpec& phase : context.spec.phases)
    if (phase.free_duration) durations.push_back(next++);
  return durations;
}

/// Drawings may be constant, and need not be smooth.
bool is_drawing(const ResidualContext& context) {
  return context.cost.where.kind == TermPlace::Kind::kDrawing;
}

/// The rows, operands and names of a residual in expressions.
ExpressionResidualText text_of(const ExpressionRowsSpec& rows,
                               std::vector<ExpressionOperand> operands,
                               const ResidualContext& context) {
  // Collocation slopes are not controls at the beginning of a knot.
  const bool linear = context.spec.has_linear_controls();
  ExpressionResidualText text{
      .names = knot_names(linear ? context.plant.actuated() : *context.plant.system),
      .operands = std::move(operands)};
  for (std::size_t i = 0; i < context.spec.integrals.size(); ++i)
    text.names.push_back({context.spec.integrals[i].name.value,
                          "1",
                          {{false, context.plant.system->nx() + static_cast<int>(i)}},
                          {}});
  const bool is_operand = std::ranges::any_of(text.operands, [](const ExpressionOperand& operand) {
    return operand.name == kPreviousControl;
  });
  if (context.cost.names_previous_control && !linear && !is_operand)
    text.names.push_back(previous_control(context));
  add_names(context.spec.names, text.parameters, text.tables);
  if (const ExpressionSystemSpec* own = own_system(context.spec)) {
    add_names(own->own, text.parameters, text.tables);
    text.definitions = own->text.definitions;
  }
  for (const ExpressionText& row : rows.texts) text.rows.push_back(row.text);
  text.constants = context.spec.first_free_duration() != nullptr || is_drawing(context);
  text.durations = free_durations(context);
  return text;
}

/// Adds the system to a message if the file has several, because names depend on the system.
ExpressionMessage with_system(ExpressionMessage message, const Plant& plant) {
  if (plant.name.empty()) return message;
  message.hint += fmt::format(
      "{}this is on a phase of the system '{}': names of others need 'phases' that have them",
      message.hint.empty() ? "" : "; ", plant.name);
  return message;
}

void report(const ModelMessage& message, Severity severity, const ExpressionRowsSpec& rows,
            const ResidualContext& context) {
  using Part = ModelMessage::Part;
  if (message.part == Part::kRow && message.in_text) {
    const bool is_error = severity == Severity::kError;
    return report_expression(
        rows.texts[message.index],
        is_error ? with_system(message.message, context.plant) : message.message, severity,
        context.out);
  }
  // The system reports warnings of its definitions.
  if (severity != Severity::kError) return;
  // A robot may use names of the file.
  const ExpressionNamesSpec& names = context.spec.names;
  const std::size_t index = message.index;
  const auto* operands = context.cost.keys.find(kOperands);
  Place place = context.cost.residual.place;
  if (message.part == Part::kParameter && index < names.parameters.size())
    place = names.parameter_places[index];
  if (message.part == Part::kTable && index < names.tables.size())
    place = names.tables[index].name.place;
  if (message.part == Part::kOperand) place = operands->at(index).name.place;
  context.out.error(place, message.message.message, message.message.hint);
}

/// Names of the rows. Rows of a named text with several values also have an index.
std::vector<std::string> row_names(const ExpressionRowsSpec& rows, const std::vector<int>& sizes) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sizes.size(); ++i)
    for (int row = 0; row < sizes[i]; ++row) {
      if (rows.names.empty())
        names.push_back(std::to_string(names.size() + 1));
      else
        names.push_back(rows.names[i] + (sizes[i] > 1 ? "/" + std::to_string(row) : ""));
    }
  return names;
}

/// The state manifold of knot models, including augmented states.
StateManifold knot_manifold(const ResidualContext& context) {
  const System& system = *context.plant.system;
  StateManifold manifold = system.manifold();
  if (context.ndx > system.ndx())
    manifold.append(StateManifold::Part::flat, context.ndx - system.ndx());
  return manifold;
}

/// The residual of a text; empty with an error if it is invalid.
std::optional<CostResidual> make_rows(const ExpressionRowsSpec& rows,
                                      const ExpressionResidualText& text,
                                      const ResidualContext& context) {
  const auto parsed = make_expression_residual(knot_manifold(context), text);
  for (const ModelMessage& message : parsed.errors)
    report(message, Severity::kError, rows, context);
  for (const ModelMessage& message : parsed.warnings)
    if (!is_drawing(context)) report(message, Severity::kWarning, rows, context);
  if (!parsed.residual) return std::nullopt;
  CostResidual result;
  result.residual = parsed.residual;
  result.rows = result.references = {"rows", row_names(rows, parsed.rows)};
  result.parameters = StateManifold::flat(parsed.residual->size());
  if (parsed.reads_time) result.time = TimeParameters::kAll;
  return result;
}

std::optional<CostResidual> make_expression(const ResidualContext& context) {
  const ExpressionRowsSpec rows = context.cost.keys.value(key::expression_rows);
  std::vector<ExpressionOperand> operands;
  for (const CostSpec& operand : context.cost.keys.value(kOperands)) {
    auto made = make_operand(operand, context);
    if (!made) return std::nullopt;
    operands.push_back(*std::move(made));
  }
  return make_rows(rows, text_of(rows, std::move(operands), context), context);
}

bool reads_contacts(const CostSpec& cost) {
  return std::ranges::any_of(cost.keys.value(kOperands), [](const CostSpec& operand) {
    return operand.definition->of_contacts();
  });
}

/// The residual of the single contact that an operand names.
std::optional<ContactCost> make_contact_operand(const CostSpec& operand,
                                                const ResidualContext& context) {
  const ResidualDefinition& definition = *operand.definition;
  if (definition.is_cone) {
    context.out.error(operand.residual.place,
                      fmt::format("'{}' is a set, and expressions read numbers", definition.name),
                      kSupported);
    return std::nullopt;
  }
  const ContactNames names = operand.keys.value(key::contacts);
  std::vector<int> chosen = contacts_named(names, context.spec, context.out);
  if (chosen.empty() && !names.all) return std::nullopt;
  if (chosen.size() != 1) {
    context.out.error(
        operand.name.place,
        fmt::format("'{}' has to be of one contact, not of {}", operand.name.value, chosen.size()),
        "write 'contacts: [NAME]', and other names for other contacts");
    return std::nullopt;
  }
  auto made = definition.make_of_contact(
      {operand, context.spec, context.plant, context.contacts, context.ndx, context.out},
      chosen.front());
  if (made) made->contacts = std::move(chosen);
  return made;
}

/// Operands of an expression that reads contacts. Contact operands are made in each system.
class ContactOperands {
 public:
  /// False with an error if an operand cannot be made.
  bool read(const ResidualContext& context) {
    for (const CostSpec& operand : context.cost.keys.value(kOperands)) {
      if (!operand.definition->of_contacts()) {
        auto made = make_operand(operand, context);
        if (!made) return false;
        all_.push_back(*std::move(made));
        continue;
      }
      auto made = make_contact_operand(operand, context);
      if (!made) return false;
      add(operand.name.value, *std::move(made));
    }
    return true;
  }

  const std::vector<int>& contacts() const { return contacts_; }

  /// The operands in a system that holds the contacts, each at its index there.
  std::vector<ExpressionOperand> in(const std::shared_ptr<const MultibodySystem>& system,
                                    const std::vector<int>& indices) const {
    std::vector<ExpressionOperand> operands = all_;
    for (const Made& made : made_)
      operands[made.operand].residual = made.cost.make(system, {indices[made.contact]});
    return operands;
  }

 private:
  struct Made {
    std::size_t operand, contact;  ///< into all_ and contacts_
    ContactCost cost;
  };

  void add(const std::string& name, ContactCost cost) {
    const auto known = std::ranges::find(contacts_, cost.contacts.front());
    const auto contact = static_cast<std::size_t>(known - contacts_.begin());
    if (known == contacts_.end()) contacts_.push_back(cost.contacts.front());
    all_.push_back({name, nullptr, cost.prototype.parameters.neutral(), cost.prototype.rows.names});
    made_.push_back({all_.size() - 1, contact, std::move(cost)});
  }

  std::vector<ExpressionOperand> all_;
  std::vector<Made> made_;
  std::vector<int> contacts_;
};

std::optional<ContactCost> make_expression_on_contacts(const ResidualContext& context) {
  const ExpressionRowsSpec rows = context.cost.keys.value(key::expression_rows);
  ContactOperands operands;
  if (!operands.read(context)) return std::nullopt;
  std::vector<Contact> held;
  std::vector<int> indices;
  for (const int contact : operands.contacts()) {
    indices.push_back(static_cast<int>(held.size()));
    held.push_back(context.contacts[contact]);
  }
  const auto system = context.plant.multibody()->with_contacts(held);
  ExpressionResidualText text = text_of(rows, operands.in(system, indices), context);
  auto made = make_rows(rows, text, context);
  if (!made) return std::nullopt;
  ContactCost result;
  result.contacts = operands.contacts();
  result.prototype = *std::move(made);
  result.make = [operands, text, manifold = knot_manifold(context)](
                    const std::shared_ptr<const MultibodySystem>& in_system,
                    const std::vector<int>& at) {
    ExpressionResidualText own = text;
    own.operands = operands.in(in_system, at);
    return make_expression_residual(manifold, own).residual;
  };
  return result;
}

}  // namespace

std::span<const ResidualDefinition> expression_residuals() {
  static const ResidualKey operands = [] {
    ResidualKey key = residual_key(
        kOperands,
        {.says = "For expression: other residuals, measured from zero, by their names in the rows",
         .examples = R"([{"tip": {"residual": "frame_position", "frame": "tool"}}])",
         .fallback = "{}"},
        EntriesForm<Operand>{.name = &Operand::name,
                             .hint = "write '{tip: {residual: frame_position, frame: tool}}'"});
    key.complete = [](CostSpec& cost, const TermContext& context) {
      std::vector<Operand> all = cost.keys.value(kOperands);
      for (Operand& operand : all) complete_residual(operand, context);
      cost.keys.set(kOperands, std::move(all));
    };
    return key;
  }();
  static const ResidualDefinition all[] = {
      {.name = "expression",
       .description = "expressions of the state, the control and the time",
       .unit = "same as the expressions",
       .synonyms = {"equation", "formula", "custom"},
       .keys = {&operands, &rows_key()},
       .reference = &kRowsReference,
       .is_point = [](const CostSpec&) { return true; },
       .make = make_expression,
       .reads_contacts = reads_contacts,
       .make_on_contacts = make_expression_on_contacts}};
  return all;
}

}  // namespace conddp
