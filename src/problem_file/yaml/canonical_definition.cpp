#include "problem_file/yaml/canonical_definition.hpp"

#include <algorithm>

#include "base/text/strict_number.hpp"

namespace conddp {
namespace {

constexpr std::string_view kNotOfTheProblem[] = {
    "name", "description", "initial_guess", "perturbation", "solver", "mpc", "draw"};

std::string dump(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json canonical(const YamlNode& node) {
  nlohmann::json json;
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      break;
    case YamlNode::Kind::kSequence:
      json = nlohmann::json::array();
      for (const YamlNode& item : node.items) json.push_back(canonical(item));
      break;
    case YamlNode::Kind::kMap:
      json = nlohmann::json::object();
      for (const YamlNode::Entry& entry : node.entries) json[entry.key] = canonical(entry.value);
      break;
    case YamlNode::Kind::kScalar:
      json = node.text;
      if (const auto number = parse_number(node.text).value; number && !node.quoted) json = *number;
  }
  return json;
}

}  // namespace

bool is_of_the_problem(std::string_view key) {
  return std::find(std::begin(kNotOfTheProblem), std::end(kNotOfTheProblem), key) ==
         std::end(kNotOfTheProblem);
}

std::string canonical_definition(const YamlNode& root) {
  nlohmann::json json = canonical(root);
  if (json.is_object())
    for (const std::string_view key : kNotOfTheProblem) json.erase(std::string(key));
  return dump(json);
}

OrderedJson json_of(const YamlNode& node) {
  OrderedJson json;
  if (node.kind == YamlNode::Kind::kScalar) {
    const auto number = parse_number(node.text).value;
    const bool is_truth = node.text == "true" || node.text == "false";
    if (node.quoted || (!number && !is_truth)) return node.text;
    return is_truth ? OrderedJson(node.text == "true") : OrderedJson(*number);
  }
  if (node.kind == YamlNode::Kind::kSequence) json = OrderedJson::array();
  if (node.kind == YamlNode::Kind::kMap) json = OrderedJson::object();
  for (const YamlNode& item : node.items) json.push_back(json_of(item));
  for (const YamlNode::Entry& entry : node.entries) json[entry.key] = json_of(entry.value);
  return json;
}

std::string canonical_value(const YamlNode& node) { return dump(canonical(node)); }

}  // namespace conddp
