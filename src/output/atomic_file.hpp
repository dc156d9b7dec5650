#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace conddp {

/// A file could not be written; the message names it and says why.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Files that appear together and whole: each is written under a temporary name in its folder and
/// flushed to the disk; only when all are there are they renamed. Until then, and if anything goes
/// wrong, files of the same names stay as they were.
class AtomicFiles {
 public:
  AtomicFiles() = default;
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;
  /// Removes what was not committed.
  ~AtomicFiles();

  /// Writes the temporary file. Throws OutputError.
  void add(const std::filesystem::path& file, const std::string& contents);
  /// Gives all files their names. Throws OutputError.
  void commit();

 private:
  struct Pending {
    std::filesystem::path temporary;
    std::filesystem::path file;
  };
  std::vector<Pending> pending_;
};

/// Makes a folder and those above it. Throws OutputError.
void create_folder(const std::filesystem::path& folder);

}  // namespace conddp
