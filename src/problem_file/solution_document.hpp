#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "problem_file/diagnostic.hpp"

namespace conddp {

/// Reads the entries `keys` (and `format`) of a solution.json from its text; the others are passed
/// over without being kept, since gains and multipliers of a long solution would fill the memory.
/// Refused with their places: what is no JSON, is nested too deeply, is too long, or has a key
/// twice, and another format than the one that this version writes. Which entries there are, and of
/// what shape, is left to the caller.
std::optional<nlohmann::json> parse_solution_document(const std::string& text,
                                                      const std::string& name,
                                                      std::span<const std::string_view> keys,
                                                      Diagnostics& out);

/// The same from a file; `place` is where the file is named.
std::optional<nlohmann::json> load_solution_document(const std::filesystem::path& file,
                                                     std::span<const std::string_view> keys,
                                                     const Place& place, Diagnostics& out);

}  // namespace conddp
