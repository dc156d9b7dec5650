#include "problem_file/lower/homotopy_numbers.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text/strict_number.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

/// The node of a key; null with an error if it cannot be a number. Missing nodes with a default are
/// created.
YamlNode* find_number(YamlNode& root, const Name& key, Diagnostics& out) {
  const Place place{key.place.mark, key.value};
  const std::string_view section = first_step(key.value);
  if (!is_of_the_problem(section) || section == "conddp") {
    out.error(place, fmt::format("'{}' is not a number of the problem itself", key.value),
              "a homotopy moves what the motion depends on: weights, limits, robots, phases");
    return nullptr;
  }
  YamlNode* node = find_node(root, key, Missing::kValue, out);
  if (node == nullptr) return nullptr;
  if (node->kind == YamlNode::Kind::kNull || YamlReader(*node, key.value, out).is_number())
    return node;
  out.error(place, fmt::format("'{}' is {} and no number", key.value, kind_name(*node)),
            "the key of a homotopy leads to one number");
  return nullptr;
}

double between(double from, double to, double share) {
  if (share == 1) return to;
  return from * to > 0 ? from * std::pow(to / from, share) : from + share * (to - from);
}

}  // namespace

void describe(Keys& keys, HomotopyKeySpec& moved) {
  keys.about({.title = "A number that moves",
              .examples = R"([{"key": "constraints.torque.scale", "from": 3, "to": 1}])"});
  const int errors = keys.errors();
  keys({.name = "key",
        .says = "Path of a number of the problem, as --set takes it",
        .required = true},
       moved.key, NameForm{});
  keys({.name = "from",
        .says = "Its value where the homotopy begins, in the unit of the key",
        .required = true},
       moved.from, NumberForm{});
  keys({.name = "to",
        .says = "Its value where it ends: that of the problem, whatever stands at the key; in the "
                "unit of the key",
        .required = true},
       moved.to, NumberForm{});
  if (const auto to = keys.found("to");
      to && keys.errors() == errors && moved.from.value == moved.to.value)
    to->error(fmt::format("from and to are both {}: nothing moves", moved.to.value));
}

bool HomotopyForm::read(const YamlReader& reader, std::vector<HomotopyKeySpec>& keys) const {
  const auto items = reader.items("write '[{key: constraints.torque.scale, from: 3, to: 1}]'");
  if (!items) return false;
  for (const YamlReader& item : *items) {
    HomotopyKeySpec moved;
    read_map(item, moved, "write '{key: constraints.torque.scale, from: 3, to: 1}'");
    const bool stands = std::ranges::any_of(
        keys, [&](const HomotopyKeySpec& other) { return other.key.value == moved.key.value; });
    if (stands && !moved.key.value.empty())
      reader.diagnostics().error(
          moved.key.place, fmt::format("the homotopy has the key '{}' twice", moved.key.value));
    keys.push_back(std::move(moved));
  }
  return true;
}

namespace {

/// The homotopy of a document, or null.
YamlNode* homotopy_of(YamlNode& root) {
  YamlNode* solver = find_part(root, "solver");
  return solver != nullptr ? find_part(*solver, "homotopy") : nullptr;
}

/// Replaces a number of the document by its value on the path. Warns if the document's number
/// differs from the final value.
void place(const HomotopyKeySpec& key, double share, YamlNode& node, Diagnostics& out) {
  const double from = key.from.value, to = key.to.value;
  if (node.kind == YamlNode::Kind::kScalar && parse_number(node.text).value != to)
    out.warning({node.mark, key.key.value},
                fmt::format("{} has no effect: a homotopy moves this number to {}", node.text, to),
                "write that number here, too");
  node = {.kind = YamlNode::Kind::kScalar,
          .mark = key.to.place.mark,
          .text = fmt::format("{}", between(from, to, share))};
}

}  // namespace

void place_homotopy(YamlNode& root, double share, Diagnostics& out) {
  const YamlNode* list = homotopy_of(root);
  if (list == nullptr) return;
  Diagnostics attempt = out;
  std::vector<HomotopyKeySpec> keys;
  HomotopyForm().read(YamlReader(*list, "solver.homotopy", attempt), keys);
  if (attempt.has_errors()) return;
  for (const HomotopyKeySpec& key : keys)
    if (YamlNode* node = find_number(root, key.key, out)) place(key, share, *node, out);
}

}  // namespace conddp
