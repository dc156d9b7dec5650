#include "output/atomic_file.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

namespace conddp {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw OutputError(fmt::format("'{}' cannot be written: {}", file.string(), std::strerror(error)));
}

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  /// Some file systems report a full disk only here.
  bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

void write_all(int descriptor, const std::string& contents, const std::filesystem::path& file) {
  for (std::size_t done = 0; done < contents.size();) {
    const ssize_t n = ::write(descriptor, contents.data() + done, contents.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file, errno);
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

AtomicFiles::~AtomicFiles() {
  for (const Pending& p : pending_) ::unlink(p.temporary.c_str());
}

void AtomicFiles::add(const std::filesystem::path& file, const std::string& contents) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) fail(file, EISDIR);
  const std::filesystem::path temporary =
      file.parent_path() / fmt::format(".{}.{}.tmp", file.filename().string(), ::getpid());
  ::unlink(temporary.c_str());  // left by a killed process that had our number
  Descriptor descriptor(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (descriptor.get() < 0) fail(file, errno);
  pending_.push_back({temporary, file});
  write_all(descriptor.get(), contents, file);
  // Pipes and the like cannot be flushed to a disk, which is no defect.
  if (::fsync(descriptor.get()) != 0 && errno != EINVAL && errno != ENOTSUP) fail(file, errno);
  if (!descriptor.close()) fail(file, errno);
}

void AtomicFiles::commit() {
  while (!pending_.empty()) {
    const Pending& p = pending_.back();
    if (::rename(p.temporary.c_str(), p.file.c_str()) != 0) fail(p.file, errno);
    pending_.pop_back();
  }
}

void create_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error))
    throw OutputError(fmt::format("the folder '{}' cannot be made: {}", folder.string(),
                                  error ? error.message() : "something else has its name"));
}

}  // namespace conddp
