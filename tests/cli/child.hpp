#pragma once

#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "process.hpp"

namespace conddp {

/// Path of the tool.
std::string conddp_binary();

/// Two ends of a pipe or pseudo-terminal.
struct Channel {
  int ours = -1;
  int theirs = -1;
};

/// Throws std::runtime_error if the system has no pipe left.
Channel open_pipe();

/// Starts the tool with these streams as stdout and stderr and stdin as the only other inherited
/// descriptor. `prepare` runs in the child first. Closes the child's ends here.
pid_t start_conddp(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment, const Channel& out,
                   const Channel& err, const std::function<void()>& prepare);

/// Reads both streams to their ends and waits for the child; calls `on_text` after every piece.
/// Kills a child that is silent for a minute. Closes our ends.
ProcessResult collect_child(pid_t child, const Channel& out, const Channel& err,
                            const std::function<void(const ProcessResult&)>& on_text);

}  // namespace conddp
