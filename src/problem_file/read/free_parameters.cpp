#include "problem_file/read/free_parameters.hpp"

#include <fmt/format.h>

#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

YamlNode scalar_node(std::string text, const Mark& mark) {
  return {.kind = YamlNode::Kind::kScalar, .mark = mark, .text = std::move(text)};
}

/// That of a mapping, which gets an empty one where it has none.
YamlNode& map_part(YamlNode& node, const std::string& key) {
  YamlNode* found = find_part(node, key);
  if (found == nullptr) {
    node.kind = YamlNode::Kind::kMap;
    node.entries.push_back({key, node.mark, {.kind = YamlNode::Kind::kMap, .mark = node.mark}});
    found = &node.entries.back().value;
  }
  return *found;
}

/// Writes one parameter into a document.
class FreeParameterPlacer {
 public:
  FreeParameterPlacer(const FreeParameter& parameter, YamlNode& root, Diagnostics& out)
      : parameter_(parameter), root_(root), out_(out) {}

  /// False where there is no system that could have it.
  bool place() {
    if (!add_to_systems()) return false;
    add_to_initial_state();
    add_to_choice();
    return true;
  }

 private:
  const Mark& mark() const { return parameter_.name.place.mark; }
  const std::string& name() const { return parameter_.name.value; }
  void fail(std::string message, std::string hint) const {
    out_.error(parameter_.name.place, std::move(message), std::move(hint));
  }
  void add(YamlNode& map, std::string text) const {
    map.entries.push_back({name(), mark(), scalar_node(std::move(text), mark())});
  }
  void add(YamlNode& map, double number) const { add(map, fmt::format("{}", number)); }

  bool add_to_systems() const {
    bool all = false;
    if (YamlNode* system = find_part(root_, "system")) all = add_to_system(*system);
    if (YamlNode* systems = find_part(root_, "systems")) {
      all = !systems->entries.empty();
      for (YamlNode::Entry& entry : systems->entries) all &= add_to_system(entry.value);
    }
    if (!all)
      fail(fmt::format("'{}' is free, and free parameters are those of equations of first order "
                       "or of differences",
                       name()),
           "they need 'system: {states, controls, rate}' or '{states, controls, next}'");
    return all;
  }

  bool add_to_system(YamlNode& system) const {
    YamlNode* states = find_part(system, "states");
    YamlNode *rate = find_part(system, "rate"), *next = find_part(system, "next");
    YamlNode* equations = rate != nullptr ? rate : next;
    if (states == nullptr || equations == nullptr || equations->kind != YamlNode::Kind::kMap)
      return false;
    if (states->kind == YamlNode::Kind::kSequence)
      states->items.push_back(scalar_node(name(), mark()));
    else
      add(*states, std::string("1"));
    add(*equations, rate != nullptr ? std::string("0") : name());
    return true;
  }

  void add_to_initial_state() const {
    YamlNode& state = map_part(root_, "initial_state");
    if (YamlNode* numbers = find_part(state, "state"))
      numbers->items.push_back(scalar_node(fmt::format("{}", parameter_.start), mark()));
    else
      add(map_part(state, "values"), parameter_.start);
  }

  void add_to_choice() const {
    YamlNode* phases = find_part(root_, "phases");
    YamlNode* first = phases != nullptr && !phases->items.empty() ? &phases->items[0] : nullptr;
    YamlNode* choose = first != nullptr ? find_part(*first, "choose") : nullptr;
    if (choose == nullptr)
      return fail(
          fmt::format("'{}' is chosen in a first phase without time, and there is none", name()),
          "write '- {choose: none}' as the first of the phases");
    add_coordinate(*choose);
    bound(*first, "lower", parameter_.lower - parameter_.start);
    bound(*first, "upper", parameter_.upper - parameter_.start);
  }

  /// `all` has it already.
  void add_coordinate(YamlNode& choose) const {
    const YamlNode own = scalar_node(name(), mark());
    if (choose.kind == YamlNode::Kind::kSequence) {
      choose.items.push_back(own);
    } else if (choose.text != "all") {
      std::vector<YamlNode> names{own};
      if (choose.text != "none") names.insert(names.begin(), choose);
      choose = {.kind = YamlNode::Kind::kSequence, .mark = choose.mark, .items = std::move(names)};
    }
  }

  /// How far it may move from where it starts.
  void bound(YamlNode& choice, const std::string& key, double value) const {
    YamlNode& bounds = map_part(choice, key);
    if (bounds.kind == YamlNode::Kind::kMap) return add(bounds, value);
    out_.error({bounds.mark, fmt::format("phases.0.{}", key)},
               "beside free parameters these bounds are given by name", "write '{x: -1, ...}'");
  }

  const FreeParameter& parameter_;
  YamlNode& root_;
  Diagnostics& out_;
};

/// Where a residual or bounds are on the whole state, free parameters would be part of it.
void check_whole_states(const YamlNode& node, const std::string& path, Diagnostics& out) {
  const std::string before = path.empty() ? "" : path + ".";
  for (std::size_t i = 0; i < node.items.size(); ++i)
    check_whole_states(node.items[i], before + std::to_string(i), out);
  for (const YamlNode::Entry& entry : node.entries) {
    const bool is_residual = entry.key == "residual" && entry.value.text == "state";
    if (is_residual && node.find("columns") == nullptr)
      out.error({entry.value.mark, before + entry.key},
                "free parameters are states, and this is on all of them",
                "name those that it is on: 'columns: [x, v]'");
    check_whole_states(entry.value, before + entry.key, out);
  }
}

}  // namespace

std::optional<FreeParameter> read_free_parameter(const Name& name, const YamlReader& reader) {
  static constexpr Choice<bool> kFree[] = {{"true", true}};
  FreeParameter parameter{.name = name};
  const int errors = reader.diagnostics().error_count();
  YamlMap map(reader, "write '{free: true, lower: 0.5, upper: 2}'");
  if (const auto free = map.require("free")) free->choice(kFree, "value of 'free'");
  map.require("lower");
  map.require("upper");
  map.number("lower", parameter.lower);
  map.number("upper", parameter.upper);
  parameter.start = 0.5 * (parameter.lower + parameter.upper);
  map.number("start", parameter.start);
  map.finish();
  if (reader.diagnostics().error_count() > errors) return std::nullopt;
  if (parameter.lower <= parameter.start && parameter.start <= parameter.upper) return parameter;
  reader.error(fmt::format("the start {} does not lie between {} and {}", parameter.start,
                           parameter.lower, parameter.upper));
  return std::nullopt;
}

void place_free_parameters(const std::vector<FreeParameter>& parameters, YamlNode& root,
                           Diagnostics& out) {
  for (const FreeParameter& parameter : parameters)
    if (!FreeParameterPlacer(parameter, root, out).place()) return;
  if (!parameters.empty()) check_whole_states(root, "", out);
}

}  // namespace conddp
