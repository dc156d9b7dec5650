#pragma once

#include <string>

#include "command_doc.hpp"

namespace conddp {

/// What `--help` prints, in lines of at most `width` characters.
std::string help_text(const CommandDoc& command, int width);

}  // namespace conddp
