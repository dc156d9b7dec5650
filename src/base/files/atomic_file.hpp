#pragma once

#include <csignal>
#include <filesystem>
#include <optional>
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

/// While it lives, signals that end the process wait, as far as they come to this thread.
class SignalHold {
 public:
  SignalHold();
  ~SignalHold();
  SignalHold(const SignalHold&) = delete;
  SignalHold& operator=(const SignalHold&) = delete;

 private:
  sigset_t former_;
};

/// Files that appear together and whole: each is written under a temporary name in its folder and
/// flushed to the disk; only when all are there are they renamed, the first one added last. If
/// anything goes wrong, files of the same names stay as they were and no temporary one is left.
/// Signals that end the process wait from the first file to the last. Only one that is killed all
/// the same, between two renames, leaves some new and some former files, each of them whole; what
/// it leaves under temporary names is removed by the next one that writes there.
class AtomicFiles {
 public:
  AtomicFiles() = default;
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;
  /// Removes what was not committed.
  ~AtomicFiles();

  /// Writes the temporary file. A link stays one, and what it leads to is written. Throws
  /// OutputError, also where the name is that of a folder, device, pipe or socket.
  void add(const std::filesystem::path& file, const std::string& contents);
  /// Gives all files their names. Throws OutputError.
  void commit();

 private:
  struct Pending {
    std::filesystem::path temporary;
    std::filesystem::path file;
    int lock;                      ///< descriptor that shows others that we are alive
    std::filesystem::path former;  ///< second name of the file to be replaced, while renaming
  };
  void restore(std::size_t first);
  std::optional<SignalHold> hold_;  ///< goes last: signals come when nothing is left
  std::vector<Pending> pending_;
};

/// Makes a folder and those above it. Throws OutputError.
void create_folder(const std::filesystem::path& folder);

}  // namespace conddp
