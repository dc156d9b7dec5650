#pragma once

#include <initializer_list>
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
  /// `what`: the subject of error messages, such as "HDF5". Of `files` the first that can be
  /// loaded: a path, in which "$ORIGIN" is the folder of the program, or a name for which the
  /// linker searches. Throws LibraryError, with the reason of the last one.
  SharedLibrary(const std::string& what, std::initializer_list<const char*> files);

  /// The address of a function or variable. Throws LibraryError.
  void* symbol(const char* name) const;
  /// The same, null where there is none.
  void* find(const char* name) const;

 private:
  std::string what_;
  void* handle_;
};

}  // namespace conddp
