#pragma once

#include <stdexcept>
#include <string>

namespace conddp {

/// A library that is loaded while the program runs is missing or lacks something. The message says
/// what cannot be done without it, and the linker's reason.
class LibraryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A shared library that is loaded when it is first used, for what takes many others along and few
/// commands need. It stays loaded until the program ends.
class SharedLibrary {
 public:
  /// `what`: the subject of error messages, such as "HDF5". `file` is searched for as the linker
  /// does: first in the folders that the program names itself. Throws LibraryError.
  SharedLibrary(const std::string& what, const char* file);

  /// The address of a function or variable. Throws LibraryError.
  void* symbol(const char* name) const;

 private:
  std::string what_;
  void* handle_;
};

}  // namespace conddp
