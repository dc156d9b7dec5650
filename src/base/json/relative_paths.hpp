#pragma once

#include <filesystem>
#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// The path of a file as written in a problem of this folder; an empty folder is the working
/// directory.
std::string relative_path(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Rewrites the file paths of an expanded problem from the folder `from` for a problem in `folder`.
void make_paths_relative(OrderedJson& problem, const std::filesystem::path& from,
                         const std::filesystem::path& folder);

}  // namespace conddp
