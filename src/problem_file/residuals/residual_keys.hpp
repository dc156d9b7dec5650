#pragma once

#include "problem_file/spec/residual_definition.hpp"

namespace conddp {

/// Reads `residual` and the keys that belong to residuals. False for an unknown residual.
bool read_residual_keys(YamlMap& map, TermPlace place, CostSpec& cost);

/// JSON that read_residual_keys reads as the same cost, with defaults written out.
OrderedJson expand_residual_keys(const CostSpec& cost, const KeyContext& context);

}  // namespace conddp
