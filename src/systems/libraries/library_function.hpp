#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/shared_library.hpp"

namespace conddp {

/// A function of a compiled library with the C interface of the code that CasADi generates: beside
/// `f` itself f_n_in, f_n_out, f_name_in, f_name_out, f_sparsity_in, f_sparsity_out and f_work, and
/// where there are any, f_checkout and f_release, f_incref and f_decref. Numbers are double and
/// integers long long, as they are unless the generator was told otherwise.
class LibraryFunction {
 public:
  /// A matrix that goes in or comes out. Numbers that can be other than zero are stored, column by
  /// column.
  struct Port {
    std::string name;
    int rows = 0, columns = 0;
    std::vector<int> row_of, column_of;  ///< of each stored number

    int stored() const { return static_cast<int>(row_of.size()); }
    /// Whether it is a row or a column of `size` numbers, all of them stored.
    bool is_vector(int size) const;
  };

  /// Memory for one evaluation at a time.
  class Workspace {
   public:
    /// Outputs that are not `wanted` are not computed.
    Workspace(const LibraryFunction& function, const std::vector<int>& wanted);
    ~Workspace();
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;

    /// The stored numbers of an input, zero at first.
    double* input(int index) { return numbers_.data() + inputs_[index]; }
    /// Those of a wanted output.
    const double* output(int index) const { return numbers_.data() + outputs_[index]; }

   private:
    friend class LibraryFunction;
    void (*release_)(int);
    int memory_;                         ///< what was checked out of the library
    std::vector<int> inputs_, outputs_;  ///< into the numbers; −1: not wanted
    std::vector<double> numbers_, w_;
    std::vector<long long> iw_;
    std::vector<const double*> arguments_;
    std::vector<double*> results_;
  };

  /// Throws LibraryError where the library has no such function, or what it says of it cannot be.
  LibraryFunction(std::shared_ptr<const SharedLibrary> library, std::string name);
  ~LibraryFunction();
  LibraryFunction(const LibraryFunction&) = delete;
  LibraryFunction& operator=(const LibraryFunction&) = delete;

  const std::string& name() const { return name_; }
  const std::vector<Port>& inputs() const { return inputs_; }
  const std::vector<Port>& outputs() const { return outputs_; }
  /// Computes the wanted outputs of the workspace's inputs. False where the function fails.
  bool run(Workspace& workspace) const;
  /// Whether a run has failed so far.
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
