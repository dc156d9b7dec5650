#pragma once

#include <string>

#include "arguments/command.hpp"

namespace conddp {

/// The name of a command's manual page: "conddp-solve".
std::string man_page_name(const Command& command);

/// The manual page (section 1, roff with the macros of man(7)) of a command: its help, and the
/// environment.
std::string man_page(const Command& command);

}  // namespace conddp
