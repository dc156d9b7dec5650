#include "commands.hpp"
#include "completion.hpp"
#include "exit_codes.hpp"
#include "streams.hpp"

namespace conddp {
namespace {

struct Shell {
  const char* name;
  std::string (*script)(const CommandDoc& root);
};
constexpr Shell kShells[] = {
    {"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};

}  // namespace

void add_completion_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("completion", "Print a completion script for a shell");
  command->footer(
      "For the running shell:\n"
      "  bash: source <(conddp completion bash)\n"
      "  zsh:  source <(conddp completion zsh), after compinit\n"
      "  fish: conddp completion fish | source\n"
      "'cmake --install' puts the scripts where the shells find them.");
  const auto shell = std::make_shared<std::string>();
  std::vector<std::string> names;
  for (const Shell& known : kShells) names.emplace_back(known.name);
  command->add_option("SHELL", *shell, "The shell")
      ->required()
      ->type_name("SHELL")
      ->check(CLI::IsMember(names));
  command->callback([shell, &app, &chosen] {
    chosen = [shell, &app] {
      for (const Shell& known : kShells)
        if (*shell == known.name) print_result(known.script(describe(app)));
      return kExitConverged;
    };
  });
}

}  // namespace conddp
