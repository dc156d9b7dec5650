#include "problem_file/lower/free_parameters.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "problem_file/model/components.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

YamlNode scalar_node(std::string text, const Mark& mark) {
  return {.kind = YamlNode::Kind::kScalar, .mark = mark, .text = std::move(text)};
}

/// The value of a mapping's key; a missing or empty one becomes an empty mapping.
YamlNode& map_part(YamlNode& node, const std::string& key) {
  YamlNode* found = find_part(node, key);
  if (found == nullptr) {
    node.entries.push_back({key, node.mark, {.mark = node.mark}});
    found = &node.entries.back().value;
  }
  if (found->kind == YamlNode::Kind::kNull) found->kind = YamlNode::Kind::kMap;
  return *found;
}

/// Writes one parameter into a document.
class FreeParameterPlacer {
 public:
  FreeParameterPlacer(const FreeParameter& parameter, YamlNode& root, Diagnostics& out)
      : parameter_(parameter), root_(root), out_(out) {}

  /// False if no system can hold the parameter.
  bool place() {
    if (add_to_robots()) return true;
    if (!add_to_systems()) return false;
    add_to_initial_state();
    add_to_keyframes();
    check_jumps();
    return true;
  }

 private:
  const Mark& mark() const { return parameter_.name.place.mark; }
  const std::string& name() const { return parameter_.name.value; }
  void fail(std::string message, std::string hint) const {
    out_.error(parameter_.name.place, std::move(message), std::move(hint));
  }
  /// `path`: path of the mapping.
  void add(YamlNode& map, std::string text, const std::string& path) const {
    if (const YamlNode::Entry* entry = own_entry(map))
      out_.error({entry->mark, fmt::format("{}.{}", path, name())},
                 fmt::format("'{}' is free, and stands here again", name()),
                 "its values are 'start', 'lower' and 'upper' below 'parameters'");
    else
      map.entries.push_back({name(), mark(), scalar_node(std::move(text), mark())});
  }
  void add(YamlNode& map, double number, const std::string& path) const {
    add(map, fmt::format("{}", number), path);
  }
  /// A mapping's entry for the parameter, or null.
  const YamlNode::Entry* own_entry(const YamlNode& map) const {
    const auto found = std::ranges::find(map.entries, name(), &YamlNode::Entry::key);
    return found != map.entries.end() ? &*found : nullptr;
  }

  /// A robot's node and its path.
  using Robot = std::pair<YamlNode*, std::string>;

  std::vector<Robot> robots() const {
    std::vector<Robot> all;
    if (YamlNode* robot = find_part(root_, "robot")) all.emplace_back(robot, "robot");
    if (YamlNode* named = find_part(root_, "robots"))
      for (YamlNode::Entry& entry : named->entries)
        all.emplace_back(&entry.value, "robots." + entry.key);
    return all;
  }

  /// Adds the parameter to the robots that carry it, else to the first robot. Robot states start at
  /// the values of their parameters. False without a robot.
  bool add_to_robots() const {
    const std::vector<Robot> all = robots();
    if (all.empty()) return false;
    std::vector<Robot> carriers;
    std::ranges::copy_if(all, std::back_inserter(carriers),
                         [&](const Robot& robot) { return carries(*robot.first); });
    if (!carriers.empty() && parameter_.lower < 0)
      fail(fmt::format("the mass '{}' may be {} kg", name(), parameter_.lower),
           "the lower bound of a mass is at least 0");
    if (carriers.empty()) carriers = {all.front()};
    for (const auto& [robot, path] : carriers) add_to_robot(*robot, path);
    return true;
  }

  /// True if the parameter is the mass of one of the robot's payloads.
  bool carries(YamlNode& robot) const {
    const YamlNode* payloads = find_part(robot, "payloads");
    return payloads != nullptr && std::ranges::any_of(payloads->entries, [&](const auto& payload) {
             const YamlNode* mass = payload.value.find("mass");
             return mass != nullptr && mass->text == name();
           });
  }

  /// Skips nodes other than mappings; their reader reports them.
  void add_to_robot(YamlNode& robot, const std::string& path) const {
    if (robot.kind != YamlNode::Kind::kMap) return;
    YamlNode& parameters = map_part(robot, "parameters");
    if (parameters.kind == YamlNode::Kind::kMap)
      add(parameters, parameter_.start, path + ".parameters");
  }

