# Compile through ccache where it is installed and no other launcher was chosen.
# - The sloppiness is what ccache needs for precompiled headers.
# - Paths below the source tree are hashed relative to it and precompiled headers by their text, so that
#   another clone finds the results.
# - Results of -march=native must not travel to another processor: its features name the namespace.
find_program(CONDDP_CCACHE ccache)
mark_as_advanced(CONDDP_CCACHE)
if(NOT CONDDP_CCACHE OR CMAKE_CXX_COMPILER_LAUNCHER)
  return()
endif()

execute_process(
  COMMAND ${CMAKE_CXX_COMPILER} -march=native -Q --help=target
  OUTPUT_VARIABLE processor_features ERROR_QUIET)
string(SHA1 processor_hash "${processor_features}")
string(SUBSTRING "${processor_hash}" 0 12 processor_hash)

set(CMAKE_CXX_COMPILER_LAUNCHER
  ${CMAKE_COMMAND} -E env
  CCACHE_SLOPPINESS=pch_defines,time_macros
  CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}
  CCACHE_NOHASHDIR=1
  CCACHE_PCH_EXTSUM=1
  CCACHE_NAMESPACE=conddp-${processor_hash}
  ${CMAKE_CURRENT_LIST_DIR}/compile ${CONDDP_CCACHE})
add_compile_options(-ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)
