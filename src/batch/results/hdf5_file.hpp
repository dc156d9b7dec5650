#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace conddp {

/// An HDF5 file that is being written, with stacked arrays in groups. Neither times nor addresses
/// go into it: the same calls give the same bytes. It appears under its name, whole, with commit().
/// Everything throws OutputError where the file cannot be written.
class Hdf5File {
 public:
  /// `most_rows`: no array gets more rows, so that none takes space for more at once.
  Hdf5File(const std::filesystem::path& file, std::size_t most_rows);
  /// Removes what was not committed.
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// A handle of a group, or of an array in one.
  using Handle = std::int64_t;
  Handle add_group(const std::string& name);
  /// Numbers of one shape, row by row; none yet.
  Handle add_array(Handle group, const std::string& name, const std::vector<std::size_t>& shape);
  /// Texts of at most `length` bytes, row by row.
  Handle add_texts(Handle group, const std::string& name, std::size_t length);
  /// The next row. Numbers: as many as the shape has.
  void append(Handle array, const std::vector<double>& row);
  void append(Handle texts, const std::string& row);
  /// Names, units or a remark at a group or array.
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