  bool add_to_systems() const {
    bool all = false;
    if (YamlNode* system = find_part(root_, "system")) all = add_to_system(*system, "system");
    if (YamlNode* systems = find_part(root_, "systems")) {
      all = !systems->entries.empty();
      for (YamlNode::Entry& entry : systems->entries)
        all &= add_to_system(entry.value, "systems." + entry.key);
    }
    if (!all)
      fail(fmt::format("'{}' is free, and free parameters are those of robots and of equations of "
                       "first order or of differences",
                       name()),
           "they need 'robot', 'system: {states, controls, rate}' or '{states, controls, next}'");
    return all;
  }

  bool add_to_system(YamlNode& system, const std::string& path) const {
    YamlNode* states = find_part(system, "states");
    YamlNode *rate = find_part(system, "rate"), *next = find_part(system, "next");
    YamlNode* equations = rate != nullptr ? rate : next;
    if (states == nullptr || equations == nullptr || equations->kind != YamlNode::Kind::kMap)
      return false;
    if (states->kind == YamlNode::Kind::kSequence)
      states->items.push_back(scalar_node(name(), mark()));
    else
      add(*states, std::string("1"), path + ".states");
    add(*equations, rate != nullptr ? std::string("0") : name(),
        path + (rate != nullptr ? ".rate" : ".next"));
    return true;
  }

  void add_to_initial_state() const {
    if (YamlNode* state = find_part(root_, "initial_state")) add_to_state(*state, "initial_state");
  }

  /// Skips nodes that are not states; their reader reports them.
  void add_to_state(YamlNode& state, const std::string& path) const {
    if (state.kind != YamlNode::Kind::kMap) return;
    if (YamlNode* numbers = find_part(state, "state")) {
      numbers->items.push_back(scalar_node(fmt::format("{}", parameter_.start), mark()));
      return;
    }
    YamlNode& values = map_part(state, "values");
    if (values.kind == YamlNode::Kind::kMap) add(values, parameter_.start, path + ".values");
  }

  /// Adds the parameter to the keyframes of the initial guess.
  void add_to_keyframes() const {
    YamlNode* keyframes = &root_;
    for (const char* step : {"initial_guess", "states", "keyframes"})
      if (keyframes != nullptr) keyframes = find_part(*keyframes, step);
    for (std::size_t i = 0; keyframes != nullptr && i < keyframes->items.size(); ++i)
      if (YamlNode* state = find_part(keyframes->items[i], "state"))
        add_to_state(*state, fmt::format("initial_guess.states.keyframes.{}.state", i));
  }

  /// Reports jumps that set the parameter: jumps must not change it.
  void check_jumps() const {
    YamlNode* phases = find_part(root_, "phases");
    for (std::size_t i = 0; phases != nullptr && i < phases->items.size(); ++i) {
      const YamlNode* jump = find_part(phases->items[i], "jump");
      if (const YamlNode::Entry* entry = jump != nullptr ? own_entry(*jump) : nullptr)
        out_.error({entry->mark, fmt::format("phases.{}.jump.{}", i, name())},
                   fmt::format("'{}' is free, and constant over the motion", name()),
                   "a quantity that changes over the motion is a state of the system");
    }
  }

  const FreeParameter& parameter_;
  YamlNode& root_;
  Diagnostics& out_;
};

bool is_on(const YamlNode::Entry& entry, std::string_view key, std::string_view what) {
  return entry.key == key && entry.value.text == what;
}

/// Reports constraints and residuals on states that would include free parameters. Only parameters
/// of systems need the check; those of robots are by_name_only.
class StatePatterns {
 public:
  StatePatterns(const std::vector<FreeParameter>& parameters, Diagnostics& out)
      : parameters_(parameters), out_(out) {}

  void check(const YamlNode& node, const std::string& path) {
    const std::string before = path.empty() ? "" : path + ".";
    for (std::size_t i = 0; i < node.items.size(); ++i)
      check(node.items[i], before + std::to_string(i));
    for (const YamlNode::Entry& entry : node.entries) {
      if (is_on(entry, "bounds", "state")) check_bounds(node, before);
      if (is_on(entry, "residual", "state")) check_columns(node, entry, before);
      check(entry.value, before + entry.key);
    }
  }

 private:
  /// Requires bounds on the state by name. The reader reports other malformed bounds.
  void check_bounds(const YamlNode& node, const std::string& before) {
    for (const YamlNode::Entry& bound : node.entries) {
      if (bound.key != "lower" && bound.key != "upper") continue;
      const YamlNode::Kind kind = bound.value.kind;
      const bool by_name = kind == YamlNode::Kind::kMap && bound.value.find("*") == nullptr;
      if (!by_name && kind != YamlNode::Kind::kNull)
        out_.error({bound.value.mark, before + bound.key},
                   "free parameters are states, and these bounds are on all of them",
                   "bound states by name: '" + bound.key + ": {x: -2}'");
      else
        for (const YamlNode::Entry& name : bound.value.entries)
          check_pattern(name.key, {name.mark, before + bound.key + '.' + name.key});
    }
  }

