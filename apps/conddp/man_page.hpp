#pragma once

#include <string>

#include "command_doc.hpp"

namespace conddp {

/// The name of a command's manual page: "conddp-solve".
std::string man_page_name(const CommandDoc& command);

/// The manual page (section 1, roff with the macros of man(7)) of a command; `root` is conddp
/// itself.
std::string man_page(const CommandDoc& command, const CommandDoc& root);

}  // namespace conddp
