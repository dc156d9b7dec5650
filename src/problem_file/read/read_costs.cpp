#include <algorithm>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/values/activation_table.hpp"

namespace conddp {
namespace {

std::vector<Located<int>> read_knots(const YamlReader& reader) {
  std::vector<Located<int>> knots;
  const auto items = reader.items();
  if (items && items->empty())
    reader.error("an empty list names no knot", "leave the key out for all knots");
  if (items)
    for (const YamlReader& item : *items)
      if (const auto knot = item.integer(0, 1'000'000)) {
        for (const Located<int>& former : knots)
          if (former.value == *knot) item.error(fmt::format("{} stands twice in the list", *knot));
        knots.push_back({static_cast<int>(*knot), item.place()});
      }
  return knots;
}

/// Reads the weights of residual rows: component weights or a matrix.
void read_weights(YamlMap& map, CostSpec& cost) {
  map.exclusive({"weights", "matrix"});
  if (const auto r = map.find("weights")) cost.weights = read_components(*r, kNotNegative);
  const auto r = map.find("matrix");
  if (!r) return;
  cost.matrix = read_symmetric_matrix(*r);
  if (cost.activation.kind != ActivationKind::quadratic)
    r->error(fmt::format("'matrix' belongs to the activation 'quadratic', and this cost has '{}'",
                         activation_definition(cost.activation.kind).name),
             "write 'weights', one per row");
}

/// Reads the activation, or sets the residual's default.
void read_activation_of(YamlMap& map, CostSpec& cost) {
  const ResidualDefinition& definition = *cost.definition;
  const auto activation = map.find("activation");
  if (activation && !definition.is_cone) {
    cost.activation = read_activation(*activation);
    return;
  }
  if (definition.set_activation != nullptr) definition.set_activation(cost);
  if (activation)
    activation->error("a cone has its own bounds, outside of which it costs: it has no activation",
                      "leave the key out");
}

CostSpec read_cost(const Name& name, const YamlReader& reader, const std::filesystem::path& folder,
                   bool terminal) {
  CostSpec cost{.name = name};
  YamlMap map(reader,
              "write '{residual: control}', or of an expression to be minimized as it is "
              "'{residual: expression, rows: u^2, activation: linear}'");
  if (!map.valid() || !read_residual(map, folder, {.last_node = terminal}, cost)) return cost;
  map.number("weight", cost.weight, kNotNegative);
  read_activation_of(map, cost);
  read_weights(map, cost);
  return cost;
}

/// Reads the reference of the residual.
void read_origin(YamlMap& map, const std::filesystem::path& folder, CostSpec& cost) {
  const auto r = map.find("reference");
  if (!r) return;
  if (cost.definition->reference != nullptr)
    cost.reference = read_reference(*r, cost, folder);
  else
    r->error(fmt::format("the residual '{}' has no reference", cost.definition->name));
}

/// Reads the phases, knots and nodes of a cost or constraint.
void read_where(YamlMap& map, TermPlace place, CostSpec& cost) {
  if (const auto r = map.find("phases")) cost.phases = read_phase_names(*r);
  if (const auto r = map.find("knots")) cost.knots = read_knots(*r);
  if (!place.constraint) return;
  map.exclusive({"knots", "nodes"});
  read_nodes(map, cost);
}

}  // namespace

std::optional<std::vector<Name>> read_phase_names(const YamlReader& reader) {
  auto names = reader.name_or_names();
  if (names && names->empty())
    reader.error("an empty list names no phase", "leave the key out for all phases");
  return names;
}

void read_nodes(YamlMap& map, CostSpec& function) {
  const auto r = map.find("nodes");
  if (!r) return;
  function.ends = {r->choice(kNodesWords, "kind of nodes").value_or(false), r->place()};
}

bool read_residual(YamlMap& map, const std::filesystem::path& folder, TermPlace place,
                   CostSpec& cost) {
  if (!read_residual_keys(map, place, cost)) return false;
  const ResidualDefinition& definition = *cost.definition;
  read_origin(map, folder, cost);
  if (!place.last_node)
    read_where(map, place, cost);
  else if (!definition.at_last_node())
    map.find("residual")
        ->error(
            fmt::format("the residual '{}' needs a control, and there is none at the terminal node",
                        definition.name));
  return true;
}

namespace {

YamlNode text_node(std::string text, const Mark& mark) {
  return {.kind = YamlNode::Kind::kScalar, .mark = mark, .text = std::move(text)};
}

CostSpec read_integral(const Name& name, const YamlReader& reader,
                       const std::filesystem::path& folder) {
  YamlNode node = reader.node();
  if (reader.is_scalar()) {
    node = {.kind = YamlNode::Kind::kMap, .mark = reader.node().mark};
    node.entries.push_back({"rows", node.mark, reader.node()});
  }
  if (node.kind == YamlNode::Kind::kMap && node.find("residual") == nullptr)
    node.entries.push_back({"residual", node.mark, text_node("expression", node.mark)});
  CostSpec integral{.name = name};
  YamlMap map(YamlReader(node, reader.place().path, reader.diagnostics()),
              "write an expression, as 'energy: u*v'");
  if (!map.valid() || !read_residual(map, folder, {}, integral)) return integral;
  if (integral.knots)
    map.reader().error("an integral grows at all knots of its phases", "leave 'knots' out");
  if (integral.reference || integral.residual.value != "expression")
    map.reader().error("an integral is an expression, without a reference",
                       "write it as 'rows', and other residuals below 'of'");
  return integral;
}

}  // namespace

std::vector<CostSpec> read_integrals(const YamlReader& reader,
                                     const std::filesystem::path& folder) {
  std::vector<CostSpec> integrals;
  if (const auto entries = reader.named_entries("write '{energy: u*v}'"))
    for (const auto& [name, value] : *entries)
      integrals.push_back(read_integral(name, value, folder));
  return integrals;
}

std::vector<CostSpec> read_costs(const YamlReader& reader, const std::filesystem::path& folder,
                                 bool terminal) {
  std::vector<CostSpec> costs;
  if (const auto entries = reader.named_entries("write '{effort: {residual: control}}'"))
    for (const auto& [name, value] : *entries)
      costs.push_back(read_cost(name, value, folder, terminal));
  return costs;
}

}  // namespace conddp
