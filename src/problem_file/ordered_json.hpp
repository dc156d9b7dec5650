#pragma once

#include <nlohmann/json.hpp>

namespace conddp {

/// JSON whose keys keep the order in which they were put in.
using OrderedJson = nlohmann::ordered_json;

}  // namespace conddp
