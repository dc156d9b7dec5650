#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/plant/shape_pairs.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

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

/// A choice of pairs, or pairs by name.
struct PairsForm {
  bool read(const YamlReader& reader, PairsSpec& pairs) const {
    pairs = {.place = reader.place()};
    if (reader.is_scalar())
      return WordForm(kPairsWords, "choice of pairs").read(reader, pairs.choice);
    const auto items = reader.items();
    if (!items) return false;
    if (items->empty()) reader.error("there is no pair", "write '[[forearm, table]]'");
    for (const YamlReader& item : *items) read_pair(item, pairs);
    return true;
  }
  std::optional<OrderedJson> expand(const PairsSpec& pairs) const {
    if (pairs.choice != PairsSpec::Choice::kNamed) return word_of(kPairsWords, pairs.choice);
    OrderedJson json = OrderedJson::array();
    for (const auto& [first, second] : pairs.named) json.push_back({first.value, second.value});
    return json;
  }
  OrderedJson schema(const PairsSpec& /*names the type*/, SchemaDefinitions& definitions) const {
    return defined(definitions, "shape_pairs", [] {
      OrderedJson pair = NamesForm().schema();
      pair.update({{"minItems", 2}, {"maxItems", 2}});
      return OrderedJson{
          {"title", "Pairs of shapes"},
          {"description",
           "Of distance: every shape against every obstacle, every two shapes but those on one "
           "link or on links that a joint connects (self), all of these, or pairs by name, where a "
           "name may have a *"},
          {"anyOf",
           {WordForm(kPairsWords, "").schema(),
            {{"type", "array"}, {"minItems", 1}, {"items", std::move(pair)}}}},
          {"examples",
           OrderedJson::parse(R"(["obstacles", [["forearm", "table"], ["hand", "*"]]])")}};
    });
  }
};

void name_pairs(CostSpec& cost, const TermContext& context) {
  Diagnostics found_when_built;
  PairsSpec pairs;
  for (const ShapePair& pair : shape_pairs(cost, context.spec, context.plant, found_when_built))
    pairs.named.push_back({Name{pair.first, {}}, Name{pair.second, {}}});
  cost.keys.set(key::pairs, std::move(pairs));
}

std::optional<CostResidual> make_distance(const ResidualContext& context) {
  std::vector<DistancePair> shapes;
  std::vector<std::string> names;
  for (const ShapePair& pair :
       shape_pairs(context.cost, context.spec, context.plant, context.out)) {
    shapes.push_back(pair.shapes);
    if (const double* margin = context.cost.keys.find(key::margin)) shapes.back().margin = *margin;
    const std::string name = pair.first + "-" + pair.second;
    if (pair.shapes.rows() == 1) {
      names.push_back(name);
      continue;
    }
    if (pair.shapes.rows() == 2) {
      names.push_back(name + "/from");
      names.push_back(name + "/to");
      continue;
    }
    for (int vertex = 1; vertex <= pair.shapes.rows(); ++vertex)
      names.push_back(fmt::format("{}/{}", name, vertex));
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

}  // namespace

std::span<const ResidualDefinition> distance_residuals() {
  static const ResidualKey pairs = [] {
    ResidualKey key =
        residual_key(key::pairs, {.says = "For distance: the shapes that must keep apart"},
                     PairsForm{}, {.required = true});
    key.complete = name_pairs;
    return key;
  }();
  static const ResidualKey margin = residual_key(
      key::margin,
      {.says = "For distance, instead of an activation or bounds: smaller distances cost "
               "quadratically or violate the constraint, m; 0 by default"},
      NumberForm{kNotNegative}, {.excludes = "activation"});
  static const ResidualDefinition all[] = {
      {.name = "distance",
       .description =
           "distances between convex bodies and half-spaces; negative where they overlap",
       .unit = "m",
       .synonyms = {"collision", "self_collision", "keep_out", "obstacle", "obstacles", "sdf"},
       .needs = {.robot = true, .shapes = true},
       .keys = {&pairs, &margin},
       .set_activation = set_margin,
       .make = make_distance}};
  return all;
}

}  // namespace conddp
