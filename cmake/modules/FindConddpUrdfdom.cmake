# conddp_urdfdom: urdfdom's parser and data types. Its pkg-config file spells /usr/include in a
# roundabout way and would put it, as a system folder, before the standard library's own; so only the
# version is taken from there.
find_package(PkgConfig QUIET)
if(PKG_CONFIG_FOUND)
  pkg_check_modules(URDFDOM QUIET urdfdom)
endif()
find_path(URDFDOM_INCLUDE_DIR urdf_parser/urdf_parser.h PATH_SUFFIXES urdfdom)
find_path(URDFDOM_HEADERS_INCLUDE_DIR urdf_model/model.h PATH_SUFFIXES urdfdom_headers)
find_library(URDFDOM_MODEL_LIBRARY urdfdom_model)
find_library(URDFDOM_WORLD_LIBRARY urdfdom_world)
find_library(CONSOLE_BRIDGE_LIBRARY console_bridge)
mark_as_advanced(URDFDOM_INCLUDE_DIR URDFDOM_HEADERS_INCLUDE_DIR URDFDOM_MODEL_LIBRARY
  URDFDOM_WORLD_LIBRARY CONSOLE_BRIDGE_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ConddpUrdfdom
  REQUIRED_VARS URDFDOM_MODEL_LIBRARY URDFDOM_WORLD_LIBRARY CONSOLE_BRIDGE_LIBRARY
    URDFDOM_INCLUDE_DIR URDFDOM_HEADERS_INCLUDE_DIR
  VERSION_VAR URDFDOM_VERSION
  REASON_FAILURE_MESSAGE "install liburdfdom-dev")
if(ConddpUrdfdom_FOUND AND NOT TARGET conddp_urdfdom)
  add_library(conddp_urdfdom INTERFACE IMPORTED)
  target_include_directories(conddp_urdfdom INTERFACE
    ${URDFDOM_INCLUDE_DIR} ${URDFDOM_HEADERS_INCLUDE_DIR})
  target_link_libraries(conddp_urdfdom INTERFACE
    ${URDFDOM_WORLD_LIBRARY} ${URDFDOM_MODEL_LIBRARY} ${CONSOLE_BRIDGE_LIBRARY})
endif()
