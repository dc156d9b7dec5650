#pragma once

#include <filesystem>
#include <vector>

#include "output/solution.hpp"

namespace conddp {

/// Writes solution.json, trajectory.csv and iterations.csv into a folder, which is made if needed:
/// all of them or, with an OutputError, none. Returns their paths.
std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const std::filesystem::path& folder);

}  // namespace conddp
