#include <algorithm>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/system_fields.hpp"
#include "problem_file/values/system_keys.hpp"

namespace conddp {
namespace {

/// The system type determined by its other keys: equations, or a compiled function.
std::optional<std::size_t> type_by_keys(const YamlNode& node) {
  constexpr std::size_t kExpressions = std::size(kSystemTypes) - 2;
  if (node.find("rate") || node.find("acceleration") || node.find("next")) return kExpressions;
  if (node.find("library")) return kExpressions + 1;
  // Systems of equations with a misspelled key, so that messages name that key.
  constexpr const char* kOfEquations[] = {"states",    "positions", "controls", "velocities",
                                          "state",     "control",   "rates",    "dynamics",
                                          "equations", "ode",       "rhs",      "xdot"};
  const auto has = [&](const char* key) { return node.find(key) != nullptr; };
  if (!has("type") && std::ranges::any_of(kOfEquations, has)) return kExpressions;
  return std::nullopt;
}

std::optional<std::size_t> choose_type(const YamlReader& reader) {
  std::vector<std::string> words;
  for (const SystemType& known : kSystemTypes) words.emplace_back(known.name);
  return reader.choose(words, "type of system");
}

}  // namespace

SystemSpec read_system(const YamlReader& reader, const FileContext& file) {
  SystemSpec system{.place = reader.place()};
  YamlMap map(reader);
  const auto by_keys = type_by_keys(reader.node());
  const auto type = by_keys ? map.find("type") : map.require("type");
  const auto index = type ? choose_type(*type) : by_keys;
  if (!index) return map.ignore_others(), system;
  system.parameters = default_system(*index).parameters;
  if (auto* expressions = std::get_if<ExpressionSystemSpec>(&system.parameters)) {
    read_expression_system(map, file, *expressions);
  } else if (auto* library = std::get_if<LibrarySystemSpec>(&system.parameters)) {
    read_library_system(map, file.folder, *library);
  } else {
    KeyReader keys(map);
    describe(keys, system);
  }
  return system;
}

}  // namespace conddp
