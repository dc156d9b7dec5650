#pragma once

#include <string_view>

namespace conddp {

/// To be called first: a reader that goes away (`conddp list | head -1`) is no error and ends
/// nothing, and files that are opened never take the place of a standard stream that is closed.
void prepare_streams();

/// Results, to stdout, in a form that no terminal takes for commands (terminal_text): names from
/// inputs may hold anything. What cannot be written is reported by finish_results().
void print_result(std::string_view text);

/// The same for a text that has that form, but for our own colours.
void print_as_it_is(std::string_view text);

/// Messages and progress, to stderr, at once.
void print_message(std::string_view text);

/// Empties stdout. Returns why not everything could be written; null if it could, or if no
/// reader was left.
const char* finish_results();

}  // namespace conddp
