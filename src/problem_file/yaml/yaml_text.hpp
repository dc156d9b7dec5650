#pragma once

#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A document as YAML that a person can read and that is read back the same, by readers of YAML 1.1
/// and 1.2: short flat parts on one line, numbers by shortest round trip, every text in quotes that
/// could be taken for something else.
std::string yaml_text(const OrderedJson& document);

}  // namespace conddp
