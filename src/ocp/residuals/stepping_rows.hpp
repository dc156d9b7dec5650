#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// The structure of the rows of a stepping system: the columns and the name of each row.
class SteppingRows {
 public:
  SteppingRows(const SteppingSystem& system, int ndx);

  std::vector<RowBlock> blocks;
  std::vector<std::string> names;
  std::vector<int> forces;  ///< entries of the control that act in the equations of motion, after u
  /// For each row after those of motion: the constant derivatives by entries of the control, which
  /// are the last columns of the row. Empty if they are not constant.
  std::vector<std::vector<double>> constants;

 private:
  /// Entries of the control and the constant derivatives by them.
  using Entries = std::vector<std::pair<int, double>>;

  void find_forces(const SteppingLayout& w);
  void candidate(const SteppingSystem& system, std::size_t c);
  /// The block of the equations of motion: q, v, u, a, then forces.
  void motion(const SteppingSystem& system);
  /// A row that depends on v and a of some joints, on q if requested, and on entries of the
  /// control.
  void add(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
           bool position, Entries entries);
  /// A row whose derivatives by entries of the control are not constant.
  void add_curved(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
                  bool position, const std::vector<int>& entries);
  void friction(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
                bool position, const FrictionIndices& f);
  /// The remaining friction budget; `entries`: the terms of the budget.
  void budget(const std::string& name, const SteppingLayout& w, const FrictionIndices& f,
              Entries entries);
  void cone(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
            const SteppingLayout::Candidate& at);

  int n_, ndx_;
};

}  // namespace conddp
