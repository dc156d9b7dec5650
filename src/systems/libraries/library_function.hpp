#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/shared_library.hpp"

namespace conddp {

/// A function of a compiled library with the C interface of CasADi's generated code. Besides `f`
/// itself the library exports f_n_in, f_n_out, f_name_in, f_name_out, f_sparsity_in, f_sparsity_out
/// and f_work. f_checkout, f_release, f_incref and f_decref are optional. Numbers are double and
/// integers long long, the defaults of the generator.
class LibraryFunction {
 public:
  /// A matrix input or output. Only entries that can be nonzero are stored, column by column.
  struct Port {
    std::string name;
    int rows = 0, columns = 0;
    std::vector<int> row_of, column_of;  ///< of each stored number

    int stored() const { return static_cast<int>(row_of.size()); }
    /// True if it is a row or a column of `size` numbers and all of them are stored.
    bool is_vector(int size) const;
  };

  /// Memory for a single evaluation at a time.
  class Workspace {
   public:
    /// Evaluation computes only the `wanted` outputs.
    Workspace(const LibraryFunction& function, const std::vector<int>& wanted);
    ~Workspace();
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;

    /// The stored numbers of an input, initially zero.
    double* input(int index) { return numbers_.data() + inputs_[index]; }
    /// The stored numbers of a wanted output.
    const double* output(int index) const { return numbers_.data() + outputs_[index]; }

   private:
    friend class LibraryFunction;
    void (*release_)(int);
    int memory_;                         ///< handle checked out of the library
    std::vector<int> inputs_, outputs_;  ///< offsets into the numbers; −1: not wanted
    std::vector<double> numbers_, w_;
    std::vector<long long> iw_;
    std::vector<const double*> arguments_;
    std::vector<double*> results_;
  };

  /// Throws LibraryError if the library lacks the function or describes it inconsistently.
  LibraryFunction(std::shared_ptr<const SharedLibrary> library, std::string name);
  ~LibraryFunction();
  LibraryFunction(const LibraryFunction&) = delete;
  LibraryFunction& operator=(const LibraryFunction&) = delete;

  const std::string& name() const { return name_; }
  const std::vector<Port>& inputs() const { return inputs_; }
  const std::vector<Port>& outputs() const { return outputs_; }
  /// Computes the wanted outputs from the workspace's inputs. Returns false if the function fails.
  bool run(Workspace& workspace) const;
  /// True if any run has failed.
  bool has_failed() const { return failed_.load(std::memory_order_relaxed); }

 private:
  using Call = int (*)(const double**, double**, long long*, double*, int);

  template <class F>
  F entry(const char* suffix, bool required = true) const;
  std::vector<Port> ports(const char* direction) const;
  Port port(const char* direction, long long index) const;

  std::shared_ptr<const SharedLibrary> library_;
  std::string name_;
  Call call_;
  int (*checkout_)();
  void (*release_)(int);
  void (*decref_)();
  long long sizes_[4] = {};  ///< of arg, res, iw and w
  std::vector<Port> inputs_, outputs_;
  mutable std::atomic<bool> failed_ = false;
};

/// The index of the port with this name.
std::optional<int> find_port(const std::vector<LibraryFunction::Port>& ports,
                             std::string_view name);

}  // namespace conddp
