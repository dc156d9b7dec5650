#include "base/files/sync_to_disk.hpp"

#include <cerrno>

#include <fcntl.h>
#include <unistd.h>

namespace conddp {

bool sync_to_disk(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP;
  const int error = errno;
  ::close(descriptor);
  errno = error;
  return done;
}

}  // namespace conddp
