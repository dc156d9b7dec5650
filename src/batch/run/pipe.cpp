#include "batch/run/pipe.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"

namespace conddp {

Pipe::Pipe() {
  if (::pipe2(ends_, O_CLOEXEC) != 0)
    throw OutputError(fmt::format("no pipe to another process: {}", std::strerror(errno)));
}

Pipe::~Pipe() {
  close(0);
  close(1);
}

int Pipe::release_read_end() { return std::exchange(ends_[0], -1); }
int Pipe::release_write_end() { return std::exchange(ends_[1], -1); }

void Pipe::close(int end) {
  if (ends_[end] >= 0) ::close(std::exchange(ends_[end], -1));
}

}  // namespace conddp
