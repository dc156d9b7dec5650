#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// A name, all numbers of a state, or a state.
struct EquilibriumForm {
  bool read(const YamlReader& reader, TerminalLqrSpec& lqr) const {
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
    return true;
  }
  std::optional<OrderedJson> expand(const TerminalLqrSpec& lqr) const {
    return lqr.name ? OrderedJson(lqr.name->value) : expand_map(lqr.state);
  }
  OrderedJson schema(const TerminalLqrSpec& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return defined(definitions, "equilibrium", [&] {
      return OrderedJson{
          {"title", "Equilibrium"},
          {"description",
           "A state at rest that controls and contacts can hold: a configuration, initial, all "
           "numbers of the state, or a state"},
          {"anyOf",
           {NameForm().schema(), NumbersForm().schema(), map_schema<StateSpec>(definitions)}},
          {"examples", OrderedJson::parse(
                           R"(["standing", [0, 3.1416, 0, 0], {"values": {"theta": 3.1416}}])")}};
    });
  }
};

/// True if the mapping has keys other than those of an equilibrium.
bool has_own_keys(const YamlReader& reader) {
  return reader.has("about") || reader.has("weight") || reader.has("set");
}

}  // namespace

static void describe(Keys& keys, TerminalLqrSpec& lqr) {
  keys.about({.title = "Terminal cost of a regulator",
              .examples = R"([{"about": "standing", "set": true}])"});
  keys({.name = "about", .says = "The equilibrium", .required = true}, lqr, EquilibriumForm{});
  keys({"weight", "Factor of the cost, without unit; 1 is the cost-to-go itself"}, lqr.weight,
       NumberForm{kPositive});
  keys({"set",
        "The last state has to lie in the largest set (x ⊖ x̄)ᵀP(x ⊖ x̄) ≤ level in which the "
        "regulator satisfies bounds and constraints"},
       lqr.set, FlagForm{"truth"});
  if (const auto set = keys.found("set")) lqr.set_place = set->place();
}

bool LqrForm::read(const YamlReader& reader, TerminalLqrSpec& lqr) const {
  lqr.place = reader.place();
  return has_own_keys(reader) ? read_map(reader, lqr) : EquilibriumForm().read(reader, lqr);
}

std::optional<OrderedJson> LqrForm::expand(const TerminalLqrSpec& lqr) const {
  return expand_map(lqr);
}

OrderedJson LqrForm::schema(const TerminalLqrSpec& value, SchemaDefinitions& definitions) const {
  return defined(definitions, "terminal_lqr", [&] {
    return OrderedJson{
        {"title", "Regulator about an equilibrium"},
        {"description", "The equilibrium, or that with a weight"},
        {"anyOf",
         {EquilibriumForm().schema(value, definitions), map_schema<TerminalLqrSpec>(definitions)}},
        {"examples", OrderedJson::parse(R"(["standing", {"about": "standing", "weight": 1.1}])")}};
  });
}

}  // namespace conddp
