#pragma once

#include <cstddef>
#include <vector>

namespace conddp {

/// `wanted` of the numbers from 0 to count − 1, ascending, or all if there are fewer. They are
/// spread evenly, even over short periods such as the solvers of a plan.
std::vector<std::size_t> spread_over(std::size_t count, std::size_t wanted);

}  // namespace conddp
