# What the library and the tool need; scripts/setup installs it. The tests look for their own.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json 3.10 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PkgConfig REQUIRED)
pkg_check_modules(IPOPT REQUIRED ipopt)
pkg_check_modules(URDFDOM REQUIRED urdfdom)

# yaml-cpp 0.8 put its target into a namespace.
add_library(conddp_yaml INTERFACE)
if(TARGET yaml-cpp::yaml-cpp)
  target_link_libraries(conddp_yaml INTERFACE yaml-cpp::yaml-cpp)
else()
  target_link_libraries(conddp_yaml INTERFACE yaml-cpp)
endif()

# urdfdom's pkg-config file spells /usr/include in a roundabout way and would put it, as a system
# folder, before the standard library's own; so only the version is taken from there.
find_path(URDFDOM_INCLUDE_DIR urdf_parser/urdf_parser.h PATH_SUFFIXES urdfdom REQUIRED)
find_path(URDFDOM_HEADERS_INCLUDE_DIR urdf_model/model.h PATH_SUFFIXES urdfdom_headers REQUIRED)
find_library(URDFDOM_MODEL_LIBRARY urdfdom_model REQUIRED)
find_library(URDFDOM_WORLD_LIBRARY urdfdom_world REQUIRED)
find_library(CONSOLE_BRIDGE_LIBRARY console_bridge REQUIRED)
mark_as_advanced(URDFDOM_INCLUDE_DIR URDFDOM_HEADERS_INCLUDE_DIR URDFDOM_MODEL_LIBRARY
  URDFDOM_WORLD_LIBRARY CONSOLE_BRIDGE_LIBRARY)
add_library(conddp_urdfdom INTERFACE)
target_include_directories(conddp_urdfdom SYSTEM INTERFACE
  ${URDFDOM_INCLUDE_DIR} ${URDFDOM_HEADERS_INCLUDE_DIR})
target_link_libraries(conddp_urdfdom INTERFACE
  ${URDFDOM_WORLD_LIBRARY} ${URDFDOM_MODEL_LIBRARY} ${CONSOLE_BRIDGE_LIBRARY})

# Ipopt's pkg-config file lists the libraries of a static link, which need packages of their own.
find_library(IPOPT_LIBRARY ipopt REQUIRED)
mark_as_advanced(IPOPT_LIBRARY)
add_library(conddp_ipopt INTERFACE)
target_include_directories(conddp_ipopt SYSTEM INTERFACE ${IPOPT_INCLUDE_DIRS})
target_compile_options(conddp_ipopt INTERFACE ${IPOPT_CFLAGS_OTHER})
target_link_libraries(conddp_ipopt INTERFACE ${IPOPT_LIBRARY})
