#pragma once

#include "problem_file/spec/residual_definition.hpp"

namespace conddp {

/// Reads `residual` and the keys that belong to residuals. False where the residual is not known.
bool read_residual_keys(YamlMap& map, TermPlace place, CostSpec& cost);

/// What it would read the same from, with the defaults written out.
OrderedJson expand_residual_keys(const CostSpec& cost, const KeyContext& context);

}  // namespace conddp
