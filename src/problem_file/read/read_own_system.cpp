#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/data/library_file.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/model/expression_source.hpp"
#include "problem_file/read/read_sections.hpp"
#include "systems/expressions/scope.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

using Part = ModelMessage::Part;

constexpr Choice<ExpressionState::Kind> kStateWords[] = {
    {"unit_quaternion", ExpressionState::Kind::kUnitQuaternion},
    {"pose", ExpressionState::Kind::kPose}};

constexpr std::string_view kColumnsSchema = R"({
  "type": ["object", "array"], "items": {"type": "string"},
  "additionalProperties": {"type": ["string", "number"]}
})";

/// Names with a word each, such as a unit: from a mapping, or from a list, with the word 1.
std::vector<std::pair<Name, std::string>> read_named_words(const YamlReader& reader) {
  std::vector<std::pair<Name, std::string>> words;
  if (reader.is_sequence()) {
    const auto names = reader.names();
    if (!names) return words;
    for (const Name& name : *names) words.emplace_back(name, "1");
    return words;
  }
  const auto entries = reader.named_entries("write {name: unit, ...} or [name, ...]");
  if (!entries) return words;
  for (const auto& [name, value] : *entries)
    if (value.is_null() || (value.is_scalar() && value.node().text.empty()))
      value.error(fmt::format("'{}' has no unit behind it", name.value),
                  "write the unit, or 1 where there is none");
    else if (!value.is_scalar())
      value.error(fmt::format("the unit of '{}' is one word", name.value),
                  fmt::format("write '{}: 1', or its unit; bounds stand below 'constraints' "
                              "('bounds: state' or 'bounds: control'), first values below "
                              "'initial_state'",
                              name.value));
    else if (auto word = value.text())
      words.emplace_back(name, std::move(*word));
  return words;
}

/// Columns with their units. `add` gets the name and the unit of each.
template <class Add>
CustomValue columns_value(const std::vector<Column>& columns, Add add) {
  return {[add](const YamlReader& reader) {
            for (const auto& [name, unit] : read_named_words(reader)) add(name, unit);
          },
          [&columns] {
            OrderedJson json = OrderedJson::object();
            for (const Column& column : columns) json[column.name] = column.unit;
            return json;
          },
          kColumnsSchema};
}

CustomValue columns_value(std::vector<Column>& columns, SystemPartPlaces& places) {
  return columns_value(columns, [&](const Name& name, const std::string& unit) {
    columns.push_back({name.value, unit});
    places.names.push_back(name.place);
  });
}

/// Warns of a unit that looks like a kind of state.
void check_unit(const Name& name, const std::string& unit, Diagnostics& out) {
  const bool meant = unit.find("quat") != unit.npos || unit == "SO3" || unit == "SE3" ||
                     !similar_names(unit, {"unit_quaternion"}).empty();
  if (meant || unit == "rotation" || unit == "orientation")
    out.warning(name.place, fmt::format("'{}' is taken for the unit of a number", unit),
                "a rotation is 'unit_quaternion', a position with a rotation 'pose'");
}

void read_states(const YamlReader& reader, ExpressionSystemSpec& p) {
  for (const auto& [name, word] : read_named_words(reader)) {
    ExpressionState state{.name = name.value, .unit = word};
    for (const auto& choice : kStateWords)
      if (choice.word == word) state.kind = choice.value;
    if (state.kind == ExpressionState::Kind::kNumber) {
      check_unit(name, word, reader.diagnostics());
    } else {
      state.unit = "1";
      if (p.text.kind == SystemKind::discrete)
        reader.diagnostics().error(name.place, "the states of difference equations are numbers");
    }
    p.text.states.push_back(std::move(state));
    p.places[Part::kState].names.push_back(name.place);
  }
}

OrderedJson expand_states(const std::vector<ExpressionState>& states) {
  OrderedJson json = OrderedJson::object();
  for (const ExpressionState& state : states)
    json[state.name] = state.kind == ExpressionState::Kind::kNumber
                           ? state.unit
                           : word_of(kStateWords, state.kind);
  return json;
}

CustomValue states_value(ExpressionSystemSpec& p) {
  return {[&p](const YamlReader& reader) { read_states(reader, p); },
          [&p] { return expand_states(p.text.states); }, kColumnsSchema};
}

CustomValue expressions_value(std::vector<NamedExpression>& expressions, SystemPartPlaces& places) {
  return {[&](const YamlReader& reader) {
            const auto entries = reader.named_entries();
            if (!entries) return;
            for (const auto& [name, value] : *entries) {
              auto text = read_expression(value);
              if (!text) continue;
              expressions.push_back({name.value, text->text});
              places.names.push_back(name.place);
              places.texts.push_back(std::move(*text));
            }
          },
          [&] {
            OrderedJson json = OrderedJson::object();
            for (const NamedExpression& expression : expressions)
              json[expression.name] = expression.text;
            return json;
          },
          R"({"type": "object", "additionalProperties": {"type": ["string", "number", "array"]}})"};
}

