#include <fmt/format.h>

#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/key_kinds.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {
namespace {

void read_pair(const YamlReader& reader, PairsSpec& pairs) {
  if (!reader.is_sequence())
    return reader.expected("a pair of shapes", "write '[[forearm, table]]'");
  const auto names = reader.names();
  if (!names) return;
  if (names->size() == 2)
    pairs.named.push_back({(*names)[0], (*names)[1]});
  else
    reader.error(fmt::format("a pair has two names, this list {}", names->size()));
}

PairsSpec read_pairs(const YamlReader& reader) {
  PairsSpec pairs{.place = reader.place()};
  if (reader.is_scalar()) {
    pairs.choice = reader.choice(kPairsWords, "choice of pairs").value_or(pairs.choice);
    return pairs;
  }
  const auto items = reader.items();
  if (!items) return pairs;
  if (items->empty()) reader.error("there is no pair", "write '[[forearm, table]]'");
  for (const YamlReader& item : *items) read_pair(item, pairs);
  return pairs;
}

std::optional<CostResidual> make_distance(const ResidualContext& context) {
  std::vector<DistancePair> shapes;
  std::vector<std::string> names;
  for (const ShapePair& pair :
       shape_pairs(context.cost, context.spec, context.plant, context.out)) {
    shapes.push_back(pair.shapes);
    const std::string name = pair.first + "-" + pair.second;
    if (pair.shapes.rows() == 1) {
      names.push_back(name);
      continue;
    }
    names.push_back(name + "/from");
    names.push_back(name + "/to");
  }
  if (shapes.empty()) return std::nullopt;
  CostResidual result;
  result.residual = distance_residual(context.plant.multibody(), shapes);
  result.rows = {"distances", names};
  return result;
}

/// The default activation of distances is a barrier at the margin.
void set_margin(CostSpec& cost) {
  const double margin = cost.keys.value(key::margin);
  cost.keys.set(key::margin, margin);
  cost.activation.kind = ActivationKind::quadratic_barrier;
  cost.activation.place = cost.residual.place;
  cost.activation.lower = {.place = cost.residual.place, .scalar = margin};
}

ResidualKey margin_key() {
  ResidualKey margin =
      number_key(key::margin,
                 "For distance, instead of an activation or bounds: smaller distances cost "
                 "quadratically or violate the constraint, m; 0 by default",
                 kNotNegative, {.excludes = "activation"});
  // The key is omitted next to an activation; a constraint's margin becomes its lower bound.
  margin.schema.erase("default");
  margin.expand = [](const CostSpec& cost, const KeyContext& context) {
    const double* given = cost.keys.find(key::margin);
    return given != nullptr && !context.place.constraint ? OrderedJson(*given)
                                                         : OrderedJson(nullptr);
  };
  return margin;
}

}  // namespace

std::span<const ResidualDefinition> distance_residuals() {
  static const ResidualKey pairs = {"pairs",
                                    "For distance: the shapes that must keep apart",
                                    defined_schema("shape_pairs"),
                                    {.required = true},
                                    [](const YamlReader& reader, CostSpec& cost) {
                                      cost.keys.set(key::pairs, read_pairs(reader));
                                    },
                                    [](const CostSpec& cost, const KeyContext& context) {
                                      Diagnostics found_when_built;
                                      OrderedJson json = OrderedJson::array();
                                      for (const ShapePair& pair : shape_pairs(
                                               cost, context.spec, context.plant, found_when_built))
                                        json.push_back({pair.first, pair.second});
                                      return json;
                                    }};
  static const ResidualKey margin = margin_key();
  static const ResidualDefinition all[] = {
      {.name = "distance",
       .description =
           "distances between spheres, capsules and half-spaces; negative where they overlap",
       .unit = "m",
       .synonyms = {"collision", "self_collision", "keep_out", "obstacle", "obstacles", "sdf"},
       .needs = {.robot = true, .shapes = true},
       .keys = {&pairs, &margin},
       .set_activation = set_margin,
       .make = make_distance}};
  return all;
}

}  // namespace conddp
