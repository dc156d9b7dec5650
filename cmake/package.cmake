# cmake --install: the tool (component "tool") and, for programs of one's own, the libraries, headers
# and CMake package (component "library"). docs/library.md says how they are used.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/conddp)
set(generated ${PROJECT_BINARY_DIR}/generated)

foreach(set IN ITEMS core files)
  install(TARGETS ${CONDDP_${set}_TARGETS} EXPORT conddp-${set}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT conddp-${set} NAMESPACE conddp:: DESTINATION ${package_dir}
    FILE conddp-${set}-targets.cmake COMPONENT library)
endforeach()

# The library of the solver `ipopt` belongs to both components.
foreach(component IN ITEMS tool library)
  install(TARGETS conddp_ipopt_module
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/conddp COMPONENT ${component})
endforeach()

configure_file(cmake/abi.hpp.in ${generated}/abi.hpp @ONLY)
install(CODE "
  set(SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
  set(GENERATED_DIR \"${generated}\")
  set(STAGE_DIR \"${PROJECT_BINARY_DIR}/package\")
  set(INCLUDE_DIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake\")"
  COMPONENT library)

configure_package_config_file(cmake/conddp-config.cmake.in ${generated}/conddp-config.cmake
  INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
# Before 1.0 a minor version may change what programs see.
write_basic_package_version_file(${generated}/conddp-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(
  FILES ${generated}/conddp-config.cmake ${generated}/conddp-config-version.cmake
    cmake/vector_bytes.cmake
  DESTINATION ${package_dir} COMPONENT library)
install(DIRECTORY cmake/modules DESTINATION ${package_dir} COMPONENT library)
