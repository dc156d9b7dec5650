#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

/// The output of `--help`, in lines of at most `width` characters.
std::string help_text(const Command& command, int width);

/// The name of a command's manual page: "conddp-solve".
std::string man_page_name(const Command& command);

/// The manual page (section 1, roff with the macros of man(7)) of a command: its help, and the
/// environment.
std::string man_page(const Command& command);

// Completion scripts for subcommands, flags, accepted words, files and folders.

/// For sourcing, or for bash-completion as a file named conddp.
std::string bash_completion(const Command& root);
/// For sourcing after compinit, or for autoloading as a file named _conddp.
std::string zsh_completion(const Command& root);
/// For sourcing, or for fish as a file named conddp.fish.
std::string fish_completion(const Command& root);

}  // namespace conddp
