#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/spec/spec_cost.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// A key that stands beside the kind of an activation.
struct ActivationKey {
  std::string_view name;
  std::string_view description;  ///< one line, with the unit
  OrderedJson schema;            ///< of its value: JSON Schema, with the default
  std::string_view unfit;        ///< what to say where an activation does not have it
  void (*read)(const YamlReader& reader, ActivationSpec& activation);
  /// What the reader would read the same from; null: left out.
  OrderedJson (*expand)(const ActivationSpec& activation);
};

/// All that the program knows of an activation of problem files.
struct ActivationDefinition {
  std::string_view name;
  ActivationKind kind;
  std::string_view description;  ///< one line
  std::vector<const ActivationKey*> keys = {};
  /// What to say where none of the keys is given; empty: there is no need of one.
  std::string_view needs = {};
  std::string_view hint = {};  ///< what to write
};

/// In the order in which documents list them.
std::span<const ActivationDefinition> activation_table();
const ActivationDefinition& activation_definition(ActivationKind kind);

ActivationSpec read_activation(const YamlReader& reader);
/// The activation's name where it has no keys.
OrderedJson expand_activation(const ActivationSpec& activation);

}  // namespace conddp
