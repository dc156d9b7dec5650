#include <filesystem>

#include "base/files/atomic_file.hpp"
#include "commands/commands.hpp"
#include "help/help.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

void write_pages(const Command& tool, const std::filesystem::path& folder) {
  create_folder(folder);
  AtomicFiles files;
  const auto add = [&](const Command& command) {
    files.add(folder / (man_page_name(command) + ".1"), man_page(command));
  };
  add(tool);
  for (const Command& command : tool.commands) add(command);
  files.commit();
}

}  // namespace

Command man_command(const Command& tool) {
  const auto name = std::make_shared<std::string>();
  const auto folder = std::make_shared<std::string>();
  return {.name = "conddp man",
          .description = "Print the manual page of conddp or of a subcommand (roff)",
          .details =
              "To read one: conddp man solve | man -l -\n"
              "'cmake --install' puts all of them where man finds them.",
          .arguments = {{.names = {kSubcommandValue},
                         .value = kSubcommandValue,
                         .description = "The subcommand",
                         .target = name.get()},
                        {.names = {"-o", "--output"},
                         .value = "FOLDER",
                         .description = "Write all pages into this folder instead",
                         .target = folder.get()}},
          .run = [name, folder, &tool] {
            if (!folder->empty())
              write_pages(tool, *folder);
            else
              print_result(man_page(name->empty() ? tool : *tool.find(*name)));
            return kExitConverged;
          }};
}

}  // namespace conddp
