#pragma once

#include <cstddef>
#include <vector>

namespace conddp {

/// `wanted` of the numbers from 0 to count − 1 in their order, or all if there are fewer. They are
/// spread over all, and over what repeats with any short period, such as the solvers of a plan.
std::vector<std::size_t> spread_over(std::size_t count, std::size_t wanted);

}  // namespace conddp
