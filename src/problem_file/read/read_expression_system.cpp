#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/read/named_words.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/expression_source.hpp"

namespace conddp {
namespace {

constexpr std::string_view kUnitQuaternion = "unit_quaternion", kPose = "pose";

/// Places of the names and texts of one part of a system.
struct SystemPartPlaces {
  std::vector<Place> names;
  std::vector<ExpressionText> texts;
};

/// Reads the keys of a system of expressions and reports errors at their places.
class ExpressionSystemReader {
 public:
  ExpressionSystemReader(YamlMap& map, const FileContext& file, ExpressionSystemSpec& system)
      : map_(map), file_(file), out_(map.reader().diagnostics()), system_(system) {}

  void read() {
    const int errors = out_.error_count();
    map_.exclusive({"rate", "acceleration", "next"});
    const std::string equations = read_kind();
    read_states(second_order() ? "positions" : "states");
    exclude(second_order() ? "states" : "positions", equations);
    if (second_order())
      read_columns("velocities", system_.text.velocities, velocities_);
    else
      exclude("velocities", equations);
    if (map_.find("controls"))
      read_columns("controls", system_.text.controls, controls_);
    else if (map_.valid())
      map_.reader().error("'system' lacks the key 'controls'",
                          "where nothing is controlled, write 'controls: []'");
    read_names();
    read_expressions("let", system_.text.definitions, definitions_);
    read_expressions(equations, system_.text.equations, equations_);
    if (out_.error_count() > errors || file_.names.incomplete) return;
    system_.parsed = make_expression_system(system_.text);
    for (const auto& message : system_.parsed.errors) report(message, Severity::kError);
    for (const auto& message : system_.parsed.warnings) report(message, Severity::kWarning);
  }

 private:
  using Part = ModelMessage::Part;

  bool second_order() const { return system_.text.kind == SystemKind::second_order; }

  /// The key of the equations, which determines the kind of system.
  std::string read_kind() {
    const bool acceleration = map_.find("acceleration").has_value();
    const bool next = map_.find("next").has_value();
    system_.text.kind = acceleration ? SystemKind::second_order
                        : next       ? SystemKind::discrete
                                     : SystemKind::first_order;
    acceleration || next ? map_.find("rate") : map_.require("rate");
    return acceleration ? "acceleration" : next ? "next" : "rate";
  }

  void exclude(std::string_view key, const std::string& equations) {
    if (const auto reader = map_.find(key))
      reader->error(fmt::format("'{}' does not go with '{}'", key, equations),
                    second_order() ? "accelerations are those of 'positions' and 'velocities'"
                                   : "'positions' and 'velocities' have accelerations");
  }

  /// Warns of a unit that looks like a kind of state.
  void check_unit(const Name& name, const std::string& unit) {
    const bool meant = unit.find("quat") != unit.npos || unit == "SO3" || unit == "SE3" ||
                       !similar_names(unit, {std::string(kUnitQuaternion)}).empty();
    if (meant || unit == "rotation" || unit == "orientation")
      out_.warning(name.place, fmt::format("'{}' is taken for the unit of a number", unit),
                   "a rotation is 'unit_quaternion', a position with a rotation 'pose'");
  }

  static ExpressionState::Kind kind_of(std::string_view word) {
    if (word == kUnitQuaternion) return ExpressionState::Kind::kUnitQuaternion;
    return word == kPose ? ExpressionState::Kind::kPose : ExpressionState::Kind::kNumber;
  }

  void read_states(std::string_view key) {
    const auto reader = map_.require(key);
    if (!reader) return;
    for (const auto& [name, word] : read_named_words(*reader)) {
      ExpressionState state{.name = name.value, .unit = word};
      state.kind = kind_of(word);
      if (state.kind == ExpressionState::Kind::kNumber) {
        check_unit(name, word);
      } else {
        state.unit = "1";
        if (system_.text.kind == SystemKind::discrete)
          out_.error(name.place, "the states of difference equations are numbers");
      }
      system_.text.states.push_back(std::move(state));
      states_.names.push_back(name.place);
    }
  }

  void read_columns(std::string_view key, std::vector<Column>& columns, SystemPartPlaces& places) {
    const auto reader = map_.require(key);
    if (!reader) return;
    for (const auto& [name, word] : read_named_words(*reader)) {
      columns.push_back({name.value, word});
      places.names.push_back(name.place);
    }
  }

  /// Reads constants and tables; those of the file precede those of the system.
  void read_names() {
    if (const auto reader = map_.find("parameters"))
      for (const auto& [name, value] : read_named_numbers(*reader)) {
        system_.own.parameters.emplace_back(name.value, value);
        system_.own.parameter_places.push_back(name.place);
      }
    if (const auto reader = map_.find("tables"))
      system_.own.tables = read_tables(*reader, file_.folder);
    add(file_.names);
    add(system_.own);
  }

  void add(const ExpressionNamesSpec& names) {
    add_names(names, system_.text.parameters, system_.text.tables);
    for (const Place& place : names.parameter_places) parameters_.names.push_back(place);
    for (const TableSpec& table : names.tables) tables_.names.push_back(table.name.place);
  }

  void read_expressions(std::string_view key, std::vector<NamedExpression>& expressions,
                        SystemPartPlaces& places) {
    for_each_entry(map_, key, [&](const Name& name, const YamlReader& value) {
      auto text = read_expression(value);
      if (!text) return;
      expressions.push_back({name.value, text->text});
      places.names.push_back(name.place);
      places.texts.push_back(std::move(*text));
    });
  }

  /// Places for a message's part; null for the entire system.
  const SystemPartPlaces* places_of(Part part) const {
    switch (part) {
      case Part::kState:
        return &states_;
      case Part::kVelocity:
        return &velocities_;
      case Part::kControl:
        return &controls_;
      case Part::kParameter:
        return &parameters_;
      case Part::kTable:
        return &tables_;
      case Part::kDefinition:
        return &definitions_;
      case Part::kEquation:
        return &equations_;
      case Part::kRow:  // only in residuals
      case Part::kOperand:
      case Part::kWhole:
        break;
    }
    return nullptr;
  }

  void report(const ModelMessage& message, Severity severity) {
    const SystemPartPlaces* part = places_of(message.part);
    if (part == nullptr) return map_.reader().error(message.message.message, message.message.hint);
    if (!message.in_text)
      return out_.error(part->names[message.index], message.message.message, message.message.hint);
    report_expression(part->texts[message.index], message.message, severity, out_);
  }

  YamlMap& map_;
  const FileContext& file_;
  Diagnostics& out_;
  ExpressionSystemSpec& system_;
  SystemPartPlaces states_, velocities_, controls_, parameters_, tables_, definitions_, equations_;
};

}  // namespace

void read_expression_system(YamlMap& map, const FileContext& file, ExpressionSystemSpec& system) {
  ExpressionSystemReader(map, file, system).read();
}

}  // namespace conddp
