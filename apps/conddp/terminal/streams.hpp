#pragma once

#include <string_view>

namespace conddp {

/// Must be called first. Afterwards, a closed reader (`conddp list | head -1`) is not an error, and
/// opened files never take the place of a closed standard stream.
void prepare_streams();

/// Prints results to stdout without terminal control sequences (terminal_text): names from inputs
/// may contain anything. finish_results() reports failed output.
void print_result(std::string_view text);

/// Prints a text that is already in that form, except for our own colors.
void print_as_it_is(std::string_view text);

/// Prints messages and progress to stderr at once.
void print_message(std::string_view text);

/// Flushes stdout. Returns the reason for incomplete output; null if complete, or if the reader has
/// closed.
const char* finish_results();

}  // namespace conddp
