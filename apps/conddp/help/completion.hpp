#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

// Completion scripts: subcommands, flags, the words that a value can be, files and folders.

/// To be sourced, or read by bash-completion as a file named conddp.
std::string bash_completion(const Command& root);
/// To be sourced after compinit, or autoloaded as a file named _conddp.
std::string zsh_completion(const Command& root);
/// To be sourced, or read by fish as a file named conddp.fish.
std::string fish_completion(const Command& root);

}  // namespace conddp
