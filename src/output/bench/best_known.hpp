#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// The file, beside problem files, that says what is known of their optima
/// (schemas/best_known.schema.json).
inline constexpr const char* kBestKnownFile = "best_known.json";

/// The least cost known of each problem, by problem_sha256: an entry of a problem that has changed
/// since is found no more.
using BestKnown = std::map<std::string, double>;

/// Reads such a file. What is wrong with it is reported.
std::optional<BestKnown> load_best_known(const std::filesystem::path& file, Diagnostics& out);

}  // namespace conddp
