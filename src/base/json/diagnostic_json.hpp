#pragma once

#include "base/json/ordered_json.hpp"
#include "base/text/diagnostic.hpp"

namespace conddp {

/// A message with its place: file, line, column, path, severity, message, hint, accepted; null for
/// an unknown position.
OrderedJson diagnostic_json(const Diagnostic& d);

}  // namespace conddp
