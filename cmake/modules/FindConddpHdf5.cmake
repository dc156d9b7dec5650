# conddp_hdf5: the header of HDF5's C library, the serial one where Debian has several, and in
# CONDDP_HDF5_LIBRARY the name under which the library is loaded when a data set is written.
find_path(HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_LIBRARY NAMES hdf5_serial hdf5 PATH_SUFFIXES hdf5/serial)
mark_as_advanced(HDF5_INCLUDE_DIR HDF5_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ConddpHdf5
  REQUIRED_VARS HDF5_LIBRARY HDF5_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install libhdf5-dev")
if(ConddpHdf5_FOUND AND NOT TARGET conddp_hdf5)
  # "libhdf5_serial.so.103" of libhdf5_serial.so.103.3.0: programs run without the -dev package, too.
  file(REAL_PATH ${HDF5_LIBRARY} hdf5_file)
  get_filename_component(hdf5_name ${hdf5_file} NAME)
  string(REGEX REPLACE "(\\.so\\.[0-9]+).*" "\\1" hdf5_name ${hdf5_name})
  add_library(conddp_hdf5 INTERFACE IMPORTED)
  target_include_directories(conddp_hdf5 INTERFACE ${HDF5_INCLUDE_DIR})
  target_compile_definitions(conddp_hdf5 INTERFACE CONDDP_HDF5_LIBRARY="${hdf5_name}")
endif()
