#pragma once

#include <filesystem>
#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A file as a problem in this folder names it; an empty folder is the one where the tool runs.
std::string relative_path(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Renames the files that an expanded problem of the folder `from` names, for one in `folder`.
void make_paths_relative(OrderedJson& problem, const std::filesystem::path& from,
                         const std::filesystem::path& folder);

}  // namespace conddp
