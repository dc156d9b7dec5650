#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/values/expression_source.hpp"

namespace conddp {
namespace {

constexpr std::string_view kUnitQuaternion = "unit_quaternion", kPose = "pose";

/// Where the names and the texts of one part of a system stand.
struct SystemPartPlaces {
  std::vector<Place> names;
  std::vector<ExpressionText> texts;
};

/// Reads the keys of a system of expressions and puts its messages where they belong.
class ExpressionSystemReader {
 public:
  ExpressionSystemReader(YamlMap& map, ExpressionSystemSpec& system)
      : map_(map), out_(map.reader().diagnostics()), system_(system) {}

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
    read_columns("controls", system_.text.controls, controls_);
    read_parameters();
    read_tables();
    read_expressions("let", system_.text.definitions, definitions_);
    read_expressions(equations, system_.text.equations, equations_);
    if (out_.error_count() > errors) return;
    system_.parsed = make_expression_system(system_.text);
    for (const auto& message : system_.parsed.errors) report(message, Severity::kError);
    for (const auto& message : system_.parsed.warnings) report(message, Severity::kWarning);
  }

 private:
  using Part = ModelMessage::Part;

  bool second_order() const { return system_.text.kind == SystemKind::second_order; }

  /// The key of the equations, which says what kind of system it is.
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

  /// Names with a word each, from a mapping or, without words, from a list.
  std::vector<std::pair<Name, std::string>> named_words(const YamlReader& reader,
                                                        std::string_view without) {
    std::vector<std::pair<Name, std::string>> words;
    if (reader.is_sequence()) {
      const auto names = reader.names();
      if (!names) return words;
      for (const Name& name : *names) words.emplace_back(name, without);
      return words;
    }
    const auto entries = reader.named_entries("write {name: unit, ...} or [name, ...]");
    if (!entries) return words;
    for (const auto& [name, value] : *entries)
      if (auto word = value.text()) words.emplace_back(name, std::move(*word));
    return words;
  }

  void read_states(std::string_view key) {
    const auto reader = map_.require(key);
    if (!reader) return;
    for (const auto& [name, word] : named_words(*reader, "1")) {
      ExpressionState state{.name = name.value, .unit = word};
      if (word == kUnitQuaternion) state.kind = ExpressionState::Kind::kUnitQuaternion;
      if (word == kPose) state.kind = ExpressionState::Kind::kPose;
      if (state.kind != ExpressionState::Kind::kNumber) {
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
    for (const auto& [name, word] : named_words(*reader, "1")) {
      columns.push_back({name.value, word});
      places.names.push_back(name.place);
    }
  }

  void read_parameters() {
    const auto reader = map_.find("parameters");
    if (!reader) return;
    for (const auto& [name, value] : read_named_numbers(*reader)) {
      system_.text.parameters.emplace_back(name.value, value);
      parameters_.names.push_back(name.place);
    }
  }

  void read_tables() {
    const auto reader = map_.find("tables");
    const auto entries = reader ? reader->named_entries() : std::nullopt;
    if (!entries) return;
    for (const auto& [name, value] : *entries) {
      TableSpec table{.name = name.value};
      YamlMap keys(value);
      const auto points = keys.require("points"), values = keys.require("values");
      if (!points || !values || !read_grid(*points, table) || !read_values(*values, table))
        continue;
      try {
        const auto made =
            table.points.size() == 1
                ? std::make_shared<SplineTable>(table.points[0], table.values)
                : std::make_shared<SplineTable>(table.points[0], table.points[1], table.values);
        system_.text.tables.emplace_back(name.value, made);
        tables_.names.push_back(name.place);
        system_.tables.push_back(std::move(table));
      } catch (const std::invalid_argument& e) {
        value.error(e.what());
      }
    }
  }

  /// Ascending numbers, or two lists of them.
  bool read_grid(const YamlReader& reader, TableSpec& table) {
    const auto items = reader.items("write ascending numbers, or two lists of them");
    if (!items) return false;
    if (!items->empty() && !items->front().is_sequence()) {
      const auto numbers = reader.numbers();
      if (numbers) table.points = {*numbers};
      return numbers.has_value();
    }
    constexpr std::size_t kMostArguments = 2;
    if (items->size() != kMostArguments)
      return reader.error("a table has the points of one argument or of two"), false;
    for (const YamlReader& item : *items) {
      const auto numbers = item.numbers();
      if (!numbers) return false;
      table.points.push_back(*numbers);
    }
    return true;
  }

  bool read_values(const YamlReader& reader, TableSpec& table) {
    if (table.points.size() == 1) {
      const auto numbers = reader.numbers(table.points[0].size(), "one a point");
      if (numbers) table.values = *numbers;
      return numbers.has_value();
    }
    const auto rows = reader.items("write a list for each point of the first argument");
    if (!rows) return false;
    if (rows->size() != table.points[0].size())
      return reader.error(fmt::format("the first argument has {} points, and there are {} rows",
                                      table.points[0].size(), rows->size())),
             false;
    for (const YamlReader& row : *rows) {
      const auto numbers =
          row.numbers(table.points[1].size(), "one a point of the second argument");
      if (!numbers) return false;
      table.values.insert(table.values.end(), numbers->begin(), numbers->end());
    }
    return true;
  }

  void read_expressions(std::string_view key, std::vector<NamedExpression>& expressions,
                        SystemPartPlaces& places) {
    const auto reader = map_.find(key);
    const auto entries = reader ? reader->named_entries() : std::nullopt;
    if (!entries) return;
    for (const auto& [name, value] : *entries)
      if (auto text = read_expression(value)) {
        expressions.push_back({name.value, text->text});
        places.names.push_back(name.place);
        places.texts.push_back(std::move(*text));
      }
  }

  void report(const ModelMessage& message, Severity severity) {
    const SystemPartPlaces* part = nullptr;
    switch (message.part) {
      case Part::kState:
        part = &states_;
        break;
      case Part::kVelocity:
        part = &velocities_;
        break;
      case Part::kControl:
        part = &controls_;
        break;
      case Part::kParameter:
        part = &parameters_;
        break;
      case Part::kTable:
        part = &tables_;
        break;
      case Part::kDefinition:
        part = &definitions_;
        break;
      case Part::kEquation:
        part = &equations_;
        break;
      case Part::kRow:  // of residuals alone
      case Part::kWhole:
        return map_.reader().error(message.message.message, message.message.hint);
    }
    if (!message.in_text)
      return out_.error(part->names[message.index], message.message.message, message.message.hint);
    report_expression(part->texts[message.index], message.message, severity, out_);
  }

  YamlMap& map_;
  Diagnostics& out_;
  ExpressionSystemSpec& system_;
  SystemPartPlaces states_, velocities_, controls_, parameters_, tables_, definitions_, equations_;
};

}  // namespace

void read_expression_system(YamlMap& map, ExpressionSystemSpec& system) {
  ExpressionSystemReader(map, system).read();
}

}  // namespace conddp
