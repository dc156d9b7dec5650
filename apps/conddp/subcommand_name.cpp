#include "subcommand_name.hpp"

namespace conddp {

SubcommandName::SubcommandName(const CLI::App& app) {
  desc_function_ = [&app] {
    std::string names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
      names += (names.empty() ? "" : ",") + command->get_name();
    return "{" + names + "}";
  };
  func_ = [&app](std::string& name) {
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
      if (command->get_name() == name) return std::string();
    return "unknown subcommand '" + name + "'";
  };
}

}  // namespace conddp
