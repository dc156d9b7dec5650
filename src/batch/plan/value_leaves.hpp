#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A number, word or empty list within a varied value.
struct ValueLeaf {
  std::string path;  ///< steps of lists and mappings, with dots between; empty: the value itself
  OrderedJson value;
};

/// What a value of the manifest is made of, in its order. `text`: the value as JSON.
std::vector<ValueLeaf> leaves_of(const std::string& text);

}  // namespace conddp
