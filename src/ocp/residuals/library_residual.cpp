#include "ocp/residuals/library_residual.hpp"

#include <mutex>

namespace conddp {
namespace {

/// Workspaces for all simultaneous evaluations.
class WorkspacePool {
 public:
  explicit WorkspacePool(const LibraryKnotFunction& function) : function_(function) {}

  template <class Run>
  void run(Run run) const {
    LibraryKnotFunction::OwnedWorkspace workspace = take();
    run(*workspace);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(workspace));
  }

 private:
  LibraryKnotFunction::OwnedWorkspace take() const {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        auto workspace = std::move(free_.back());
        free_.pop_back();
        return workspace;
      }
    }
    return function_.create_workspace();
  }

  const LibraryKnotFunction& function_;
  mutable std::mutex mutex_;
  mutable std::vector<LibraryKnotFunction::OwnedWorkspace> free_;
};

/// Index in (x, u) of each column of z, controls after the states; −1: the time is a parameter.
std::vector<int> sources_of(const LibraryKnotFunction& function, const LibraryInputs& inputs) {
  std::vector<int> sources = inputs.states;
  for (int i = 0; i < function.sizes().controls; ++i) sources.push_back(inputs.ndx + i);
  if (function.reads_time()) sources.push_back(inputs.clock);
  return sources;
}

std::vector<RowBlock> blocks_of(const LibraryKnotFunction& function,
                                const std::vector<int>& sources) {
  std::vector<RowBlock> rows;
  for (const std::vector<int>& columns : function.structure()) {
    RowBlock& row = rows.emplace_back(RowBlock{1, {}});
    for (const int column : columns)
      if (sources[column] >= 0) row.columns.push_back(sources[column]);
  }
  return joined_blocks(std::move(rows));
}

class LibraryResidual : public ResidualBase<LibraryResidual> {
 public:
  LibraryResidual(std::shared_ptr<const LibraryKnotFunction> function, const LibraryInputs& inputs,
                  const std::vector<int>& sources)
      : ResidualBase(blocks_of(*function, sources),
                     function->rows() + (function->reads_time() && inputs.clock < 0 ? 1 : 0),
                     function->reads_control()),
        function_(std::move(function)),
        ndx_(inputs.ndx),
        sources_(sources),
        pool_(*function_) {
    const std::vector<PackedRow> packed = packed_rows(*this);
    for (int row = 0; row < size(); ++row)
      for (const int column : function_->structure()[row])
        if (sources_[column] >= 0)
          entries_.push_back({packed[row].place(sources_[column]), column * size() + row});
  }

  Reads reads() const override { return Reads::kinematics; }
  std::vector<std::string> failed_functions() const override {
    return function_->failed_functions();
  }
  bool has_claimed_hessian() const override { return function_->has_hessian(); }

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    with_stack_numbers<S>(function_->columns(), [&](S* z) {
      gather(in, z);
      pool_.run([&](auto& workspace) { function_->evaluate(z, workspace, r); });
    });
    subtract_references(in, r);
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    const int columns = function_->columns();
    with_stack_numbers<S>(columns * (1 + size()), [&](S* z) {
      S* J = z + columns;
      gather(in, z);
      pool_.run([&](auto& workspace) { function_->differentiate(z, workspace, r, J); });
      for (const Entry& entry : entries_) jacobian[entry.place] = J[entry.index];
    });
    subtract_references(in, r);
  }

 private:
  /// An entry of the packed Jacobian and the matching entry of the function's.
  struct Entry {
    int place;
    int index;
  };

  /// The last node has no control; the function does not depend on it there.
  template <class S>
  void gather(const ResidualInput<S>& in, S* z) const {
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const int source = sources_[i];
      if (source < 0)
        z[i] = in.parameters[size()];
      else if (source < ndx_)
        z[i] = in.x[source];
      else
        z[i] = in.u != nullptr ? in.u[source - ndx_] : S(0.0);
    }
  }

  template <class S>
  void subtract_references(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < size(); ++i) r[i] -= in.parameters[i];
  }

  std::shared_ptr<const LibraryKnotFunction> function_;
  int ndx_;
  std::vector<int> sources_;
  std::vector<Entry> entries_;
  WorkspacePool pool_;
};

}  // namespace

std::shared_ptr<const Residual> make_library_residual(
    std::shared_ptr<const LibraryKnotFunction> function, const LibraryInputs& inputs) {
  if (function->columns() * (1 + function->rows()) > kMostStackNumbers) return nullptr;
  const std::vector<int> sources = sources_of(*function, inputs);
  return std::make_shared<LibraryResidual>(std::move(function), inputs, sources);
}

}  // namespace conddp
