# conddp_md: message digests of the BSDs (libmd), which load in no time.
find_path(MD_INCLUDE_DIR sha2.h)
find_library(MD_LIBRARY md)
mark_as_advanced(MD_INCLUDE_DIR MD_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ConddpMd
  REQUIRED_VARS MD_LIBRARY MD_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install libmd-dev")
if(ConddpMd_FOUND AND NOT TARGET conddp_md)
  add_library(conddp_md INTERFACE IMPORTED)
  target_include_directories(conddp_md INTERFACE ${MD_INCLUDE_DIR})
  target_link_libraries(conddp_md INTERFACE ${MD_LIBRARY})
endif()
