#pragma once

#include <string>

#include "problem_file/ordered_json.hpp"

namespace conddp {

/// Thrown where the document of a solution has not the shape that it should have.
struct MalformedSolution {
  std::string message;
};

/// A member of an object, which must be there.
const OrderedJson& solution_member(const OrderedJson& object, const char* key);

/// A member that must be a text, or a list.
std::string solution_text(const OrderedJson& object, const char* key);
const OrderedJson& solution_list(const OrderedJson& object, const char* key);

}  // namespace conddp
