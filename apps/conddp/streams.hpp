#pragma once

#include <string_view>

namespace conddp {

/// To be called first: a reader that goes away (`conddp list | head -1`) is no error and ends
/// nothing, and files that are opened never take the place of a standard stream that is closed.
void prepare_streams();

/// Results, to stdout. What cannot be written is reported by finish_results().
void print_result(std::string_view text);

/// Messages and progress, to stderr, at once.
void print_message(std::string_view text);

/// Empties stdout. Returns why not everything could be written; null if it could, or if nobody was
/// left to read it.
const char* finish_results();

}  // namespace conddp
