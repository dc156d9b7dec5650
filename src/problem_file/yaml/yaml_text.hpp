#pragma once

#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A document as readable YAML that YAML 1.1 and 1.2 readers parse identically: short flat parts on
/// one line, numbers with shortest round trip, ambiguous text in quotes.
std::string yaml_text(const OrderedJson& document);

}  // namespace conddp
