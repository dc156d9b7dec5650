#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"

namespace conddp {

/// What a finished process left behind.
struct ProcessResult {
  int exit_code = -1;  ///< 128 + number where a signal ended it
  std::string out;
  std::string err;
};

/// What a process may use before the system ends it or refuses it more; 0: as much as it likes.
struct ProcessLimits {
  int processor_s = 0;
  long memory_bytes = 0;  ///< addresses, more than what is in use
};

struct ProcessOptions {
  std::filesystem::path folder;          ///< to run in; empty: this one
  std::vector<std::string> environment;  ///< NAME=value, added to ours
  int signal = 0;                        ///< sent as soon as `signal_after` is printed
  std::string signal_after;              ///< on stderr
  int limit_file_size = -1;              ///< bytes, of any file that it writes
  ProcessLimits limits = {};
  int kill_after_us = -1;  ///< SIGKILL after so many microseconds
};

/// Runs the tool with arguments, stdout and stderr in pipes, and waits for it.
ProcessResult run_conddp(const std::vector<std::string>& arguments,
                         const ProcessOptions& options = {});

std::string read_file(const std::filesystem::path& file);
/// A file of the source tree.
std::string source(const std::string& name);
/// Whether a document's text keeps to schemas/<schema>.schema.json.
bool fits_schema(const std::string& schema, const std::string& document);
/// An example problem that is solved at once.
inline const std::string kPendulum = source("problems/pendulum_swingup.yaml");

}  // namespace conddp
