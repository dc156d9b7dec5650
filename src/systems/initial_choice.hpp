#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// A knot that chooses a state: its control is the displacement of some coordinates, x⁺ = x ⊕ S u.
/// S has one column for each coordinate (an index into tangent vectors). We write it as the
/// first-order system ẋ = S u; an explicit Euler step of length 1 applies the choice. `controls`
/// names these controls and further chosen values, which an augmented state may store. `moved`
/// lists those further controls that move a coordinate too (coordinate, control); the others have
/// no effect here.
std::shared_ptr<const System> initial_choice(const System& of, const std::vector<int>& coordinates,
                                             const std::vector<Column>& controls,
                                             const std::vector<std::pair<int, int>>& moved = {});

/// The coordinates that such a knot chooses.
std::vector<int> chosen_coordinates(const System& choice);

}  // namespace conddp
