#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// Reads a name, all numbers of a state, or a state.
void read_equilibrium(const YamlReader& reader, TerminalLqrSpec& lqr) {
  if (reader.is_sequence()) {
    lqr.state = {.place = reader.place(), .state = reader.numbers()};
  } else if (reader.is_map()) {
    lqr.state = read_state(reader).value_or(StateSpec{.place = reader.place()});
    if (lqr.state.previous_control)
      reader.diagnostics().error(lqr.state.previous_control->place,
                                 "the previous control is the one that holds the state",
                                 "leave the key out");
  } else {
    lqr.name = reader.name();
  }
}

/// True if the mapping has keys other than those of an equilibrium.
bool has_own_keys(const YamlReader& reader) {
  const auto has = [&](std::string_view key) { return reader.node().find(key) != nullptr; };
  return reader.is_map() && (has("about") || has("weight") || has("set"));
}

}  // namespace

TerminalLqrSpec read_terminal_lqr(const YamlReader& reader) {
  TerminalLqrSpec lqr{.place = reader.place()};
  if (!has_own_keys(reader)) {
    read_equilibrium(reader, lqr);
    return lqr;
  }
  YamlMap map(reader);
  if (const auto about = map.require("about")) read_equilibrium(*about, lqr);
  map.number("weight", lqr.weight, kPositive);
  if (const auto set = map.find("set")) {
    static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
    lqr.set = set->choice(kWords, "truth").value_or(false);
    lqr.set_place = set->place();
  }
  return lqr;
}

}  // namespace conddp
