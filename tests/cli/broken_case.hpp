#pragma once

#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "process.hpp"

namespace conddp {

/// An input that must be rejected, as tests/broken/README.md describes.
struct BrokenCase {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> says;   ///< line beginnings on stderr
  std::vector<std::string> lacks;  ///< texts that must not appear
  YAML::Node node;                 ///< the whole case

  /// Writes the good inputs and the files of this case into a folder.
  void prepare(const TemporaryFolder& folder) const;
};

/// Files of tests/broken without ".yaml".
std::vector<std::string> broken_groups();
std::vector<BrokenCase> broken_cases(const std::string& group);

/// Writes the inputs without mistakes into a folder.
void write_good_inputs(const TemporaryFolder& folder);

}  // namespace conddp
