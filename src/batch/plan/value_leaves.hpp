#pragma once

#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A number, word or empty list inside a varied value.
struct ValueLeaf {
  std::string
      path;  ///< steps through lists and mappings, joined by dots; empty for the value itself
  OrderedJson value;
};

/// The leaves of a value in the manifest, in order. `text` is the value as JSON.
std::vector<ValueLeaf> leaves_of(const std::string& text);

}  // namespace conddp