  /// Reports state residuals without `columns` or with '*': they include all columns.
  void check_columns(const YamlNode& node, const YamlNode::Entry& residual,
                     const std::string& before) {
    const YamlNode* columns = node.find("columns");
    const auto is_all = [](const YamlNode& name) { return name.text == "*"; };
    if (columns == nullptr || is_all(*columns) || std::ranges::any_of(columns->items, is_all))
      return out_.error({residual.value.mark, before + residual.key},
                        "free parameters are states, and this is on all of them",
                        "name those that it is on: 'columns: [x, v]'");
    check_pattern(columns->text, {columns->mark, before + "columns"});
    for (const YamlNode& name : columns->items)
      check_pattern(name.text, {name.mark, before + "columns"});
  }

  /// Reports a pattern that fits a parameter; parameters must be named in full.
  void check_pattern(const std::string& pattern, const Place& place) {
    if (!is_pattern(pattern)) return;
    for (const FreeParameter& parameter : parameters_)
      if (fits(pattern, parameter.name.value))
        out_.error(place,
                   fmt::format("free parameters are states, and '{}' is on '{}', too", pattern,
                               parameter.name.value),
                   "name the states that it is on");
  }

  const std::vector<FreeParameter>& parameters_;
  Diagnostics& out_;
};

bool is_of_payload(std::string_view path) {
  return path.starts_with("robot.payloads.") ||
         (path.starts_with("robots.") && path.find(".payloads.") != path.npos);
}

}  // namespace

void describe(Keys& keys, FreeParameter& parameter) {
  static constexpr Choice<bool> kFree[] = {{"true", true}};
  keys.about({.definition = "free_parameter",
              .title = "A parameter that the solver chooses",
              .says = "A name of expressions; the first phase chooses it with the initial state",
              .examples = R"([{"free": true, "lower": 0.5, "upper": 2}])"});
  const int errors = keys.errors();
  keys({.name = "free", .says = "Says that it is chosen", .required = true},
       CustomValue{[](const YamlReader& reader) { reader.choice(kFree, "value of 'free'"); },
                   {},
                   R"({"const": true})"});
  keys({.name = "lower", .says = "Least value, in any unit", .required = true}, parameter.lower,
       NumberForm{});
  keys({.name = "upper", .says = "Largest value, in any unit", .required = true}, parameter.upper,
       NumberForm{});
  std::optional<double> start;
  keys({"start", "Where the solver begins; the middle of the bounds by default, in any unit"},
       start, NumberForm{});
  const double lower = parameter.lower, upper = parameter.upper;
  parameter.start = start.value_or(0.5 * (lower + upper));
  if (keys.errors() > errors) return;
  if (lower > upper)
    keys.error(fmt::format("the lower bound {} lies above the upper bound {}", lower, upper));
  else if (parameter.start < lower || parameter.start > upper)
    keys.error(
        fmt::format("the start {} does not lie between {} and {}", parameter.start, lower, upper));
}

std::optional<FreeParameter> read_free_parameter(const Name& name, const YamlReader& reader) {
  FreeParameter parameter{.name = name};
  const int errors = reader.diagnostics().error_count();
  read_map(reader, parameter, "write '{free: true, lower: 0.5, upper: 2}'");
  return reader.diagnostics().error_count() > errors ? std::nullopt : std::optional(parameter);
}

bool is_mass_of_payload(std::string_view path) {
  return is_of_payload(path) && path.ends_with(".mass");
}

std::string hint_of_free_parameter(std::string_view path) {
  if (is_mass_of_payload(path))
    return "the mass of a payload is a parameter alone, as 'mass: =load': a factor belongs to its "
           "bounds";
  if (is_of_payload(path))
    return "only the mass of a payload can be free, as 'mass: =load'; a parameter that is a number "
           "can be varied with --set and in batches";
  return "expressions have free parameters: equations, and rows of residuals; of robots the masses "
         "of payloads, as 'mass: =load'";
}

void place_free_parameters(const std::vector<FreeParameter>& parameters, YamlNode& root,
                           Diagnostics& out) {
  for (const FreeParameter& parameter : parameters)
    if (!FreeParameterPlacer(parameter, root, out).place()) return;
  if (parameters.empty()) return;
  const bool of_robots = find_part(root, "robot") || find_part(root, "robots");
  if (!of_robots) StatePatterns(parameters, out).check(root, "");
}

}  // namespace conddp
