#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace conddp {

/// A file could not be written; the message names the file and the reason.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// While it exists, blocks signals that would end the process, if they are delivered to this
/// thread.
class SignalHold {
 public:
  SignalHold();
  ~SignalHold();
  SignalHold(const SignalHold&) = delete;
  SignalHold& operator=(const SignalHold&) = delete;

 private:
  sigset_t former_;
};

/// A set of files that appear together and complete. Each is written under a temporary name in its
/// folder and flushed to disk. They are renamed only when all are complete, the first one added
/// last. After an error the previous files are unchanged, and no temporary file remains. Signals
/// that end the process are blocked from the first file to the last. A process killed between two
/// renames leaves some new and some former files, each complete. The next process that writes there
/// removes its temporary files.
class AtomicFiles {
 public:
  AtomicFiles() = default;
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;
  /// Removes all files that were not committed.
  ~AtomicFiles();

  /// Writes the temporary file. A link is preserved, and its target is written. Throws OutputError,
  /// also if the name is that of a folder, device, pipe or socket.
  void add(const std::filesystem::path& file, const std::string& contents);
  /// Renames all files to their final names. Throws OutputError.
  void commit();

 private:
  struct Pending {
    std::filesystem::path temporary;
    std::filesystem::path file;
    int lock;  ///< descriptor with a lock that shows other processes that we are alive
    std::filesystem::path former;  ///< second name of the replaced file during renaming
  };
  void restore(std::size_t first);
  std::optional<SignalHold> hold_;  ///< destroyed last: pending signals arrive after the cleanup
  std::vector<Pending> pending_;
};

/// Creates a folder and its parents. Throws OutputError.
void create_folder(const std::filesystem::path& folder);

inline constexpr std::size_t kLongestFolderName = 200;  ///< bytes
inline constexpr const char* kFolderNameRule =
    "the name is also that of a folder: no '/', no '\\', no '.' in front, at most 200 bytes";

/// True if a name denotes a direct subfolder that is not hidden.
inline bool names_folder(std::string_view name) {
  return name.find_first_of("/\\") == std::string_view::npos && !name.starts_with('.') &&
         name.size() <= kLongestFolderName;
}

}  // namespace conddp
