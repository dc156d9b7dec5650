#include "commands.hpp"
#include "exit_codes.hpp"
#include "help_text.hpp"
#include "streams.hpp"
#include "subcommand_name.hpp"
#include "terminal.hpp"

namespace conddp {

void add_help_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("help", "Explain conddp or a subcommand, as --help does");
  const auto name = std::make_shared<std::string>();
  command->add_option("SUBCOMMAND", *name, "The subcommand")
      ->type_name("SUBCOMMAND")
      ->check(SubcommandName(app));
  command->callback([name, &app, &chosen] {
    chosen = [name, &app] {
      const CLI::App& subject = name->empty() ? app : *app.get_subcommand(*name);
      print_result(help_text(describe(subject), terminal_of(1).width));
      return kExitConverged;
    };
  });
}

}  // namespace conddp
