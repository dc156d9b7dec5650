#pragma once

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

#include "process.hpp"

namespace conddp {

/// An input that must be refused, as tests/broken/README.md describes it.
struct BrokenCase {
  std::string group;  ///< its file
  std::string name;
  struct Change {
    std::string file, from, to;
  };
  std::vector<Change> changes;
  std::vector<std::pair<std::string, std::string>> writes;  ///< file and content
  std::vector<std::string> folders, fifos;
  std::vector<std::pair<std::string, std::string>> links;  ///< target and name
  std::vector<std::string> arguments;
  std::vector<std::string> says;

  /// Puts the good files and this case's own into a folder.
  void prepare(const TemporaryFolder& folder) const;
};

/// How GoogleTest shows one.
void PrintTo(const BrokenCase& broken, std::ostream* stream);

/// The cases of tests/broken/*.yaml.
std::vector<BrokenCase> broken_cases();

/// Puts the inputs without a mistake into a folder.
void write_good_inputs(const TemporaryFolder& folder);

}  // namespace conddp
