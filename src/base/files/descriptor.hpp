#pragma once

#include <filesystem>
#include <string_view>
#include <utility>

#include <unistd.h>

namespace conddp {

/// An open file descriptor; negative if invalid.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }
  /// Closes the descriptor. Returns false on errors: some file systems report a full disk only
  /// here.
  bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

/// Writes a whole text to a blocking descriptor, and continues after interrupting signals. Returns
/// false on errors, with the reason in errno; part of the text may have been written.
bool write_all(int descriptor, std::string_view text);

/// Waits until a file's contents, or a folder's entries, are on disk. Returns false, with errno
/// set, on failure. Files that cannot be flushed, such as pipes, are not an error.
bool sync_to_disk(const std::filesystem::path& path);

}  // namespace conddp
