#pragma once

#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "process.hpp"

namespace conddp {

/// The two ends of a pipe or pseudo-terminal.
struct Channel {
  int ours = -1;
  int theirs = -1;
};

/// Throws std::runtime_error where the system has none left.
Channel open_pipe();

/// Starts the tool with these streams as stdout and stderr and no other descriptor of ours but
/// stdin. `prepare` runs in the child before that. Closes their ends here.
pid_t start_conddp(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment, const Channel& out,
                   const Channel& err, const std::function<void()>& prepare);

/// Reads both streams to their ends and waits for the child; `on_text` is called after every piece.
/// A child that is silent for a minute is killed. Closes our ends.
ProcessResult collect_child(pid_t child, const Channel& out, const Channel& err,
                            const std::function<void(const ProcessResult&)>& on_text);

}  // namespace conddp
