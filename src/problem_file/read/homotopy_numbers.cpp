#include "problem_file/read/homotopy_numbers.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/spelling.hpp"
#include "base/strict_number.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_override.hpp"

namespace conddp {
namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> steps;
  for (std::size_t start = 0; start <= path.size();) {
    const std::size_t end = std::min(path.find('.', start), path.size());
    steps.push_back(path.substr(start, end - start));
    start = end + 1;
  }
  return steps;
}

/// The node of a key; nothing with an error where it cannot be a number. One that the document
/// leaves to its default is created.
YamlNode* find_number(YamlNode& root, const Name& key, Diagnostics& out) {
  const std::vector<std::string> steps = split(key.value);
  const Place place{key.place.mark, key.value};
  if (!is_of_the_problem(steps.front()) || steps.front() == "conddp") {
    out.error(place, fmt::format("'{}' is not a number of the problem itself", key.value),
              "a homotopy moves what the motion depends on: weights, limits, robots, phases");
    return nullptr;
  }
  YamlNode* node = &root;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    YamlNode* part = find_part(*node, steps[i]);
    const bool is_map = node->kind == YamlNode::Kind::kMap;
    if (part == nullptr && is_map && i > 0 && i + 1 == steps.size() && !steps[i].empty()) {
      node->entries.push_back({steps[i], place.mark, {.mark = place.mark}});
      return &node->entries.back().value;
    }
    if (part == nullptr) {
      std::vector<std::string> names;
      if (is_map)
        for (const YamlNode::Entry& entry : node->entries) names.push_back(entry.key);
      out.error(place, fmt::format("the file has no '{}': there is no '{}'", key.value, steps[i]),
                is_map ? name_hint(steps[i], names, "keys there")
                       : fmt::format("there is {}", kind_name(*node)),
                names);
      return nullptr;
    }
    node = part;
  }
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

std::vector<HomotopyKeySpec> read_homotopy(const YamlReader& reader) {
  std::vector<HomotopyKeySpec> keys;
  const auto items = reader.items("write '[{key: constraints.torque.scale, from: 3, to: 1}]'");
  if (!items) return keys;
  for (const YamlReader& item : *items) {
    YamlMap map(item, "write '{key: constraints.torque.scale, from: 3, to: 1}'");
    const auto key = map.require("key"), from = map.require("from"), to = map.require("to");
    if (!key || !from || !to) continue;
    const auto name = key->name();
    const auto first = from->number(), last = to->number();
    if (!name || !first || !last) continue;
    if (*first == *last) to->error(fmt::format("from and to are both {}: nothing moves", *last));
    if (std::any_of(keys.begin(), keys.end(),
                    [&](const HomotopyKeySpec& other) { return other.key.value == name->value; }))
      key->error(fmt::format("the homotopy has the key '{}' twice", name->value));
    keys.push_back({*name, {*first, from->place()}, {*last, to->place()}});
  }
  return keys;
}

void place_homotopy(YamlNode& root, double share, Diagnostics& out) {
  YamlNode* list = find_part(root, "solver");
  if (list != nullptr) list = find_part(*list, "homotopy");
  if (list == nullptr) return;
  Diagnostics attempt = out;
  const auto keys = read_homotopy(YamlReader(*list, "solver.homotopy", attempt));
  if (attempt.has_errors()) return;
  for (const HomotopyKeySpec& key : keys) {
    YamlNode* node = find_number(root, key.key, out);
    if (node == nullptr) continue;
    const double from = key.from.value, to = key.to.value;
    const auto before = parse_number(node->text).value;
    if (node->kind == YamlNode::Kind::kScalar && before != to)
      out.warning(
          {node->mark, key.key.value},
          fmt::format("{} does not count: a homotopy takes this number to {}", node->text, to),
          "write that number here, too");
    *node = {.kind = YamlNode::Kind::kScalar,
             .mark = key.to.place.mark,
             .text = fmt::format("{}", between(from, to, share))};
  }
}

}  // namespace conddp
