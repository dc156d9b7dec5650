#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Writes solution.json, trajectory.csv, iterations.csv and, unless the page is empty, report.html
/// into a folder, which is created if needed. On an OutputError, no file is written. Returns their
/// paths. `document` is that of the solution (solution_json).
std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page);

}  // namespace conddp
