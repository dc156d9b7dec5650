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

/// Reads one moving number; nothing with an error if it is malformed.
std::optional<HomotopyKeySpec> read_homotopy_key(const YamlReader& reader) {
  YamlMap map(reader, "write '{key: constraints.torque.scale, from: 3, to: 1}'");
  const auto key = map.require("key"), from = map.require("from"), to = map.require("to");
  if (!key || !from || !to) return std::nullopt;
  const auto name = key->name();
  const auto first = from->number(), last = to->number();
  if (!name || !first || !last) return std::nullopt;
  if (*first == *last) to->error(fmt::format("from and to are both {}: nothing moves", *last));
  return HomotopyKeySpec{*name, {*first, from->place()}, {*last, to->place()}};
}

}  // namespace

std::vector<HomotopyKeySpec> read_homotopy(const YamlReader& reader) {
  std::vector<HomotopyKeySpec> keys;
  const auto items = reader.items("write '[{key: constraints.torque.scale, from: 3, to: 1}]'");
  if (!items) return keys;
  for (const YamlReader& item : *items) {
    auto key = read_homotopy_key(item);
    if (!key) continue;
    const auto is_same = [&](const HomotopyKeySpec& other) {
      return other.key.value == key->key.value;
    };
    if (std::any_of(keys.begin(), keys.end(), is_same))
      reader.diagnostics().error(
          key->key.place, fmt::format("the homotopy has the key '{}' twice", key->key.value));
    keys.push_back(*std::move(key));
  }
  return keys;
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
  const auto keys = read_homotopy(YamlReader(*list, "solver.homotopy", attempt));
  if (attempt.has_errors()) return;
  for (const HomotopyKeySpec& key : keys)
    if (YamlNode* node = find_number(root, key.key, out)) place(key, share, *node, out);
}

}  // namespace conddp
