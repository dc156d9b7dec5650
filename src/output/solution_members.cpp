#include "output/solution_members.hpp"

#include <fmt/format.h>

namespace conddp {

const OrderedJson& solution_member(const OrderedJson& object, const char* key) {
  const auto found = object.find(key);
  if (!object.is_object() || found == object.end())
    throw MalformedSolution{fmt::format("'{}' is missing", key)};
  return *found;
}

std::string solution_text(const OrderedJson& object, const char* key) {
  const OrderedJson& value = solution_member(object, key);
  if (!value.is_string()) throw MalformedSolution{fmt::format("'{}' is no text", key)};
  return value.get<std::string>();
}

const OrderedJson& solution_list(const OrderedJson& object, const char* key) {
  const OrderedJson& value = solution_member(object, key);
  if (!value.is_array()) throw MalformedSolution{fmt::format("'{}' is no list", key)};
  return value;
}

}  // namespace conddp
