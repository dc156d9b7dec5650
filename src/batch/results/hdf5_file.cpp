#include "batch/results/hdf5_file.hpp"

#include <algorithm>

#include <hdf5.h>

#include <fmt/format.h>

#include "base/atomic_file.hpp"

namespace conddp {
namespace {

/// Numbers or bytes in a chunk, about.
constexpr std::size_t kChunk = 1 << 16;

/// A type of texts of one length, padded with zeros. To be closed.
hid_t text_type(std::size_t length) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, std::max<std::size_t>(1, length));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& file)
    : file_(file), temporary_(file.string() + ".partial") {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are ours to report
  handle_ = checked(H5Fcreate(temporary_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
}

Hdf5File::~Hdf5File() {
  if (handle_ < 0) return;
  for (const Handle array : arrays_) H5Dclose(array);
  for (const Handle group : groups_) H5Gclose(group);
  H5Fclose(handle_);
  std::error_code error;
  std::filesystem::remove(temporary_, error);
}

Hdf5File::Handle Hdf5File::checked(Handle value) const {
  if (value < 0) throw OutputError(fmt::format("'{}' cannot be written", file_.string()));
  return value;
}

Hdf5File::Handle Hdf5File::add_group(const std::string& name) {
  const hid_t properties = H5Pcreate(H5P_GROUP_CREATE);
  H5Pset_obj_track_times(properties, false);
  const hid_t group = H5Gcreate2(handle_, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT);
  H5Pclose(properties);
  groups_.push_back(checked(group));
  return group;
}

Hdf5File::Handle Hdf5File::add(Handle group, const std::string& name, Handle type,
                               const std::vector<std::size_t>& shape) {
  std::vector<hsize_t> extent{0}, most{H5S_UNLIMITED}, chunk{1};
  std::size_t row = H5Tget_size(type);
  for (const std::size_t size : shape) {
    extent.push_back(size);
    most.push_back(size);
    chunk.push_back(size);
    row *= size;
  }
  chunk[0] = std::clamp<std::size_t>(8 * kChunk / std::max<std::size_t>(1, row), 1, 1024);
  const hid_t space = H5Screate_simple(static_cast<int>(extent.size()), extent.data(), most.data());
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(properties, false);
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  H5Pset_fill_time(properties, H5D_FILL_TIME_ALLOC);  // the end of a chunk is zero
  const hid_t array =
      H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  H5Pclose(properties);
  H5Sclose(space);
  arrays_.push_back(checked(array));
  return array;
}

Hdf5File::Handle Hdf5File::add_array(Handle group, const std::string& name,
                                     const std::vector<std::size_t>& shape) {
  return add(group, name, H5T_IEEE_F64LE, shape);
}

Hdf5File::Handle Hdf5File::add_texts(Handle group, const std::string& name, std::size_t length) {
  const hid_t type = text_type(length);
  const Handle texts = add(group, name, type, {});
  H5Tclose(type);
  return texts;
}

void Hdf5File::append(Handle array, const void* row) {
  const hid_t before = checked(H5Dget_space(array));
  std::vector<hsize_t> extent(static_cast<std::size_t>(H5Sget_simple_extent_ndims(before)));
  H5Sget_simple_extent_dims(before, extent.data(), nullptr);
  H5Sclose(before);
  std::vector<hsize_t> start(extent.size(), 0), count = extent;
  start[0] = extent[0]++;
  count[0] = 1;
  checked(H5Dset_extent(array, extent.data()));
  const hid_t space = H5Dget_space(array), type = H5Dget_type(array);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  const hid_t memory = H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr);
  const herr_t written = H5Dwrite(array, type, memory, space, H5P_DEFAULT, row);
  H5Sclose(memory);
  H5Tclose(type);
  H5Sclose(space);
  checked(written);
}

void Hdf5File::append(Handle array, const std::vector<double>& row) {
  append(array, static_cast<const void*>(row.data()));
}

void Hdf5File::append(Handle texts, const std::string& row) {
  const hid_t type = checked(H5Dget_type(texts));
  std::string padded = row;
  padded.resize(H5Tget_size(type), '\0');
  H5Tclose(type);
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
  const hid_t space = H5Screate_simple(1, &count, nullptr);
  const hid_t attribute =
      checked(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT));
  const herr_t written = H5Awrite(attribute, type, all.data());
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  checked(written);
}

void Hdf5File::commit() {
  close();
  std::error_code error;
  std::filesystem::rename(temporary_, file_, error);
  if (error)
    throw OutputError(fmt::format("'{}' cannot be written: {}", file_.string(), error.message()));
}

void Hdf5File::close() {
  for (const Handle array : arrays_) checked(H5Dclose(array));
  arrays_.clear();
  for (const Handle group : groups_) checked(H5Gclose(group));
  groups_.clear();
  checked(H5Fflush(handle_, H5F_SCOPE_LOCAL));
  const Handle handle = handle_;
  handle_ = -1;
  checked(H5Fclose(handle));
}

}  // namespace conddp