/// Sets the kind of system by the key of its equations.
void read_kind(YamlMap& map, ExpressionSystemSpec& p) {
  map.exclusive({"rate", "acceleration", "next"});
  const bool acceleration = map.find("acceleration").has_value();
  const bool next = map.find("next").has_value();
  p.text.kind = acceleration ? SystemKind::second_order
                : next       ? SystemKind::discrete
                             : SystemKind::first_order;
}

/// Reports keys that belong to other kinds of systems, and missing controls.
void check_keys(YamlMap& map, SystemKind kind) {
  const bool second_order = kind == SystemKind::second_order;
  for (const std::string_view key : {"states", "positions", "velocities"})
    if (const auto reader = (key == "states") == second_order ? map.find(key) : std::nullopt)
      reader->error(fmt::format("'{}' does not go with '{}'", key,
                                second_order                   ? "acceleration"
                                : kind == SystemKind::discrete ? "next"
                                                               : "rate"),
                    second_order ? "accelerations are those of 'positions' and 'velocities'"
                                 : "'positions' and 'velocities' have accelerations");
  if (!map.find("controls") && map.valid())
    map.reader().error("'system' lacks the key 'controls'",
                       "where nothing is controlled, write 'controls: []'");
}

void read_parameters(const YamlReader& reader, ExpressionNamesSpec& own) {
  NamedNumbers numbers;
  NamedNumbersForm().read(reader, numbers);
  for (const auto& [name, value] : numbers) {
    own.parameters.emplace_back(name.value, value);
    own.parameter_places.push_back(name.place);
  }
}

}  // namespace

