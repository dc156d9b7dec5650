#pragma once

#include "base/text/diagnostic.hpp"

namespace conddp {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Format of diagnostics: as printed by compilers, or one JSON object per line
/// (schemas/diagnostic.schema.json).
enum class MessageFormat { kText, kJson };

/// Applies to the whole process; main() sets it first.
void set_message_format(MessageFormat format);
MessageFormat message_format();

/// Prints diagnostics to stderr: errors always, warnings unless quiet, notes when verbose.
void print_messages(const Diagnostics& diagnostics, Verbosity verbosity);

/// Prints one error without a place in a file.
void print_error(std::string message, std::string hint = {},
                 std::vector<std::string> accepted = {});

}  // namespace conddp
