#pragma once

#include "problem_file/model/residual_definition.hpp"

namespace conddp {

/// The forms of references for ResidualDefinition::reference.

/// A state in any notation of a file; numbers for chosen columns.
extern const ReferenceForm kStateReference;
/// One number for all rows, a list, or a mapping from the names of rows.
extern const ReferenceForm kNumbersReference;
/// The same for rows that states do not determine.
extern const ReferenceForm kRowsReference;
/// The same; each value holds until the next way-point.
extern const ReferenceForm kControlReference;
/// [x, y, z] in the world, m.
extern const ReferenceForm kPointReference;
extern const ReferenceForm kRotationReference;
extern const ReferenceForm kPoseReference;
extern const ReferenceForm kTwistReference;

}  // namespace conddp
