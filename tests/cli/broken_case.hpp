#pragma once

#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "process.hpp"

namespace conddp {

/// An input that must be refused, as tests/broken/README.md describes it.
struct BrokenCase {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> says;   ///< beginnings of lines on stderr
  std::vector<std::string> lacks;  ///< texts that are nowhere there
  YAML::Node node;                 ///< all of it

  /// Puts the good inputs and this case's own into a folder.
  void prepare(const TemporaryFolder& folder) const;
};

/// The files of tests/broken, without ".yaml".
std::vector<std::string> broken_groups();
std::vector<BrokenCase> broken_cases(const std::string& group);

/// Puts the inputs without a mistake into a folder.
void write_good_inputs(const TemporaryFolder& folder);

}  // namespace conddp
