#include <cstdio>
#include <memory>
#include <string>

#include "batch/session/problem_server.hpp"
#include "commands/commands.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

/// Reads a line without its end; false at the end of the input. Of a longer line than `limit`
/// bytes, one more is kept.
bool read_line(std::size_t limit, std::string& line) {
  line.clear();
  for (int c = std::getchar(); c != '\n'; c = std::getchar()) {
    if (c == EOF) return !line.empty();
    if (line.size() <= limit) line.push_back(static_cast<char>(c));
  }
  return true;
}

int serve() {
  int signal = 0;
  ProblemServer server([&signal](SolverOptions& options) {
    options.interrupted = [&signal] {
      signal = InterruptGuard::signal();
      return signal != 0;
    };
    return std::make_shared<InterruptGuard>();
  });
  std::string line;
  while (signal == 0 && read_line(ProblemServer::kLongestRequest, line)) {
    if (line.find_first_not_of(" \t\r") == line.npos) continue;
    print_result((line.size() > ProblemServer::kLongestRequest ? ProblemServer::refusal()
                                                               : server.reply(line)) +
                 "\n");
    if (finish_results() != nullptr) break;
  }
  return signal == 0 ? kExitConverged : kExitSignalBase + signal;
}

}  // namespace

Command serve_command() {
  return {.name = "conddp serve",
          .description = "Answer requests of other programs on standard input",
          .details =
              "Each line of standard input is a request, a JSON object, and each line of "
              "standard output its reply. Problems and answers stay in memory. Ctrl-C ends "
              "the current solve, which is answered, and the process.",
          .run = [] { return serve(); }};
}

}  // namespace conddp
