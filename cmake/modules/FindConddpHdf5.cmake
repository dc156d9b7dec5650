# conddp_hdf5: HDF5's C library, the serial one where Debian has several.
find_path(HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_LIBRARY NAMES hdf5_serial hdf5 PATH_SUFFIXES hdf5/serial)
mark_as_advanced(HDF5_INCLUDE_DIR HDF5_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ConddpHdf5
  REQUIRED_VARS HDF5_LIBRARY HDF5_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install libhdf5-dev")
if(ConddpHdf5_FOUND AND NOT TARGET conddp_hdf5)
  add_library(conddp_hdf5 INTERFACE IMPORTED)
  target_include_directories(conddp_hdf5 INTERFACE ${HDF5_INCLUDE_DIR})
  target_link_libraries(conddp_hdf5 INTERFACE ${HDF5_LIBRARY})
endif()
