#include "batch/results/hdf5_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <hdf5.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/descriptor.hpp"
#include "base/shared_library.hpp"

// The header's macros call these, which would require linking the library.
#undef H5CHECK
#define H5CHECK
#undef H5OPEN
#define H5OPEN

namespace conddp {
namespace {

/// Approximate size of a chunk, in numbers or bytes.
constexpr std::size_t kChunk = 1 << 16;
constexpr std::size_t kMostRowsInChunk = 1024;

/// The HDF5 library, loaded when the first data set is written. It pulls in tens of other
/// libraries, which would delay other commands.
class Hdf5Library {
  const SharedLibrary library_{"HDF5, which writes dataset.h5,", {CONDDP_HDF5_LIBRARY}};

 public:
  /// Disables the library's exit handler; close() does its work. After a full disk, a half-written
  /// file stays open, and closing it again at exit would crash.
  Hdf5Library() {
    H5dont_atexit();
    if (H5open() < 0) throw OutputError("the library of HDF5 cannot be started");
  }

#define CONDDP_HDF5_FUNCTION(name) \
  decltype(&::name) const name = reinterpret_cast<decltype(&::name)>(library_.symbol(#name))
  CONDDP_HDF5_FUNCTION(H5dont_atexit);
  CONDDP_HDF5_FUNCTION(H5open);
  CONDDP_HDF5_FUNCTION(H5Aclose);
  CONDDP_HDF5_FUNCTION(H5Acreate2);
  CONDDP_HDF5_FUNCTION(H5Awrite);
  CONDDP_HDF5_FUNCTION(H5Dclose);
  CONDDP_HDF5_FUNCTION(H5Dcreate2);
  CONDDP_HDF5_FUNCTION(H5Dget_space);
  CONDDP_HDF5_FUNCTION(H5Dget_type);
  CONDDP_HDF5_FUNCTION(H5Dset_extent);
  CONDDP_HDF5_FUNCTION(H5Dwrite);
  CONDDP_HDF5_FUNCTION(H5Eset_auto2);
  CONDDP_HDF5_FUNCTION(H5Fclose);
  CONDDP_HDF5_FUNCTION(H5Fcreate);
  CONDDP_HDF5_FUNCTION(H5Fflush);
  CONDDP_HDF5_FUNCTION(H5Gclose);
  CONDDP_HDF5_FUNCTION(H5Gcreate2);
  CONDDP_HDF5_FUNCTION(H5Pclose);
  CONDDP_HDF5_FUNCTION(H5Pcreate);
  CONDDP_HDF5_FUNCTION(H5Pset_chunk);
  CONDDP_HDF5_FUNCTION(H5Pset_fill_time);
  CONDDP_HDF5_FUNCTION(H5Pset_libver_bounds);
  CONDDP_HDF5_FUNCTION(H5Pset_obj_track_times);
  CONDDP_HDF5_FUNCTION(H5Sclose);
  CONDDP_HDF5_FUNCTION(H5Screate_simple);
  CONDDP_HDF5_FUNCTION(H5Sget_simple_extent_dims);
  CONDDP_HDF5_FUNCTION(H5Sget_simple_extent_ndims);
  CONDDP_HDF5_FUNCTION(H5Sselect_hyperslab);
  CONDDP_HDF5_FUNCTION(H5Tclose);
  CONDDP_HDF5_FUNCTION(H5Tcopy);
  CONDDP_HDF5_FUNCTION(H5Tget_size);
  CONDDP_HDF5_FUNCTION(H5Tset_size);
  CONDDP_HDF5_FUNCTION(H5Tset_strpad);
#undef CONDDP_HDF5_FUNCTION

  /// The handle behind a macro of the header, stored in a variable of the library.
  hid_t variable(const char* name) const {
    return *static_cast<const hid_t*>(library_.symbol(name));
  }
};

const Hdf5Library& hdf5() {
  static const Hdf5Library library;
  return library;
}

/// A type for texts of a fixed length, padded with zeros. The caller must close it.
hid_t text_type(std::size_t length) {
  const hid_t type = hdf5().H5Tcopy(hdf5().variable("H5T_C_S1_g"));
  hdf5().H5Tset_size(type, std::max<std::size_t>(1, length));
  hdf5().H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& file, std::size_t most_rows)
    : file_(file), temporary_(file.string() + ".partial"), most_rows_(most_rows) {
  hdf5().H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // we report errors ourselves
  errno = 0;
  // From the format of HDF5 1.8 on, attributes may be longer than 64 kB.
  const hid_t creation = hdf5().H5Pcreate(hdf5().variable("H5P_CLS_FILE_CREATE_ID_g")),
              access = hdf5().H5Pcreate(hdf5().variable("H5P_CLS_FILE_ACCESS_ID_g"));
  hdf5().H5Pset_obj_track_times(creation, false);
  hdf5().H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  const hid_t created = hdf5().H5Fcreate(temporary_.c_str(), H5F_ACC_TRUNC, creation, access);
  hdf5().H5Pclose(access);
  hdf5().H5Pclose(creation);
  handle_ = checked(created);
}

Hdf5File::~Hdf5File() {
  if (committed_) return;
  for (const Handle array : arrays_) hdf5().H5Dclose(array);
  for (const Handle group : groups_) hdf5().H5Gclose(group);
  if (handle_ >= 0) hdf5().H5Fclose(handle_);
  std::error_code error;
  std::filesystem::remove(temporary_, error);
}

Hdf5File::Handle Hdf5File::checked(Handle value) const {
  if (value >= 0) return value;
  const std::string reason = errno == 0 ? "" : fmt::format(": {}", std::strerror(errno));
  throw OutputError(fmt::format("'{}' cannot be written{}", file_.string(), reason));
}

Hdf5File::Handle Hdf5File::add_group(const std::string& name) {
  errno = 0;
  const hid_t properties = hdf5().H5Pcreate(hdf5().variable("H5P_CLS_GROUP_CREATE_ID_g"));
  hdf5().H5Pset_obj_track_times(properties, false);
  const hid_t group =
      hdf5().H5Gcreate2(handle_, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT);
  hdf5().H5Pclose(properties);
  groups_.push_back(checked(group));
  return group;
}

Hdf5File::Handle Hdf5File::add(Handle group, const std::string& name, Handle type,
                               const std::vector<std::size_t>& shape) {
  errno = 0;
  std::vector<hsize_t> extent{0}, most{H5S_UNLIMITED}, chunk{1};
  std::size_t row = hdf5().H5Tget_size(type);
  for (const std::size_t size : shape) {
    extent.push_back(size);
    most.push_back(size);
    chunk.push_back(size);
    row *= size;
  }
  chunk[0] = std::clamp<std::size_t>(8 * kChunk / std::max<std::size_t>(1, row), 1,
                                     std::clamp<std::size_t>(most_rows_, 1, kMostRowsInChunk));
  const hid_t space =
      hdf5().H5Screate_simple(static_cast<int>(extent.size()), extent.data(), most.data());
  const hid_t properties = hdf5().H5Pcreate(hdf5().variable("H5P_CLS_DATASET_CREATE_ID_g"));
  hdf5().H5Pset_obj_track_times(properties, false);
  hdf5().H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  hdf5().H5Pset_fill_time(properties, H5D_FILL_TIME_ALLOC);  // zeros at the end of a chunk
  const hid_t array =
      hdf5().H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  hdf5().H5Pclose(properties);
  hdf5().H5Sclose(space);
  arrays_.push_back(checked(array));
  return array;
}

Hdf5File::Handle Hdf5File::add_array(Handle group, const std::string& name,
                                     const std::vector<std::size_t>& shape) {
  return add(group, name, hdf5().variable("H5T_IEEE_F64LE_g"), shape);
}

Hdf5File::Handle Hdf5File::add_texts(Handle group, const std::string& name, std::size_t length) {
  const hid_t type = text_type(length);
  const Handle texts = add(group, name, type, {});
  hdf5().H5Tclose(type);
  return texts;
}

void Hdf5File::append(Handle array, const void* row) {
  errno = 0;
  const hid_t before = checked(hdf5().H5Dget_space(array));
  std::vector<hsize_t> extent(static_cast<std::size_t>(hdf5().H5Sget_simple_extent_ndims(before)));
  hdf5().H5Sget_simple_extent_dims(before, extent.data(), nullptr);
  hdf5().H5Sclose(before);
  std::vector<hsize_t> start(extent.size(), 0), count = extent;
  start[0] = extent[0]++;
  count[0] = 1;
  checked(hdf5().H5Dset_extent(array, extent.data()));
  const hid_t space = hdf5().H5Dget_space(array), type = hdf5().H5Dget_type(array);
  hdf5().H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  const hid_t memory =
      hdf5().H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr);
  const herr_t written = hdf5().H5Dwrite(array, type, memory, space, H5P_DEFAULT, row);
  hdf5().H5Sclose(memory);
  hdf5().H5Tclose(type);
  hdf5().H5Sclose(space);
  checked(written);
}

void Hdf5File::append(Handle array, const std::vector<double>& row) {
  append(array, static_cast<const void*>(row.data()));
}

void Hdf5File::append(Handle texts, const std::string& row) {
  const hid_t type = checked(hdf5().H5Dget_type(texts));
  std::string padded = row;
  padded.resize(hdf5().H5Tget_size(type), '\0');
  hdf5().H5Tclose(type);
  append(texts, static_cast<const void*>(padded.data()));
}

void Hdf5File::annotate(Handle object, const std::string& name,
                        const std::vector<std::string>& texts) {
  if (texts.empty()) return;
  std::size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size());
  std::string all;
  for (const std::string& text : texts) all += text + std::string(length - text.size(), '\0');
  const hid_t type = text_type(length);
  const hsize_t count = texts.size();
  errno = 0;
  const hid_t space = hdf5().H5Screate_simple(1, &count, nullptr);
  const hid_t attribute =
      checked(hdf5().H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT));
  const herr_t written = hdf5().H5Awrite(attribute, type, all.data());
  hdf5().H5Aclose(attribute);
  hdf5().H5Sclose(space);
  hdf5().H5Tclose(type);
  checked(written);
}

void Hdf5File::commit() {
  close();
  if (!sync_to_disk(temporary_))
    throw OutputError(
        fmt::format("'{}' cannot be written: {}", file_.string(), std::strerror(errno)));
  std::error_code error;
  std::filesystem::rename(temporary_, file_, error);
  if (error)
    throw OutputError(fmt::format("'{}' cannot be written: {}", file_.string(), error.message()));
  committed_ = true;
  sync_to_disk(std::filesystem::absolute(file_).parent_path());
}

void Hdf5File::close() {
  errno = 0;
  for (const Handle array : arrays_) checked(hdf5().H5Dclose(array));
  arrays_.clear();
  for (const Handle group : groups_) checked(hdf5().H5Gclose(group));
  groups_.clear();
  checked(hdf5().H5Fflush(handle_, H5F_SCOPE_LOCAL));
  const Handle handle = handle_;
  handle_ = -1;
  checked(hdf5().H5Fclose(handle));
}

}  // namespace conddp
