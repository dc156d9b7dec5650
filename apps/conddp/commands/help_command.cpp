#include <memory>

#include "commands/commands.hpp"
#include "help/help.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/streams.hpp"
#include "terminal/terminal.hpp"

namespace conddp {

Command help_command(const Command& tool) {
  const auto name = std::make_shared<std::string>();
  return {.name = "conddp help",
          .description = "Explain conddp or a subcommand, as --help does",
          .arguments = {{.names = {kSubcommandValue},
                         .value = kSubcommandValue,
                         .description = "The subcommand",
                         .target = name.get()}},
          .run = [name, &tool] {
            const Command& subject = name->empty() ? tool : *tool.find(*name);
            print_result(help_text(subject, terminal_of(1).width));
            return kExitConverged;
          }};
}

}  // namespace conddp
