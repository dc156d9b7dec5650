#pragma once

#include <span>
#include <vector>

#include "systems/graphs/graph.hpp"

namespace conddp {

/// An expression graph as a list of instructions on numbered registers, for any scalar. Immutable;
/// the caller owns the registers, which start with the inputs.
///
/// The instructions for the first `values` outputs do not depend on the other outputs. So values
/// alone and values with derivatives agree bit for bit.
class ExpressionProgram {
 public:
  ExpressionProgram() = default;
  ExpressionProgram(const ExpressionGraph& graph, std::span<const NodeId> outputs, int inputs,
                    int values);

  int inputs() const { return inputs_; }
  int registers() const { return registers_; }
  /// Register of an output.
  int output(int i) const { return outputs_[i]; }
  int instructions() const { return static_cast<int>(instructions_.size()); }

  /// Writes the constants into the registers; needed once before any number of runs.
  template <class S>
  void prepare(S* registers) const;
  /// Computes the outputs from the inputs.
  template <class S>
  void run(S* registers) const;

 private:
  enum class Code : std::int32_t;
  struct Instruction {
    Code code;
    std::int32_t to;
    std::int32_t a, b, c;
  };
  class Compiler;

  template <class S>
  void run_function(const Instruction& i, S* r) const;

  int inputs_ = 0;
  int registers_ = 0;
  std::vector<double> constants_;  ///< of the registers after the inputs
  std::vector<Instruction> instructions_;
  std::vector<std::int32_t> outputs_;
  ExpressionGraph::Tables tables_;
};

}  // namespace conddp
