#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/spec/spec_cost.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// A key next to `kind` in an activation.
struct ActivationKey {
  std::string_view name;
  std::string_view description;  ///< one line, with the unit
  OrderedJson schema;            ///< of its value: JSON Schema, with the default
  std::string_view unfit;        ///< message for activations without this key
  void (*read)(const YamlReader& reader, ActivationSpec& activation);
  /// JSON that `read` reads as the same value; null if omitted.
  OrderedJson (*expand)(const ActivationSpec& activation);
};

/// Complete description of an activation of problem files.
struct ActivationDefinition {
  std::string_view name;
  ActivationKind kind;
  std::string_view description;  ///< one line
  std::vector<const ActivationKey*> keys = {};
  /// Message if all of the keys are missing; empty if none is required.
  std::string_view needs = {};
  std::string_view hint = {};  ///< the correct form
};

/// Activations in the order of the documents.
std::span<const ActivationDefinition> activation_table();
const ActivationDefinition& activation_definition(ActivationKind kind);

ActivationSpec read_activation(const YamlReader& reader);
/// The name alone for an activation without keys.
OrderedJson expand_activation(const ActivationSpec& activation);

}  // namespace conddp
