# conddp_version: what was built, from what, how. Only its one source file changes with the git
# revision, which every build looks at again.
set(generated ${PROJECT_BINARY_DIR}/generated)
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}" CONDDP_CXX_FLAGS)
string(REPLACE "\"" "\\\"" CONDDP_CXX_FLAGS "${CONDDP_CXX_FLAGS}")

set(CONDDP_LIBRARY_VERSIONS "")
foreach(library IN ITEMS
    Eigen=${Eigen3_VERSION} fmt=${fmt_VERSION} oneTBB=${TBB_VERSION} urdfdom=${URDFDOM_VERSION}
    pugixml=${pugixml_VERSION} libpng=${PNG_VERSION_STRING} yaml-cpp=${yaml-cpp_VERSION}
    nlohmann_json=${nlohmann_json_VERSION} CLI11=${CLI11_VERSION} Ipopt=${IPOPT_VERSION})
  string(REPLACE "=" "\", \"" entry "${library}")
  string(APPEND CONDDP_LIBRARY_VERSIONS "    {\"${entry}\"},\n")
endforeach()

# The revision is filled in by every build, the rest here.
set(CONDDP_REVISION "@CONDDP_REVISION@")
set(CONDDP_DIRTY "@CONDDP_DIRTY@")
configure_file(cmake/conddp_version.hpp ${generated}/include/conddp_version.hpp COPYONLY)
configure_file(cmake/conddp_version.cpp.in ${generated}/conddp_version.cpp.in @ONLY)

find_package(Git QUIET)
set(revision_step ${CMAKE_COMMAND}
  -D GIT=${GIT_EXECUTABLE} -D SOURCE_DIR=${PROJECT_SOURCE_DIR}
  -D INPUT=${generated}/conddp_version.cpp.in -D OUTPUT=${generated}/conddp_version.cpp
  -P ${PROJECT_SOURCE_DIR}/cmake/write_revision.cmake)
add_custom_target(conddp_revision
  COMMAND ${revision_step}
  BYPRODUCTS ${generated}/conddp_version.cpp
  COMMENT "Looking at the git revision"
  VERBATIM)

add_library(conddp_version STATIC ${generated}/conddp_version.cpp)
set_target_properties(conddp_version PROPERTIES EXPORT_NAME version)
add_dependencies(conddp_version conddp_revision)
target_include_directories(conddp_version PUBLIC $<BUILD_INTERFACE:${generated}/include>)
target_link_libraries(conddp_version PUBLIC conddp_abi $<BUILD_INTERFACE:conddp_options>)
