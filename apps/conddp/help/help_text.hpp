#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

/// The output of `--help`, in lines of at most `width` characters.
std::string help_text(const Command& command, int width);

}  // namespace conddp
