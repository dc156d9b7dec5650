#include "base/files/atomic_file.hpp"

#include <cerrno>
#include <cstring>
#include <set>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/descriptor.hpp"

namespace conddp {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
  throw OutputError(fmt::format("'{}' cannot be written: {}", file.string(), std::strerror(error)));
}

/// The file that receives the contents, after following links. Only a regular file may be replaced:
/// replacing a device, pipe or socket would turn it into a regular file.
std::filesystem::path written_file(const std::filesystem::path& file) {
  std::error_code error;
  switch (std::filesystem::status(file, error).type()) {
    case std::filesystem::file_type::not_found:
    case std::filesystem::file_type::regular:
      break;
    case std::filesystem::file_type::directory:
      fail(file, EISDIR);
    case std::filesystem::file_type::none:
    case std::filesystem::file_type::unknown:
      fail(file, error.value());
    default:
      throw OutputError(
          fmt::format("'{}' cannot be written: it is not a regular file", file.string()));
  }
  constexpr int kMostLinks = 40;  // the system's own limit
  std::filesystem::path target = file;
  for (int links = 0; links < kMostLinks && std::filesystem::is_symlink(target, error); ++links) {
    target = target.parent_path() / std::filesystem::read_symlink(target, error);
    if (error) fail(file, error.value());
  }
  return target;
}

std::filesystem::path temporary_name(const std::filesystem::path& file, const char* kind) {
  return file.parent_path() /
         fmt::format(".{}.{}.{}.tmp", file.filename().string(), kind, ::getpid());
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.parent_path().empty() ? "." : file.parent_path();
}

/// Removes temporary files of this file that killed processes left behind: those without a lock.
void remove_leftovers(const std::filesystem::path& file) {
  const std::string start = "." + file.filename().string() + ".";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_of(file), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(start) || !name.ends_with(".tmp")) continue;
    // A pipe with such a name belongs to another program, and opening it would wait for a writer.
    if (std::error_code unknown; !std::filesystem::is_regular_file(entry.symlink_status(unknown)))
      continue;
    Descriptor leftover(
        ::open(entry.path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (leftover.get() >= 0 && ::flock(leftover.get(), LOCK_EX | LOCK_NB) == 0)
      ::unlink(entry.path().c_str());
  }
}

/// Creates a file and locks it, so that no other process removes it as a leftover.
int create_locked(const std::filesystem::path& temporary, const std::filesystem::path& file) {
  for (;;) {
    Descriptor made(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (made.get() < 0) fail(file, errno);
    struct stat found {};
    if (::flock(made.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) continue;
    if (::fstat(made.get(), &found) == 0 && found.st_nlink == 0)
      continue;  // another process has already removed it
    return made.release();
  }
}

}  // namespace

SignalHold::SignalHold() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&ending, signal);
  pthread_sigmask(SIG_BLOCK, &ending, &former_);
}

SignalHold::~SignalHold() { pthread_sigmask(SIG_SETMASK, &former_, nullptr); }

AtomicFiles::~AtomicFiles() {
  for (const Pending& p : pending_) {
    ::unlink(p.temporary.c_str());
    if (!p.former.empty()) ::unlink(p.former.c_str());
    ::close(p.lock);
  }
}

void AtomicFiles::add(const std::filesystem::path& name, const std::string& contents) {
  if (!hold_) hold_.emplace();
  const std::filesystem::path file = written_file(name);
  remove_leftovers(file);
  const std::filesystem::path temporary = temporary_name(file, "new");
  const int lock = create_locked(temporary, file);
  pending_.push_back({temporary, file, lock, {}});
  Descriptor descriptor(::dup(lock));
  if (descriptor.get() < 0) fail(file, errno);
  if (!write_all(descriptor.get(), contents)) fail(file, errno);
  if (!descriptor.close()) fail(file, errno);
}

void AtomicFiles::commit() {
  // Flushes all files at the end: a disk needs little more time for several files than for one.
  // Pipes and the like cannot be flushed, which is not an error.
  for (const Pending& p : pending_)
    if (::fsync(p.lock) != 0 && errno != EINVAL && errno != ENOTSUP) fail(p.file, errno);
  for (Pending& p : pending_) {
    const std::filesystem::path former = temporary_name(p.file, "former");
    if (::link(p.file.c_str(), former.c_str()) == 0) p.former = former;
  }
  for (std::size_t i = pending_.size(); i-- > 0;) {
    const Pending& p = pending_[i];
    if (::rename(p.temporary.c_str(), p.file.c_str()) == 0) continue;
    const int error = errno;
    restore(i + 1);
    fail(p.file, error);
  }
  std::set<std::filesystem::path> folders;
  for (const Pending& p : pending_) folders.insert(folder_of(p.file));
  for (const std::filesystem::path& path : folders)
    sync_to_disk(path);  // so that the names survive a power failure
  for (const Pending& p : pending_) {
    if (!p.former.empty()) ::unlink(p.former.c_str());
    ::close(p.lock);
  }
  pending_.clear();
  hold_.reset();
}

/// Reverts the renames of the files from index `first` onwards.
void AtomicFiles::restore(std::size_t first) {
  for (std::size_t i = first; i < pending_.size(); ++i) {
    Pending& p = pending_[i];
    if (p.former.empty())
      ::unlink(p.file.c_str());
    else if (::rename(p.former.c_str(), p.file.c_str()) == 0)
      p.former.clear();
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
