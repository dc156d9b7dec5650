#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Writes solution.json, trajectory.csv, iterations.csv and, where there is a page, report.html
/// into a folder, which is made if needed: all of them or, with an OutputError, none. Returns their
/// paths. `document` is that of the solution (solution_json).
std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page);

}  // namespace conddp
