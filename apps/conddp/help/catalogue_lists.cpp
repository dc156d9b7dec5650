#include "help/catalogue_lists.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "arguments/example_problems.hpp"
#include "help/embedded_schemas.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/spec/residual_kind.hpp"
#include "solvers/common/option_table.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

const OrderedJson& definitions() {
  static const OrderedJson schema = OrderedJson::parse(find_schema("problem")->text);
  return schema.at("definitions");
}

/// A key of an object in the problem file's schema.
OrderedJson key(const OrderedJson& object, const std::string& name, bool required = false) {
  const OrderedJson& schema = object.at("properties").at(name);
  OrderedJson entry = {
      {"name", name}, {"description", schema.at("description")}, {"required", required}};
  if (schema.contains("default")) entry["default"] = schema["default"];
  return entry;
}

OrderedJson list_solvers() {
  OrderedJson list = OrderedJson::array();
  list.push_back({{"name", kAutoSolver},
                  {"description",
                   "the default: one of these by the problem, and others where it "
                   "does not converge; conddp check says which"}});
  for (const SolverInfo& info : solvers()) {
    const char* bounds = info.control_bounds == BoundSupport::exact     ? "exact"
                         : info.control_bounds == BoundSupport::clipped ? "clipped"
                                                                        : "refused";
    OrderedJson hessians = OrderedJson::array();
    if (info.gauss_newton_hessian) hessians.push_back("gauss_newton");
    if (info.exact_hessian) hessians.push_back("exact");
    list.push_back({{"name", info.name},
                    {"description", info.description},
                    {"control_bounds", bounds},
                    {"starts_from", info.open_gaps ? "states and controls" : "controls"},
                    {"hessian", std::move(hessians)}});
  }
  return list;
}

OrderedJson list_options() {
  OrderedJson list = OrderedJson::array();
  for (const OptionInfo& info : option_table()) {
    OrderedJson entry = {{"name", info.name}, {"description", info.doc}};
    std::visit([&](const auto& value) { entry["default"] = value; }, info.default_value());
    if (entry["default"].is_number_float() && !std::isfinite(entry["default"].get<double>()))
      entry["default"] = nullptr;
    if (info.choices.empty()) {
      entry[info.min_excluded ? "more_than" : "at_least"] = info.min;
      if (std::isfinite(info.max)) entry[info.max_excluded ? "less_than" : "at_most"] = info.max;
    } else {
      entry["choices"] = info.choices;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

OrderedJson list_residuals() {
  const OrderedJson& cost = definitions().at("cost");
  OrderedJson list = OrderedJson::array();
  for (const ResidualInfo& info : residual_table()) {
    OrderedJson keys = OrderedJson::array();
    if (info.needs_frame) keys.push_back(key(cost, "frame", true));
    if (info.takes_joints) keys.push_back(key(cost, "joints"));
    if (info.takes_columns) keys.push_back(key(cost, "columns"));
    if (info.takes_axes) keys.push_back(key(cost, "axes"));
    if (info.takes_reference) keys.push_back(key(cost, "reference"));
    list.push_back({{"name", info.name},
                    {"description", info.description},
                    {"needs_robot", info.needs_robot},
                    {"at_terminal_node", !info.needs_control},
                    {"keys", std::move(keys)}});
  }
  return list;
}

OrderedJson list_activations() {
  const OrderedJson& activation = definitions().at("activation").at("anyOf").at(1);
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kActivationWords) {
    OrderedJson keys = OrderedJson::array();
    if (takes_bounds(choice.value))
      for (const char* name : {"lower", "upper", "from"}) keys.push_back(key(activation, name));
    if (takes_epsilon(choice.value)) keys.push_back(key(activation, "epsilon"));
    list.push_back(
        {{"name", choice.word}, {"description", choice.description}, {"keys", std::move(keys)}});
  }
  return list;
}

OrderedJson list_systems() {
  OrderedJson list = OrderedJson::array();
  for (const OrderedJson& system : definitions().at("system").at("oneOf")) {
    const OrderedJson& type = system.at("properties").at("type");
    const OrderedJson& required = system.at("required");
    OrderedJson keys = OrderedJson::array();
    for (const auto& [name, schema] : system.at("properties").items())
      if (name != "type")
        keys.push_back(
            key(system, name, std::find(required.begin(), required.end(), name) != required.end()));
    list.push_back({{"name", type.at("const")},
                    {"description", type.at("description")},
                    {"keys", std::move(keys)}});
  }
  return list;
}

OrderedJson list_integrators() {
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kIntegratorWords)
    list.push_back({{"name", choice.word}, {"description", choice.description}});
  return list;
}

OrderedJson list_constraints() {
  const OrderedJson& constraint = definitions().at("constraint");
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kBoundedWords) {
    OrderedJson keys = OrderedJson::array();
    for (const auto& [name, schema] : constraint.at("properties").items())
      if (name != "bounds") keys.push_back(key(constraint, name));
    list.push_back(
        {{"name", choice.word}, {"description", choice.description}, {"keys", std::move(keys)}});
  }
  return list;
}

OrderedJson list_problems() {
  OrderedJson list = OrderedJson::array();
  for (const std::filesystem::path& file : example_problems()) {
    std::string summary = example_summary(file);
    if (summary.empty()) summary = "(nothing is said at its head)";
    list.push_back(
        {{"name", file.stem().string()}, {"description", summary}, {"file", file.string()}});
  }
  return list;
}

constexpr ListKind kKinds[] = {
    {"solvers", "solver: {name: ...}, or --solver", list_solvers},
    {"options", "solver: {option: ..., group: {option: ...}}", list_options},
    {"residuals", "costs: {NAME: {residual: ...}}", list_residuals},
    {"activations", "costs: {NAME: {activation: ...}}, with keys {activation: {kind: ...}}",
     list_activations},
    {"systems", "system: {type: ...}", list_systems},
    {"integrators", "integrator: ...", list_integrators},
    {"constraints", "constraints: {NAME: {bounds: ...}}", list_constraints},
    {"problems", "examples: conddp solve NAME, conddp bench", list_problems},
};

}  // namespace

std::span<const ListKind> list_kinds() { return kKinds; }

}  // namespace conddp
