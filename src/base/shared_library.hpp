#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>

namespace conddp {

/// A library loaded at runtime is missing or incomplete. The message describes the unavailable
/// feature and the linker's reason.
class LibraryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A shared library that is loaded on first use. It is for libraries that pull in many others and
/// that few commands need. It stays loaded until the program ends.
class SharedLibrary {
 public:
  /// `what` is the subject of error messages, such as "HDF5". Loads the first of `files` that can
  /// be loaded. An entry is a path, with "$ORIGIN" for the folder of the program, or a name that
  /// the linker searches for. Throws LibraryError with the reason for the last one.
  SharedLibrary(const std::string& what, std::initializer_list<const char*> files);

  /// The address of a function or variable. Throws LibraryError.
  void* symbol(const char* name) const;
  /// Same as symbol(), but null if it does not exist.
  void* find(const char* name) const;

 private:
  std::string what_;
  void* handle_;
};

/// The command-line option that allows compiled code.
inline constexpr const char* kAllowCode = "--allow-code";

/// True if this process may run compiled code that problem files name. Such code has all rights of
/// the process, so a file cannot grant the permission; the user does. Initially false.
bool code_is_allowed();
/// Allows compiled code from now on, for the whole process and all its threads.
void allow_code();

}  // namespace conddp
