#pragma once

namespace conddp {

/// A pipe whose ends are closed on destruction and are not inherited by programs started later.
class Pipe {
 public:
  /// Throws OutputError if the system cannot create a pipe.
  Pipe();
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int read_end() const { return ends_[0]; }
  int write_end() const { return ends_[1]; }
  void close_read_end() { close(0); }
  void close_write_end() { close(1); }
  /// Releases an end to the caller.
  int release_read_end();
  int release_write_end();

 private:
  void close(int end);

  int ends_[2];
};

}  // namespace conddp
