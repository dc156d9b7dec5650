#pragma once

#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace conddp {

/// Thrown if the structure of a document does not match the format that conddp writes.
struct MalformedSolution : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A required member of an object. `Json` is nlohmann's type, with or without key order.
template <class Json>
const Json& solution_member(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (!object.is_object() || found == object.end())
    throw MalformedSolution{fmt::format("'{}' is missing", key)};
  return *found;
}

/// A member that must be text; below, one that must be a list.
template <class Json>
std::string solution_text(const Json& object, const char* key) {
  const Json& value = solution_member(object, key);
  if (!value.is_string()) throw MalformedSolution{fmt::format("'{}' is not text", key)};
  return value.template get<std::string>();
}
template <class Json>
const Json& solution_list(const Json& object, const char* key) {
  const Json& value = solution_member(object, key);
  if (!value.is_array()) throw MalformedSolution{fmt::format("'{}' is not a list", key)};
  return value;
}

}  // namespace conddp
