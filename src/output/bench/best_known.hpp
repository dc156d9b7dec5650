#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Name of the file with the best known costs, next to problem files
/// (schemas/best_known.schema.json).
inline constexpr const char* kBestKnownFile = "best_known.json";

/// Lowest known cost of each problem, by problem_sha256. Entries of a problem that has changed
/// since no longer match.
using BestKnown = std::map<std::string, double>;

/// Reads such a file and reports its defects.
std::optional<BestKnown> load_best_known(const std::filesystem::path& file, Diagnostics& out);

}  // namespace conddp
