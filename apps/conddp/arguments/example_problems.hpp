#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Existing folders with example problems: `problems` in the current folder, then the folder
/// installed with the tool.
std::vector<std::filesystem::path> example_folders();

/// Example problems of these folders and their subfolders `mpc`. Their names are those of their
/// files without suffix; of files with the same name, the first folder's is used.
std::vector<std::filesystem::path> example_problems();

/// The first sentence of an example's head comment; empty without a comment.
std::string example_summary(const std::filesystem::path& file);

/// The problem file denoted by a command-line word: a path, or if no such file exists and the word
/// is a plain name, the example problem of that name. Other names are errors.
std::optional<std::filesystem::path> find_problem_file(const std::string& word, Diagnostics& out);

}  // namespace conddp
