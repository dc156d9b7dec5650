#include "problem_file/data/library_file.hpp"

#include <fmt/format.h>

#include "base/code_permission.hpp"
#include "base/files/sha256.hpp"
#include "base/files/source_text.hpp"
#include "base/files/text_file.hpp"

namespace conddp {

std::shared_ptr<const SharedLibrary> load_library_file(const std::filesystem::path& folder,
                                                       const Name& name, Diagnostics& out) {
  if (!code_is_allowed()) {
    out.error(
        name.place,
        fmt::format("'{}' is compiled code, which would run with all your rights", name.value),
        fmt::format("say {} on the command line if you trust it", kAllowCode));
    return nullptr;
  }
  const std::filesystem::path file = folder / name.value;
  const TextFile bytes = read_text_file(file, kMaxDataBytes);
  if (!bytes.defect.empty()) {
    out.error(name.place, bytes.defect, "the file is looked for beside the problem file");
    return nullptr;
  }
  // The linker searches its own folders for a name without any.
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
