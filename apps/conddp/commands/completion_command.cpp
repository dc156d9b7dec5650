#include <memory>

#include "commands/commands.hpp"
#include "help/help.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct Shell {
  const char* name;
  std::string (*script)(const Command& tool);
};
constexpr Shell kShells[] = {
    {"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};

}  // namespace

Command completion_command(const Command& tool) {
  const auto shell = std::make_shared<std::string>();
  std::vector<std::string> names;
  for (const Shell& known : kShells) names.emplace_back(known.name);
  return {.name = "conddp completion",
          .description = "Print a completion script for a shell",
          .details =
              "For the running shell:\n"
              "  bash: source <(conddp completion bash)\n"
              "  zsh:  source <(conddp completion zsh), after compinit\n"
              "  fish: conddp completion fish | source\n"
              "'cmake --install' puts the scripts where the shells find them.",
          .arguments = {{.names = {"SHELL"},
                         .value = "SHELL",
                         .description = "The shell",
                         .choices = std::move(names),
                         .required = true,
                         .target = shell.get()}},
          .run = [shell, &tool] {
            for (const Shell& known : kShells)
              if (*shell == known.name) print_result(known.script(tool));
            return kExitConverged;
          }};
}

}  // namespace conddp
