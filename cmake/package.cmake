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

# scripts/package: the Debian package by CPack, and the archive. The environment names the kind, which
# `conddp --version` prints.
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright COMPONENT tool)
install(CODE "
  if(DEFINED ENV{CONDDP_PACKAGE})
    file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/conddp/package\"
      \"\$ENV{CONDDP_PACKAGE}\\n\")
  endif()"
  COMPONENT tool)

# HDF5 is loaded by name, so dpkg-shlibdeps misses it. Ipopt's package depends on any BLAS, even a plain
# loop.
execute_process(COMMAND dpkg-query -S */${hdf5_name}
  OUTPUT_VARIABLE hdf5_package ERROR_QUIET)
string(REGEX REPLACE ":.*" "" hdf5_package "${hdf5_package}")
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL tool)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PACKAGE_CONTACT "The conddp authors")
set(CPACK_DEBIAN_TOOL_PACKAGE_NAME conddp)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS
  "${hdf5_package}, libopenblas0-serial | libopenblas0-pthread | libopenblas0-openmp")
include(CPack)
