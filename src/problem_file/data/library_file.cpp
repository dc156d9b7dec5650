#include "problem_file/data/library_file.hpp"

#include <cstdint>
#include <cstring>
#include <string_view>

#include <elf.h>

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "base/shared_library.hpp"

namespace conddp {

namespace {

/// True if a library ends before the segments in its header do. The linker still maps them, and the
/// process crashes at the first access to the missing part.
bool is_cut_off(std::string_view bytes) {
  Elf64_Ehdr header;
  if (bytes.size() < sizeof(header) || !bytes.starts_with(ELFMAG)) return false;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.e_ident[EI_CLASS] != ELFCLASS64) return false;
  const auto holds = [&](std::uint64_t begin, std::uint64_t size) {
    return begin <= bytes.size() && size <= bytes.size() - begin;
  };
  for (int i = 0; i < header.e_phnum; ++i) {
    const std::uint64_t at = header.e_phoff + static_cast<std::uint64_t>(i) * header.e_phentsize;
    Elf64_Phdr segment;
    if (!holds(at, sizeof(segment))) return true;
    std::memcpy(&segment, bytes.data() + at, sizeof(segment));
    if (segment.p_type == PT_LOAD && !holds(segment.p_offset, segment.p_filesz)) return true;
  }
  return false;
}

}  // namespace

std::shared_ptr<const SharedLibrary> load_library_file(const std::filesystem::path& folder,
                                                       const Name& name, Diagnostics& out) {
  if (!code_is_allowed()) {
    out.error(
        name.place,
        fmt::format("'{}' is compiled code, which would run with all your permissions", name.value),
        fmt::format("pass {} on the command line if you trust it", kAllowCode));
    return nullptr;
  }
  const std::filesystem::path file = folder / name.value;
  const TextFile bytes = read_text_file(file, kMaxDataBytes);
  if (!bytes.defect.empty()) {
    out.error(name.place, bytes.defect, "the file is looked for beside the problem file");
    return nullptr;
  }
  if (is_cut_off(bytes.text)) {
    out.error(name.place, fmt::format("'{}' is cut off: its end is missing", file.string()),
              "compile or copy it again");
    return nullptr;
  }
  // The linker searches its own folders for a name without a folder.
  const std::string path = std::filesystem::absolute(file).string();
  try {
    auto library = std::make_shared<SharedLibrary>(
        fmt::format("'{}'", name.value), std::initializer_list<const char*>{path.c_str()});
    out.add_data_file({file.string(), sha256(bytes.text)});
    return library;
  } catch (const LibraryError& error) {
    out.error(name.place, error.what(),
              "compile it for this machine as a shared library: cc -O2 -shared -fPIC model.c -o "
              "model.so");
    return nullptr;
  }
}

}  // namespace conddp
