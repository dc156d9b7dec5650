#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// A knot that chooses a state: its control is the displacement of some coordinates, x⁺ = x ⊕ S u
/// with one column of S for each coordinate (an index into tangent vectors). As a first-order
/// system that is ẋ = S u; explicit Euler with a step of 1 makes the choice of it. `controls` names
/// these and further controls: what else is chosen, for a memory to hold. Of those, some move a
/// coordinate too (`moved`: coordinate and control), all others nothing here.
std::shared_ptr<const System> initial_choice(const System& of, const std::vector<int>& coordinates,
                                             const std::vector<Column>& controls,
                                             const std::vector<std::pair<int, int>>& moved = {});

/// The coordinates that such a knot chooses.
std::vector<int> chosen_coordinates(const System& choice);

}  // namespace conddp
