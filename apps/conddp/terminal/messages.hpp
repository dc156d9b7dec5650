#pragma once

#include "base/text/diagnostic.hpp"

namespace conddp {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// How diagnostics look: as a compiler prints them, or one JSON object a line
/// (schemas/diagnostic.schema.json).
enum class MessageFormat { kText, kJson };

/// Of the whole process; main() sets it before anything else happens.
void set_message_format(MessageFormat format);
MessageFormat message_format();

/// Prints diagnostics to stderr: errors always, warnings unless quiet, notes when verbose.
void print_messages(const Diagnostics& diagnostics, Verbosity verbosity);

/// Prints one error that has no place in a file.
void print_error(std::string message, std::string hint = {},
                 std::vector<std::string> accepted = {});

}  // namespace conddp
