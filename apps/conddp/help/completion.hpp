#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

// Completion scripts for subcommands, flags, accepted words, files and folders.

/// For sourcing, or for bash-completion as a file named conddp.
std::string bash_completion(const Command& root);
/// For sourcing after compinit, or for autoloading as a file named _conddp.
std::string zsh_completion(const Command& root);
/// For sourcing, or for fish as a file named conddp.fish.
std::string fish_completion(const Command& root);

}  // namespace conddp
