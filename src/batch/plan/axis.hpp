#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Limit on the rows of an axis and on the items of a plan.
inline constexpr long long kMostItems = 1'000'000;

/// A key that an axis sets.
struct AxisColumn {
  std::string name;  ///< in tables of results
  Name key;          ///< a path into the problem file
};

/// An axis of variation in a plan: keys of the problem, and their joint values, row by row.
struct Axis {
  Name name;
  std::vector<AxisColumn> columns;
  /// One value per column, with its place in the plan or in its table.
  std::vector<std::vector<YamlNode>> rows;
};

/// Reads an entry of `vary`, whose tables are in `folder`. After an error the axis may lack rows.
Axis read_axis(const Name& name, const YamlReader& reader, const std::filesystem::path& folder);

}  // namespace conddp
