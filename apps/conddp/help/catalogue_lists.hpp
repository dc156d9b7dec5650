#pragma once

#include <span>
#include <string_view>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// A kind of entity that a problem file or the command line can name.
struct ListKind {
  std::string_view name;         ///< "solvers"
  std::string_view description;  ///< place where they are named
  /// A list of objects: `name`, `description`, further facts, and `keys` if any, a list of such
  /// objects (with `required` and `default`). The data come from the reader's tables, or if only
  /// the schema of the problem file contains them, from the schema, which tests compare with the
  /// reader.
  OrderedJson (*entries)();
};

std::span<const ListKind> list_kinds();

}  // namespace conddp
