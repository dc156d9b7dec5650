#pragma once

namespace conddp {

/// A pipe whose ends close with it, and which programs started later do not inherit.
class Pipe {
 public:
  /// Throws OutputError where the system has none left.
  Pipe();
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int read_end() const { return ends_[0]; }
  int write_end() const { return ends_[1]; }
  void close_read_end() { close(0); }
  void close_write_end() { close(1); }
  /// Leaves an end to the caller.
  int release_read_end();
  int release_write_end();

 private:
  void close(int end);

  int ends_[2];
};

}  // namespace conddp
