#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// The most rows of an axis and the most items of a plan.
inline constexpr long long kMostItems = 1'000'000;

/// One of the keys that an axis sets.
struct AxisColumn {
  std::string name;  ///< in tables of results
  Name key;          ///< a path into the problem file
};

/// What a plan varies: keys of the problem, and the values that they have together, row by row.
struct Axis {
  Name name;
  std::vector<AxisColumn> columns;
  /// One value a column, with places in the plan or in its table.
  std::vector<std::vector<YamlNode>> rows;
};

/// Reads an entry of `vary`, whose tables lie in `folder`. An axis with an error may lack rows.
Axis read_axis(const Name& name, const YamlReader& reader, const std::filesystem::path& folder);

}  // namespace conddp
