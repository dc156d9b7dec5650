#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"

namespace conddp {

/// Output of a finished process.
struct ProcessResult {
  int exit_code = -1;  ///< 128 + number after a signal
  std::string out;
  std::string err;
};

/// System limits of a process; 0 means unlimited.
struct ProcessLimits {
  int processor_s = 0;
  long memory_bytes = 0;  ///< address space, not resident memory
};

struct ProcessOptions {
  std::filesystem::path folder;          ///< working folder; empty: the current one
  std::vector<std::string> environment;  ///< NAME=value, added to the current environment
  int signal = 0;                        ///< sent as soon as `signal_after` is printed
  std::string signal_after;              ///< on stderr
  int limit_file_size = -1;              ///< bytes, of any file that it writes
  ProcessLimits limits = {};
  int kill_after_us = -1;  ///< SIGKILL after this many microseconds
};

/// Runs the tool with arguments, stdout and stderr in pipes, and waits for it.
ProcessResult run_conddp(const std::vector<std::string>& arguments,
                         const ProcessOptions& options = {});

std::string read_file(const std::filesystem::path& file);
/// A file of the source tree.
std::string source(const std::string& name);
/// True if a document satisfies schemas/<schema>.schema.json.
bool fits_schema(const std::string& schema, const std::string& document);
/// An example problem that solves quickly.
inline const std::string kPendulum = source("problems/pendulum_swingup.yaml");

}  // namespace conddp
