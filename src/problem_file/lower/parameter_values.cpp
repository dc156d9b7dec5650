#include "problem_file/lower/parameter_values.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/lower/free_parameters.hpp"
#include "problem_file/lower/unused_names.hpp"
#include "problem_file/model/expression_source.hpp"
#include "problem_file/yaml/key_path.hpp"
#include "problem_file/yaml/path_step.hpp"
#include "systems/expressions/parser.hpp"

namespace conddp {
namespace {

bool is_formula(const YamlNode& node) {
  return node.kind == YamlNode::Kind::kScalar && node.text.starts_with('=');
}

YamlNode number_node(double number, const Mark& mark) {
  return {.kind = YamlNode::Kind::kScalar, .mark = mark, .text = fmt::format("{}", number)};
}

class ParameterPlacer {
 public:
  explicit ParameterPlacer(Diagnostics& out) : out_(out) {}

  ExpressionNamesSpec read(YamlNode& parameters) {
    ExpressionNamesSpec names;
    const YamlReader reader(parameters, "parameters", out_);
    if (!reader.named_entries("write '{mass: 2, goal: [1, 0]}'")) return names;
    for (const YamlNode::Entry& entry : parameters.entries)
      scope_.explain(entry.key, "it is given further below; parameters use those before them");
    for (YamlNode::Entry& entry : parameters.entries) {
      const std::string path = "parameters." + entry.key;
      const int errors = out_.error_count();
      place_values(entry.value, path);
      const YamlReader value(entry.value, path, out_);
      const Place place{entry.mark, path};
      if (std::string defect = scope_.defect_of(entry.key); !defect.empty())
        out_.error(place, std::move(defect));
      // Later constants may depend on a wrong one.
      if (out_.error_count() > errors) break;
      if (value.is_map()) {
        auto free = read_free_parameter({entry.key, place}, value);
        if (!free) break;
        names.free.push_back(*free);
        free_.push_back(*std::move(free));
        scope_.add(entry.key, ExpressionValue::number(graph_.input(0)));
        continue;
      }
      const auto given = read_value(value);
      if (!given) break;
      add(entry.key, *given);
      names.parameters.emplace_back(entry.key, *given);
      names.parameter_places.push_back(place);
    }
    std::erase_if(parameters.entries,
                  [](const YamlNode::Entry& e) { return e.value.kind == YamlNode::Kind::kMap; });
    return names;
  }

  const std::vector<FreeParameter>& free() const { return free_; }

  /// Replaces all values that begin with '=' in a node and below.
  void place_values(YamlNode& node, std::string path) { replace(node, path); }

 private:
  /// Restores `path` before returning.
  void replace(YamlNode& node, std::string& path) {
    if (is_formula(node)) return put_value(node, path);
    const bool is_root = path.empty();
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const PathStep step(path, i);
      replace(node.items[i], path);
    }
    for (YamlNode::Entry& entry : node.entries) {
      if (is_root && is_for_people(entry.key)) continue;
      const PathStep step(path, entry.key);
      replace(entry.value, path);
    }
  }

  static bool is_for_people(std::string_view key) { return key == "name" || key == "description"; }

  static std::optional<ParameterValue> read_value(const YamlReader& reader) {
    if (reader.is_sequence()) {
      auto numbers = reader.numbers();
      if (numbers && numbers->empty()) reader.error("a vector has at least one number");
      if (numbers && !numbers->empty()) return ParameterValue(*std::move(numbers));
    } else if (const auto number = reader.number()) {
      return ParameterValue(*number);
    }
    return std::nullopt;
  }

  void add(const std::string& name, const ParameterValue& given) {
    ExpressionValue value = ExpressionValue::vector({});
    for (const double number : given.numbers) value.nodes.push_back(graph_.constant(number));
    if (!given.is_vector) value.kind = ExpressionValue::Kind::kNumber;
    scope_.add(name, std::move(value));
  }

  /// True if a formula is just the name of a free parameter, in place of a payload's mass.
  bool is_free_mass(const std::string& formula, const std::string& path) const {
    return is_mass_of_payload(path) && std::ranges::any_of(free_, [&](const FreeParameter& free) {
             return free.name.value == formula;
           });
  }

  void put_value(YamlNode& node, const std::string& path) {
    const std::size_t first = std::min(node.text.find_first_not_of(' ', 1), node.text.size());
    if (const std::string name = node.text.substr(first); is_free_mass(name, path)) {
      node = {.kind = YamlNode::Kind::kScalar, .mark = node.mark, .text = name};
      return;
    }
    const ExpressionText text{node.text, {node.mark, path}, node.quoted};
    ParsedExpression parsed = parse_expression(node.text.substr(1), scope_, graph_);
    if (!parsed.value) {
      ++parsed.error.offset;  // skips the '='
      return report_expression(text, parsed.error, Severity::kError, out_);
    }
    const ExpressionValue& value = *parsed.value;
    if (value.kind == ExpressionValue::Kind::kCondition)
      return out_.error(text.place, "a number or a vector is expected here, not a condition");
    for (const NodeId id : value.nodes)
      if (!graph_.constant_of(id))
        return out_.error(text.place, "this depends on a free parameter, which the solver chooses",
                          hint_of_free_parameter(path));
    if (value.is_number()) {
      node = number_node(*graph_.constant_of(value.nodes[0]), node.mark);
      return;
    }
    YamlNode list{.kind = YamlNode::Kind::kSequence, .mark = node.mark};
    for (const NodeId id : value.nodes)
      list.items.push_back(number_node(*graph_.constant_of(id), node.mark));
    node = std::move(list);
  }

  Diagnostics& out_;
  ExpressionGraph graph_;
  ExpressionScope scope_;
  std::vector<FreeParameter> free_;
};

}  // namespace

ExpressionNamesSpec place_parameters(YamlNode& root, Diagnostics& out) {
  warn_of_unused_names(root, out);
  ParameterPlacer placer(out);
  ExpressionNamesSpec names;
  if (YamlNode* parameters = find_part(root, "parameters")) names = placer.read(*parameters);
  if (!out.has_errors()) placer.place_values(root, "");
  if (!out.has_errors()) place_free_parameters(placer.free(), root, out);
  return names;
}

}  // namespace conddp
