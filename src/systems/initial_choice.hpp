#pragma once

#include <memory>
#include <string>
#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// A knot that chooses a state: its control is the displacement of some coordinates, x⁺ = x ⊕ S u
/// with one column of S for each coordinate (an index into tangent vectors). As a first-order
/// system that is ẋ = S u; explicit Euler with a step of 1 makes the choice of it. `controls` names
/// these and further controls that move nothing here: what else is chosen, for a memory to hold.
std::shared_ptr<const System> initial_choice(const System& of, const std::vector<int>& coordinates,
                                             const std::vector<Column>& controls);

/// The coordinates that such a knot chooses.
std::vector<int> chosen_coordinates(const System& choice);

}  // namespace conddp
