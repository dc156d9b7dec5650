#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// The folders with example problems that there are: `problems` in the current folder, then the one
/// that was installed with the tool.
std::vector<std::filesystem::path> example_folders();

/// The example problems of these folders and of their folders `mpc` by their names, which are those
/// of their files without the suffix; of two with one name the first folder's.
std::vector<std::filesystem::path> example_problems();

/// What the comment at the head of an example says in its first sentence; empty without one.
std::string example_summary(const std::filesystem::path& file);

/// The problem file that a word of the command line means: a path, or where there is no such file
/// and it is a name alone, the example problem of that name. A name that is neither is an error.
std::optional<std::filesystem::path> find_problem_file(const std::string& word, Diagnostics& out);

}  // namespace conddp
