#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace conddp {

/// An HDF5 file for writing stacked arrays in groups. It contains neither times nor addresses, so
/// the same calls produce the same bytes. commit() makes the complete file appear under its name.
/// All methods throw OutputError if the file cannot be written.
class Hdf5File {
 public:
  /// `most_rows` bounds the rows of every array, and thus the space allocated at once.
  Hdf5File(const std::filesystem::path& file, std::size_t most_rows);
  /// Removes the file if it was not committed.
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// A handle of a group or of one of its arrays.
  using Handle = std::int64_t;
  Handle add_group(const std::string& name);
  /// Adds an array for rows of one shape, initially without rows.
  Handle add_array(Handle group, const std::string& name, const std::vector<std::size_t>& shape);
  /// Adds an array for texts of at most `length` bytes.
  Handle add_texts(Handle group, const std::string& name, std::size_t length);
  /// Appends a row. The count of numbers must match the shape.
  void append(Handle array, const std::vector<double>& row);
  void append(Handle texts, const std::string& row);
  /// Attaches names, units or a remark to a group or array.
  void annotate(Handle object, const std::string& name, const std::vector<std::string>& texts);

  void commit();

 private:
  void close();
  Handle checked(Handle value) const;
  Handle add(Handle group, const std::string& name, Handle type,
             const std::vector<std::size_t>& shape);
  void append(Handle array, const void* row);

  const std::filesystem::path file_, temporary_;
  const std::size_t most_rows_;
  Handle handle_ = -1;
  std::vector<Handle> groups_, arrays_;
  bool committed_ = false;
};

}  // namespace conddp
