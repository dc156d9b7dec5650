#pragma once

#include <span>
#include <string_view>

#include "base/json/json_text.hpp"

namespace conddp {

/// A kind of thing that a problem file, or the command line, can name.
struct ListKind {
  std::string_view name;         ///< "solvers"
  std::string_view description;  ///< where they are named
  /// A list of objects: `name`, `description`, whatever else is to be said, and `keys`, a list of
  /// such objects (with `required` and `default`) where the thing has any. From the tables of the
  /// reader; what only the schema of the problem file says, which tests compare with the reader,
  /// from there.
  OrderedJson (*entries)();
};

std::span<const ListKind> list_kinds();

}  // namespace conddp
