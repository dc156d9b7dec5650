#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/data/library_file.hpp"
#include "problem_file/read/named_words.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "systems/clock.hpp"
#include "systems/expressions/scope.hpp"

namespace conddp {
namespace {

/// Reads the keys of a system of a compiled function.
class LibrarySystemReader {
 public:
  LibrarySystemReader(YamlMap& map, LibrarySystemSpec& system) : map_(map), system_(system) {}

  void read() {
    LibrarySystemColumns& columns = system_.columns;
    map_.require("library");
    map_.require("function");
    map_.name("library", system_.function.library);
    map_.name("function", system_.function.function);
    map_.choice("gives", columns.kind, kLibraryAnswerWords, "answer of a function");
    const bool second_order = columns.kind == SystemKind::second_order;
    for (const std::string_view key : {"positions", "velocities", "states"})
      if ((key == "states") == second_order) exclude(key);
    system_.states_place = read_columns(second_order ? "positions" : "states", columns.states);
    if (second_order) read_velocities();
    system_.controls_place = read_columns("controls", columns.controls);
    system_.function.parameters_place = map_.reader().place();
    const auto parameters = map_.find("parameters");
    if (!parameters) return;
    system_.function.parameters_place = parameters->place();
    system_.function.parameters = read_named_numbers(*parameters);
  }

 private:
  void exclude(std::string_view key) {
    if (const auto reader = map_.find(key))
      reader->error(fmt::format("'{}' does not go with what the function gives", key),
                    "write 'gives: acceleration' for 'positions' and 'velocities', or 'gives: "
                    "rate' or 'gives: next' for 'states'");
  }

  /// Reads columns and returns their place.
  Place read_columns(std::string_view key, std::vector<Column>& columns) {
    const auto reader = map_.require(key);
    if (!reader) return map_.reader().place();
    for (const auto& [name, unit] : read_named_words(*reader)) {
      add_name(name);
      columns.push_back({name.value, unit});
    }
    return reader->place();
  }

  void read_velocities() {
    const Place place = read_columns("velocities", system_.columns.velocities);
    const std::size_t positions = system_.columns.states.size();
    const std::size_t velocities = system_.columns.velocities.size();
    if (positions != velocities && map_.valid())
      map_.reader().diagnostics().error(
          place,
          fmt::format("there are {} and {}",
                      velocities == 1 ? "1 velocity" : fmt::format("{} velocities", velocities),
                      counted(positions, "position")),
          "each position has a velocity, in the same order");
  }

  /// Requires names that are valid in expressions, because costs and constraints use expressions.
  void add_name(const Name& name) {
    const bool is_clock = name.value == kClock || name.value == kClockRate;
    const std::string defect = is_clock ? fmt::format("'{}' is the name of the clock", name.value)
                                        : names_.defect_of(name.value);
    if (!defect.empty()) return map_.reader().diagnostics().error(name.place, defect);
    names_.add(name.value, ExpressionValue::vector({}));
  }

  YamlMap& map_;
  LibrarySystemSpec& system_;
  ExpressionScope names_;
};

}  // namespace

void read_library_system(YamlMap& map, const std::filesystem::path& folder,
                         LibrarySystemSpec& system) {
  Diagnostics& out = map.reader().diagnostics();
  const int errors = out.error_count();
  LibrarySystemReader(map, system).read();
  if (out.error_count() == errors)
    system.loaded = load_library_file(folder, system.function.library, out);
}

}  // namespace conddp
