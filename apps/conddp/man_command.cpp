#include <filesystem>

#include "base/atomic_file.hpp"
#include "commands.hpp"
#include "exit_codes.hpp"
#include "man_page.hpp"
#include "streams.hpp"
#include "subcommand_name.hpp"

namespace conddp {
namespace {

void write_pages(const CommandDoc& root, const std::filesystem::path& folder) {
  create_folder(folder);
  AtomicFiles files;
  const auto add = [&](const CommandDoc& command) {
    files.add(folder / (man_page_name(command) + ".1"), man_page(command, root));
  };
  add(root);
  for (const CommandDoc& command : root.commands) add(command);
  files.commit();
}

}  // namespace

void add_man_command(CLI::App& app, Command& chosen) {
  CLI::App* command =
      app.add_subcommand("man", "Print the manual page of conddp or of a subcommand (roff)");
  command->footer(
      "To read one: conddp man solve | man -l -\n"
      "'cmake --install' puts all of them where man finds them.");
  const auto name = std::make_shared<std::string>();
  const auto folder = std::make_shared<std::string>();
  command->add_option("SUBCOMMAND", *name, "The subcommand")
      ->type_name("SUBCOMMAND")
      ->check(SubcommandName(app));
  command->add_option("-o,--output", *folder, "Write all pages into this folder instead")
      ->type_name("FOLDER");
  command->callback([name, folder, &app, &chosen] {
    chosen = [name, folder, &app] {
      const CommandDoc root = describe(app);
      if (!folder->empty())
        write_pages(root, *folder);
      else
        print_result(man_page(name->empty() ? root : describe(*app.get_subcommand(*name)), root));
      return kExitConverged;
    };
  });
}

}  // namespace conddp
