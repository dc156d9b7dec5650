#pragma once

#include <CLI/CLI.hpp>

namespace conddp {

/// Checks that a value names a subcommand, be it added before this check or after.
class SubcommandName : public CLI::Validator {
 public:
  explicit SubcommandName(const CLI::App& app);
};

}  // namespace conddp
