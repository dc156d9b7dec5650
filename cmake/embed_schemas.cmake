# cmake -D OUTPUT=<file.cpp> -D SCHEMAS=<files, separated by |> -P embed_schemas.cmake
# Writes the source that holds the schemas' texts; apps/conddp/help/embedded_schemas.hpp declares it.
string(REPLACE "|" ";" schemas "${SCHEMAS}")
set(entries "")
foreach(schema IN LISTS schemas)
  get_filename_component(name "${schema}" NAME)
  string(REPLACE ".schema.json" "" kind "${name}")
  file(READ "${schema}" text)
  string(APPEND entries "    {\"${kind}\", R\"conddp_schema(${text})conddp_schema\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Written by cmake/embed_schemas.cmake.
#include \"help/embedded_schemas.hpp\"

namespace conddp {
namespace {

constexpr EmbeddedSchema kSchemas[] = {
${entries}};

}  // namespace

std::span<const EmbeddedSchema> embedded_schemas() { return kSchemas; }

const EmbeddedSchema* find_schema(std::string_view kind) {
  for (const EmbeddedSchema& schema : kSchemas)
    if (schema.kind == kind) return &schema;
  return nullptr;
}

}  // namespace conddp
")
