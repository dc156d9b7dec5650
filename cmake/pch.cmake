# Precompiled headers, each built once and shared:
#   conddp_pch_core   standard library, Eigen, fmt            (the numerical layers)
#   conddp_pch_files  the same and nlohmann/json, yaml-cpp    (cold: layers that read and write files, apps)
# A file named *_kernel.cpp never uses one: it is compiled with flags or macros of its own.
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/pch.cpp
  CONTENT "// Carries a precompiled header.\n")

set(CONDDP_PCH_CORE_HEADERS
  <algorithm> <array> <cmath> <concepts> <cstddef> <cstdint> <functional> <limits> <map> <memory>
  <optional> <span> <stdexcept> <string> <string_view> <utility> <variant> <vector>
  <Eigen/Dense> <fmt/format.h>)

# conddp_add_pch(NAME LINK targets... HEADERS headers...)
function(conddp_add_pch name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LINK;HEADERS")
  if(NOT CONDDP_PCH)
    return()
  endif()
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/generated/pch.cpp)
  target_link_libraries(${name} PRIVATE conddp_options Eigen3::Eigen fmt::fmt ${arg_LINK})
  target_precompile_headers(${name} PRIVATE ${CONDDP_PCH_CORE_HEADERS} ${arg_HEADERS})
endfunction()

# conddp_use_pch(TARGET PCH): TARGET reuses PCH, its kernels excepted.
function(conddp_use_pch target pch)
  if(NOT CONDDP_PCH)
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${pch})
  # CMake compiles programs with -fPIE, which does not fit the header of a library with -fPIC.
  get_target_property(type ${target} TYPE)
  get_target_property(shared ${target} POSITION_INDEPENDENT_CODE)
  if(type STREQUAL "EXECUTABLE" AND shared)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC -fno-semantic-interposition)
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "_kernel\\.cpp$")
  set_source_files_properties(${sources} TARGET_DIRECTORY ${target}
    PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endfunction()

conddp_add_pch(conddp_pch_core)
conddp_add_pch(conddp_pch_files
  LINK nlohmann_json::nlohmann_json conddp_yaml conddp_cold_options
  HEADERS <fstream> <sstream> <nlohmann/json.hpp> <yaml-cpp/yaml.h>)