void describe_parameters(Keys& keys, ExpressionSystemSpec& p) {
  YamlMap* map = keys.reading();
  if (map != nullptr) read_kind(*map, p);
  const bool read = map != nullptr;
  const bool all = keys.documents();
  const auto is = [&](SystemKind kind) { return all || p.text.kind == kind; };
  const bool second_order = is(SystemKind::second_order);
  if (all || !second_order)
    keys({.name = "states",
          .says = "Of 'rate' and 'next': names with their unit, or with unit_quaternion (x y z w) "
                  "or pose (position and quaternion); or a list of names",
          .required = read},
         states_value(p));
  if (second_order) {
    keys({.name = "positions",
          .says = "Of 'acceleration': as states, with a unit each",
          .required = read},
         states_value(p));
    keys({.name = "velocities",
          .says = "Of 'acceleration': names with their unit or a list of names, one for each "
                  "position in the same order; those of rotations are angular velocities, of poses "
                  "twists, in body axes",
          .required = read},
         columns_value(p.text.velocities, p.places[Part::kVelocity]));
  }
  if (map != nullptr) check_keys(*map, p.text.kind);
  keys({.name = "controls", .says = "Names with their unit, or a list of names", .required = all},
       columns_value(p.text.controls, p.places[Part::kControl]));
  keys({.name = "parameters",
        .says = "Constants of the expressions by name, in any unit",
        .fallback = "{}"},
       CustomValue{[&](const YamlReader& reader) { read_parameters(reader, p.own); },
                   [&] { return ParametersForm().expand(p.own); },
                   R"({"$ref": "#/definitions/numbers_by_name"})"});
  keys({.name = "tables", .says = "Functions by name, for the equations", .fallback = "{}"},
       p.own.tables, TablesForm{});
  keys({.name = "let",
        .says = "Expressions with a name, for those behind them, in any unit",
        .fallback = "{}"},
       expressions_value(p.text.definitions, p.places[Part::kDefinition]));
  const auto equations = [&] {
    return expressions_value(p.text.equations, p.places[Part::kEquation]);
  };
  if (is(SystemKind::first_order))
    keys(
        {.name = "rate",
         .says = "First order: the rate of each state, in its unit per second; of a quaternion its "
                 "angular velocity in body axes, of a pose its twist",
         .required = read},
        equations());
  if (second_order)
    keys({"acceleration", "Second order: the rate of each velocity, in its unit per second"},
         equations());
  if (is(SystemKind::discrete))
    keys({"next", "Difference equations: each state at the next knot, in its unit"}, equations());
}

namespace {

/// Requires names that are valid in expressions, because costs and constraints use expressions.
bool add_name(const Name& name, ExpressionScope& names, Diagnostics& out) {
  const bool is_clock = name.value == kClock || name.value == kClockRate;
  const std::string defect = is_clock ? fmt::format("'{}' is the name of the clock", name.value)
                                      : names.defect_of(name.value);
  if (!defect.empty()) return out.error(name.place, defect), false;
  names.add(name.value, ExpressionValue::vector({}));
  return true;
}

/// Reports keys that do not go with what the function gives, and a wrong number of velocities.
void check_columns(YamlMap& map, const LibrarySystemColumns& columns) {
  const bool second_order = columns.kind == SystemKind::second_order;
  for (const std::string_view key : {"positions", "velocities", "states"})
    if (const auto reader = (key == "states") == second_order ? map.find(key) : std::nullopt)
      reader->error(fmt::format("'{}' does not go with what the function gives", key),
                    "write 'gives: acceleration' for 'positions' and 'velocities', or 'gives: "
                    "rate' or 'gives: next' for 'states'");
  const std::size_t positions = columns.states.size(), velocities = columns.velocities.size();
  if (!second_order || positions == velocities || !map.valid()) return;
  const auto reader = map.find("velocities");
  (reader ? *reader : map.reader())
      .error(fmt::format("there are {} and {}",
                         velocities == 1 ? "1 velocity" : fmt::format("{} velocities", velocities),
                         counted(positions, "position")),
             "each position has a velocity, in the same order");
}

}  // namespace

void describe_parameters(Keys& keys, LibrarySystemSpec& p) {
  LibrarySystemColumns& columns = p.columns;
  YamlMap* map = keys.reading();
  const bool read = map != nullptr, all = keys.documents();
  ExpressionScope names;
  const auto named = [&](std::vector<Column>& into) {
    return columns_value(into, [&](const Name& name, const std::string& unit) {
      if (add_name(name, names, map->reader().diagnostics())) into.push_back({name.value, unit});
    });
  };
  keys({.name = "library",
        .says = "A shared library of compiled code, relative to the problem file; it is loaded "
                "with --allow-code alone",
        .required = true},
       p.function.library, NameForm{});
  keys({.name = "function",
        .says = "The function, with inputs x, u, p and t; its Jacobian is jac_ and its Hessian "
                "hess_ before the name",
        .required = true},
       p.function.function, NameForm{});
  keys({"gives",
        "What the function gives: the rate of the states, the acceleration of positions and "
        "velocities, or the next states"},
       columns.kind, WordForm(kLibraryAnswerWords, "answer of a function"));
  const bool second_order = columns.kind == SystemKind::second_order;
  if (all || !second_order)
    keys({.name = "states",
          .says = "Of 'rate' and 'next': names with their unit, or a list of names, of the numbers "
                  "of x",
          .required = read},
         named(columns.states));
  if (all || second_order) {
    keys({.name = "positions",
          .says = "Of 'acceleration': names with their unit, or a list of names, of the first "
                  "numbers of x",
          .required = read},
         named(columns.states));
    keys({.name = "velocities",
          .says = "Of 'acceleration': one for each position, the other numbers of x, with a unit "
                  "each",
          .required = read},
         named(columns.velocities));
  }
  keys({.name = "controls",
        .says = "Names with their unit, or a list of names, of the numbers of u",
        .required = true},
       named(columns.controls));
  keys({"parameters", "The numbers of p in order, in any unit"}, p.function.parameters,
       NamedNumbersForm{});
  if (map == nullptr) return;
  check_columns(*map, columns);
  const auto place_of = [&](std::string_view key) {
    return map->find(key).value_or(map->reader()).place();
  };
  p.states_place = place_of(second_order ? "positions" : "states");
  p.controls_place = place_of("controls");
  p.function.parameters_place = place_of("parameters");
}

namespace {

void add(const ExpressionNamesSpec& names, ExpressionSystemSpec& p) {
  add_names(names, p.text.parameters, p.text.tables);
  for (const Place& place : names.parameter_places)
    p.places[Part::kParameter].names.push_back(place);
  for (const TableSpec& table : names.tables)
    p.places[Part::kTable].names.push_back(table.name.place);
}

void report(const YamlReader& reader, const ModelMessage& message, Severity severity,
            const ExpressionSystemSpec& p) {
  const auto part = p.places.find(message.part);
  const std::string &text = message.message.message, &hint = message.message.hint;
  if (part == p.places.end()) return reader.error(text, hint);
  Diagnostics& out = reader.diagnostics();
  if (!message.in_text) return out.error(part->second.names[message.index], text, hint);
  report_expression(part->second.texts[message.index], message.message, severity, out);
}

}  // namespace

void settle_own_system(const YamlReader& reader, const ExpressionNamesSpec& names,
                       SystemSpec& system) {
  if (auto* library = std::get_if<LibrarySystemSpec>(&system.parameters))
    library->loaded =
        load_library_file(reader.folder(), library->function.library, reader.diagnostics());
  auto* expressions = std::get_if<ExpressionSystemSpec>(&system.parameters);
  if (expressions == nullptr) return;
  // Constants and tables of the file precede those of the system.
  add(names, *expressions);
  add(expressions->own, *expressions);
  if (names.incomplete) return;
  expressions->parsed = make_expression_system(expressions->text);
  for (const auto& message : expressions->parsed.errors)
    report(reader, message, Severity::kError, *expressions);
  for (const auto& message : expressions->parsed.warnings)
    report(reader, message, Severity::kWarning, *expressions);
}

}  // namespace conddp
