#pragma once

#include <span>
#include <string_view>

namespace conddp {

/// An embedded file of schemas/.
struct EmbeddedSchema {
  std::string_view kind;  ///< "problem" of problem.schema.json
  std::string_view text;
};

/// All schemas, by name.
std::span<const EmbeddedSchema> embedded_schemas();
/// The schema of this kind, or null.
const EmbeddedSchema* find_schema(std::string_view kind);

}  // namespace conddp
