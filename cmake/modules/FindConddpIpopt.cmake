# conddp_ipopt: Ipopt. Its pkg-config file lists the libraries of a static link, which need packages
# of their own; so only the flags are taken from there.
find_package(PkgConfig QUIET)
if(PKG_CONFIG_FOUND)
  pkg_check_modules(IPOPT QUIET ipopt)
endif()
find_path(IPOPT_INCLUDE_DIR IpTNLP.hpp HINTS ${IPOPT_INCLUDE_DIRS} PATH_SUFFIXES coin-or coin)
find_library(IPOPT_LIBRARY ipopt)
mark_as_advanced(IPOPT_INCLUDE_DIR IPOPT_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ConddpIpopt
  REQUIRED_VARS IPOPT_LIBRARY IPOPT_INCLUDE_DIR
  VERSION_VAR IPOPT_VERSION
  REASON_FAILURE_MESSAGE "install coinor-libipopt-dev")
if(ConddpIpopt_FOUND AND NOT TARGET conddp_ipopt)
  add_library(conddp_ipopt INTERFACE IMPORTED)
  target_include_directories(conddp_ipopt INTERFACE ${IPOPT_INCLUDE_DIR} ${IPOPT_INCLUDE_DIRS})
  target_compile_options(conddp_ipopt INTERFACE ${IPOPT_CFLAGS_OTHER})
  target_link_libraries(conddp_ipopt INTERFACE ${IPOPT_LIBRARY})
endif()
