#pragma once

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

}  // namespace conddp
