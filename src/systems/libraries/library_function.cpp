#include "systems/libraries/library_function.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Limits of a plausible function description.
constexpr long long kMostPorts = 100, kMostRows = 10'000, kMostMemory = 100'000'000;

/// Reads a sparsity pattern: rows, columns, and either a 1 for a full matrix or the column starts
/// and the row of each entry. Returns false if the pattern is invalid.
bool read_pattern(const long long* pattern, LibraryFunction::Port& port) {
  const long long rows = pattern[0], columns = pattern[1];
  if (rows < 0 || columns < 0 || rows > kMostRows || columns > kMostRows) return false;
  port.rows = static_cast<int>(rows);
  port.columns = static_cast<int>(columns);
  const long long* starts = pattern + 2;
  const bool full = columns > 0 && starts[0] == 1;
  const long long* entries = starts + columns + 1;
  for (int column = 0; column < port.columns; ++column) {
    const long long begin = full ? 0 : starts[column];
    const long long end = full ? rows : starts[column + 1];
    if (begin < 0 || end < begin || end - begin > rows) return false;
    for (long long i = begin; i < end; ++i) {
      const long long row = full ? i : entries[i];
      if (row < 0 || row >= rows) return false;
      port.row_of.push_back(static_cast<int>(row));
      port.column_of.push_back(column);
    }
  }
  return true;
}

}  // namespace

bool LibraryFunction::Port::is_vector(int size) const {
  return std::min(rows, columns) <= 1 && rows * columns == size && stored() == size;
}

std::optional<int> find_port(const std::vector<LibraryFunction::Port>& ports,
                             std::string_view name) {
  const auto found =
      std::find_if(ports.begin(), ports.end(), [&](const auto& port) { return port.name == name; });
  if (found == ports.end()) return std::nullopt;
  return static_cast<int>(found - ports.begin());
}

LibraryFunction::LibraryFunction(std::shared_ptr<const SharedLibrary> library, std::string name)
    : library_(std::move(library)),
      name_(std::move(name)),
      call_(entry<Call>("")),
      checkout_(entry<int (*)()>("_checkout", false)),
      release_(entry<void (*)(int)>("_release", false)),
      decref_(entry<void (*)()>("_decref", false)),
      inputs_(ports("in")),
      outputs_(ports("out")) {
  using Work = int (*)(long long*, long long*, long long*, long long*);
  const int failed = entry<Work>("_work")(&sizes_[0], &sizes_[1], &sizes_[2], &sizes_[3]);
  const bool sizes_can_be = std::all_of(std::begin(sizes_), std::end(sizes_), [](long long size) {
    return size >= 0 && size <= kMostMemory;
  });
  if (failed != 0 || !sizes_can_be)
    throw LibraryError(fmt::format("'{}_work' gives sizes that cannot be", name_));
  if (const auto incref = entry<void (*)()>("_incref", false)) incref();
}

LibraryFunction::~LibraryFunction() {
  if (decref_ != nullptr) decref_();
}

template <class F>
F LibraryFunction::entry(const char* suffix, bool required) const {
  const std::string symbol = name_ + suffix;
  void* found = library_->find(symbol.c_str());
  if (found == nullptr && required)
    throw LibraryError(fmt::format("the library has no function '{}'", symbol));
  return reinterpret_cast<F>(found);
}

LibraryFunction::Port LibraryFunction::port(const char* direction, long long index) const {
  using Named = const char* (*)(long long);
  using Sparsity = const long long* (*)(long long);
  const char* name = entry<Named>(fmt::format("_name_{}", direction).c_str())(index);
  const long long* pattern = entry<Sparsity>(fmt::format("_sparsity_{}", direction).c_str())(index);
  Port port;
  if (name == nullptr || pattern == nullptr || !read_pattern(pattern, port))
    throw LibraryError(fmt::format("'{}_sparsity_{}' describes no matrix", name_, direction));
  port.name = name;
  return port;
}

std::vector<LibraryFunction::Port> LibraryFunction::ports(const char* direction) const {
  const long long count = entry<long long (*)()>(fmt::format("_n_{}", direction).c_str())();
  if (count < 0 || count > kMostPorts)
    throw LibraryError(fmt::format("'{}_n_{}' gives {}", name_, direction, count));
  std::vector<Port> ports;
  for (long long i = 0; i < count; ++i) ports.push_back(port(direction, i));
  return ports;
}

bool LibraryFunction::run(Workspace& workspace) const {
  // The code may overwrite the pointer arrays and use the space after them, so we set them before
  // each call.
  for (std::size_t i = 0; i < inputs_.size(); ++i)
    workspace.arguments_[i] = workspace.numbers_.data() + workspace.inputs_[i];
  for (std::size_t i = 0; i < outputs_.size(); ++i)
    workspace.results_[i] =
        workspace.outputs_[i] < 0 ? nullptr : workspace.numbers_.data() + workspace.outputs_[i];
  const int code = call_(workspace.arguments_.data(), workspace.results_.data(),
                         workspace.iw_.data(), workspace.w_.data(), workspace.memory_);
  if (code != 0) failed_.store(true, std::memory_order_relaxed);
  return code == 0;
}

LibraryFunction::Workspace::Workspace(const LibraryFunction& function,
                                      const std::vector<int>& wanted)
    : release_(function.release_),
      memory_(function.checkout_ != nullptr ? function.checkout_() : 0),
      w_(function.sizes_[3]),
      iw_(function.sizes_[2]),
      arguments_(std::max<std::size_t>(function.sizes_[0], function.inputs_.size())),
      results_(std::max<std::size_t>(function.sizes_[1], function.outputs_.size())) {
  int size = 0;
  for (const Port& port : function.inputs_) {
    inputs_.push_back(size);
    size += port.stored();
  }
  outputs_.assign(function.outputs_.size(), -1);
  for (const int index : wanted) {
    outputs_[index] = size;
    size += function.outputs_[index].stored();
  }
  numbers_.resize(size);
}

LibraryFunction::Workspace::~Workspace() {
  if (release_ != nullptr) release_(memory_);
}

}  // namespace conddp
