#pragma once

#include "arguments/command.hpp"

namespace conddp {

// The subcommands, one source file each, with their arguments and actions. Help, manual pages and
// completion are generated from these declarations.
Command solve_command();
Command check_command();
Command verify_command();
Command contacts_command();
Command bench_command();
Command batch_command();
Command mpc_command();
Command margins_command();
Command compare_command();
Command regress_command();
Command inspect_command();
Command reach_command();
Command init_command();
Command report_command();
Command serve_command();
Command list_command();
Command schema_command();

// These subcommands describe the whole tool and refer to it when they run.
Command completion_command(const Command& tool);
Command man_command(const Command& tool);
Command help_command(const Command& tool);

/// The value of an argument that names a subcommand: main() sets the names as choices.
inline constexpr const char* kSubcommandValue = "SUBCOMMAND";

}  // namespace conddp
