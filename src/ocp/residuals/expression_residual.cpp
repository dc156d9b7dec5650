#include "ocp/residuals/expression_residual.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include <fmt/format.h>

#include "systems/graphs/compiled_system.hpp"
#include "systems/graphs/derivatives.hpp"

namespace conddp {
namespace {

/// An input of the program and its source in a knot.
struct KnotInputSource {
  enum class Kind { kState, kControl, kParameter, kOperand };
  Kind kind;
  int index;  ///< of an operand: its row among those of all operands
  int input;
};

/// Other residuals, evaluated consecutively into the rows of one vector.
class Operands {
 public:
  explicit Operands(std::vector<ExpressionOperand> operands) : operands_(std::move(operands)) {
    for (const ExpressionOperand& operand : operands_) {
      for (PackedRow row : packed_rows(*operand.residual)) {
        row.first += jacobian_size_;
        rows_.push_back(row);
      }
      jacobian_size_ += operand.residual->jacobian_size();
      parameters_ = std::max(parameters_, static_cast<int>(operand.parameters.size()));
    }
  }

  const std::vector<PackedRow>& rows() const { return rows_; }
  /// Numbers needed by a pass: rows, their derivatives, and the parameters of one operand.
  int numbers() const { return static_cast<int>(rows_.size()) + jacobian_size_ + parameters_; }
  bool need_control() const {
    return std::any_of(operands_.begin(), operands_.end(),
                       [](const ExpressionOperand& o) { return o.residual->needs_control(); });
  }
  Reads reads() const {
    Reads most = Reads::kinematics;
    for (const ExpressionOperand& operand : operands_)
      most = std::max(most, operand.residual->reads());
    return most;
  }
  bool have_claimed_hessian() const {
    return std::ranges::any_of(operands_, [](const ExpressionOperand& operand) {
      return operand.residual->has_claimed_hessian();
    });
  }
  std::vector<std::string> failed_functions() const {
    std::vector<std::string> all;
    for (const ExpressionOperand& operand : operands_)
      for (std::string& name : operand.residual->failed_functions()) all.push_back(std::move(name));
    return all;
  }
  /// Writes the rows and, if requested, the derivatives after them into numbers().
  template <class S>
  void evaluate(const ResidualInput<S>& in, bool derivatives, S* numbers) const {
    S *r = numbers, *jacobian = numbers + rows_.size(), *parameters = jacobian + jacobian_size_;
    for (const ExpressionOperand& operand : operands_) {
      for (std::size_t i = 0; i < operand.parameters.size(); ++i)
        parameters[i] = S(operand.parameters[i]);
      const ResidualInput<S> own{in.x, in.u, parameters, in.system};
      if (derivatives)
        operand.residual->differentiate(own, r, jacobian);
      else
        operand.residual->evaluate(own, r);
      r += operand.residual->size();
      jacobian += operand.residual->jacobian_size();
    }
  }

 private:
  std::vector<ExpressionOperand> operands_;
  std::vector<PackedRow> rows_;
  int jacobian_size_ = 0, parameters_ = 0;
};

/// Rows of the expressions with the columns of z on which they depend, also through operands. The
/// column `first_operand` + i stands for row i of the operands. A conditional row may jump between
/// branches of equal slope, so it is not affine.
std::vector<RowBlock> structure(const DifferentiableExpressions& functions,
                                const std::vector<bool>& chooses, const Operands& operands,
                                int first_operand) {
  std::vector<RowBlock> rows;
  for (const bool row_chooses : chooses) rows.push_back({1, {}, !row_chooses});
  for (const auto& entry : functions.jacobian()) {
    RowBlock& row = rows[entry.row];
    row.affine &= entry.constant;
    if (entry.column < first_operand) {
      row.columns.push_back(entry.column);
      continue;
    }
    const RowBlock& inner = *operands.rows()[entry.column - first_operand].block;
    row.columns.insert(row.columns.end(), inner.columns.begin(), inner.columns.end());
    row.affine &= inner.affine;
  }
  return joined_blocks(std::move(rows));
}

int count(const std::vector<KnotInputSource>& sources, KnotInputSource::Kind kind) {
  return static_cast<int>(
      std::count_if(sources.begin(), sources.end(),
                    [kind](const KnotInputSource& source) { return source.kind == kind; }));
}

class ExpressionResidual : public ResidualBase<ExpressionResidual> {
 public:
  ExpressionResidual(DifferentiableExpressions functions, const std::vector<bool>& chooses,
                     std::vector<KnotInputSource> sources, int parameters, Operands operands,
                     int first_operand, TableArguments tables)
      : ResidualBase(
            structure(functions, chooses, operands, first_operand), parameters,
            count(sources, KnotInputSource::Kind::kControl) > 0 || operands.need_control()),
        functions_(std::move(functions)),
        sources_(std::move(sources)),
        operands_(std::move(operands)),
        tables_(std::move(tables)) {
    const std::vector<PackedRow> packed = packed_rows(*this);
    for (const auto& entry : functions_.jacobian()) {
      const PackedRow& row = packed[entry.row];
      const auto add = [&](int column, int inner) {
        products_.push_back({row.place(column), entry.place, inner});
      };
      if (entry.column < first_operand) {
        add(entry.column, -1);
        continue;
      }
      const PackedRow& inner = operands_.rows()[entry.column - first_operand];
      for (std::size_t c = 0; c < inner.block->columns.size(); ++c)
        add(inner.block->columns[c], inner.first + static_cast<int>(c) * inner.block->rows);
    }
  }

  Reads reads() const override { return operands_.reads(); }
  std::vector<std::string> failed_functions() const override {
    return operands_.failed_functions();
  }
  bool has_claimed_hessian() const override { return operands_.have_claimed_hessian(); }

  std::vector<TableReading> table_readings(const double* x, const double* u,
                                           const double* parameters) const override {
    // Rows of operands are evaluated elsewhere and unknown here.
    return tables_.readings([&](int i) {
      const auto source = std::ranges::find(sources_, i, &KnotInputSource::input);
      const double* numbers = source == sources_.end()                            ? nullptr
                              : source->kind == KnotInputSource::Kind::kState     ? x
                              : source->kind == KnotInputSource::Kind::kControl   ? u
                              : source->kind == KnotInputSource::Kind::kParameter ? parameters
                                                                                  : nullptr;
      return numbers == nullptr ? std::nan("") : numbers[source->index];
    });
  }

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    run(functions_.values(), in, false, r, [](const S*, const S*) {});
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    run(functions_.with_derivatives(), in, true, r, [&](const S* registers, const S* inner) {
      std::fill_n(jacobian, jacobian_size(), S(0.0));
      for (const Product& product : products_) {
        const S& outer = registers[product.outer];
        jacobian[product.place] += product.inner < 0 ? outer : outer * inner[product.inner];
      }
    });
  }

 private:
  /// A summand of the derivative at `place`: a register, times the derivative of an operand's row
  /// if any.
  struct Product {
    int place;
    int outer;
    int inner;  ///< −1: none
  };

  template <class S, class Then>
  void run(const ExpressionProgram& program, const ResidualInput<S>& in, bool derivatives, S* r,
           Then then) const {
    with_stack_numbers<S>(program.registers() + operands_.numbers(), [&](S* registers) {
      S* operands = registers + program.registers();
      operands_.evaluate(in, derivatives, operands);
      program.prepare(registers);
      for (const KnotInputSource& source : sources_)
        registers[source.input] = from(source.kind, in, operands)[source.index];
      program.run(registers);
      for (int i = 0; i < size(); ++i) r[i] = registers[program.output(i)];
      then(registers, operands + operands_.rows().size());
    });
  }

  template <class S>
  static const S* from(KnotInputSource::Kind kind, const ResidualInput<S>& in, const S* operands) {
    switch (kind) {
      case KnotInputSource::Kind::kState:
        return in.x;
      case KnotInputSource::Kind::kControl:
        return in.u;
      case KnotInputSource::Kind::kParameter:
        return in.parameters;
      case KnotInputSource::Kind::kOperand:
        break;
    }
    return operands;
  }

  DifferentiableExpressions functions_;
  std::vector<KnotInputSource> sources_;
  Operands operands_;
  TableArguments tables_;
  std::vector<Product> products_;
};

/// Parses the texts of a residual.
class ResidualReader {
 public:
  using Part = ModelMessage::Part;

  ResidualReader(const StateManifold& manifold, const ExpressionResidualText& text,
                 ParsedExpressionResidual& out)
      : manifold_(manifold),
        text_(text),
        out_(out),
        texts_(graph_, false, out.errors, out.warnings) {}

  void read() {
    // Errors in names would cause misleading errors in the texts after them.
    add_names();
    if (texts_.good()) texts_.add_definitions(text_.definitions);
    if (!texts_.good()) return;
    for (std::size_t i = 0; i < text_.rows.size(); ++i) read_row(static_cast<int>(i));
    if (texts_.good()) make();
  }

 private:
  NodeId input(const KnotInputSource::Kind kind, int index) {
    const auto known =
        std::find_if(sources_.begin(), sources_.end(),
                     [&](const KnotInputSource& s) { return s.kind == kind && s.index == index; });
    if (known != sources_.end()) return graph_.input(known->input);
    const int next = static_cast<int>(sources_.size());
    sources_.push_back({kind, index, next});
    return graph_.input(next);
  }

  ExpressionValue value_of(const KnotName& name) {
    ExpressionValue value = ExpressionValue::vector({});
    for (const KnotName::Number& number : name.numbers)
      value.nodes.push_back(
          input(number.of_control ? KnotInputSource::Kind::kControl : KnotInputSource::Kind::kState,
                number.index));
    if (value.size() == 1 && name.parts.empty()) value.kind = ExpressionValue::Kind::kNumber;
    value.parts = name.parts;
    value.unit = name.unit;
    return value;
  }

  void add_names() {
    // States come first, number by number, in the order of the manifold.
    for (int i = 0; i < manifold_.nx(); ++i) input(KnotInputSource::Kind::kState, i);
    for (const KnotName& name : text_.names) {
      if (!texts_.scope().defect_of(name.name).empty()) continue;
      texts_.scope().add(name.name, value_of(name));
    }
    add_operands();
    add_times();
    texts_.add_parameters(text_.parameters);
    texts_.add_tables(text_.tables);
  }

  /// Parameter of a time; the times follow the references.
  NodeId time_number(int index) {
    return input(KnotInputSource::Kind::kParameter, kFirstTime - index);
  }

  /// Adds a time: `number` is its part independent of free durations, `share` the factor of each of
  /// these.
  void add_time(const char* name, int number, const std::function<NodeId(int)>& share) {
    const auto has_name = [&](const auto& list) {
      return std::ranges::any_of(list, [&](const auto& entry) { return name_of(entry) == name; });
    };
    // Names of the file take precedence; `t` is not available to it.
    const bool is_t = number == 0;
    if (texts_.scope().find(name) != nullptr ||
        (!is_t &&
         (has_name(text_.parameters) || has_name(text_.definitions) || has_name(text_.tables))))
      return;
    NodeId sum = time_number(number);
    for (std::size_t i = 0; i < text_.durations.size(); ++i) {
      const NodeId duration = input(KnotInputSource::Kind::kState, text_.durations[i]);
      sum = graph_.add(sum, graph_.multiply(share(static_cast<int>(i)), duration));
    }
    ExpressionValue time = ExpressionValue::number(sum);
    time.unit = "s";
    texts_.scope().add(name, std::move(time));
  }
  template <class Entry>
  static const std::string& name_of(const Entry& entry) {
    if constexpr (requires { entry.name; })
      return entry.name;
    else
      return entry.first;
  }

  void add_times() {
    const int durations = static_cast<int>(text_.durations.size());
    add_time("t", 0, [&](int i) { return time_number(kTimes + i); });
    add_time("phase_time", 1, [&](int i) { return time_number(kTimes + durations + i); });
    add_time("final_time", 2, [&](int) { return graph_.constant(1); });
  }

  void add_operands() {
    int row = 0;
    for (std::size_t i = 0; i < text_.operands.size(); ++i) {
      const ExpressionOperand& operand = text_.operands[i];
      ExpressionValue value = ExpressionValue::vector({});
      for (const std::string& name : operand.rows) {
        value.parts.push_back({name, value.size()});
        value.nodes.push_back(input(KnotInputSource::Kind::kOperand, row++));
      }
      // A single row is a number, which may also be addressed by its part.
      if (value.size() == 1) value.kind = ExpressionValue::Kind::kNumber;
      texts_.add(Part::kOperand, static_cast<int>(i), operand.name, std::move(value));
    }
  }

  void read_row(int index) {
    const auto value = texts_.parse(Part::kRow, index, text_.rows[index]);
    if (!value) return;
    if (value->kind == ExpressionValue::Kind::kCondition)
      return texts_.report_text(
          Part::kRow, index, "a row of a residual is a number or a vector, and this is a condition",
          "write its left side, and the right one as bound: 'rows: x', 'upper: 1'");
    out_.rows.push_back(value->size());
    for (const NodeId node : value->nodes) {
      if (!text_.constants && !moves(node))
        return texts_.report_text(
            Part::kRow, index,
            "a row of a residual depends on the state or the control, and this does not");
      outputs_.push_back(node);
    }
  }

  /// True if the node depends on the state or the control.
  bool moves(NodeId root) const {
    const std::vector<NodeId> below = nodes_below(graph_, {&root, 1});
    return std::any_of(below.begin(), below.end(), [&](NodeId id) {
      const ExpressionNode& node = graph_[id];
      return node.operation == Operation::kInput &&
             sources_[node.payload].kind != KnotInputSource::Kind::kParameter;
    });
  }

  /// Parameters are the references, followed by the times.
  void subtract_references() {
    const int rows = static_cast<int>(outputs_.size());
    for (int i = 0; i < rows; ++i)
      outputs_[i] = graph_.subtract(outputs_[i], input(KnotInputSource::Kind::kParameter, i));
    for (KnotInputSource& source : sources_)
      if (source.kind == KnotInputSource::Kind::kParameter && source.index <= kFirstTime)
        source.index = rows + kFirstTime - source.index;
  }

  void make() {
    subtract_references();
    std::vector<int> input_of(manifold_.nx());
    std::iota(input_of.begin(), input_of.end(), 0);
    InputMotions motions = tangent_motions(graph_, manifold_, input_of);
    motions.resize(sources_.size());
    int first_operand = manifold_.ndx();
    for (const KnotInputSource& source : sources_)
      if (source.kind == KnotInputSource::Kind::kControl) {
        const int column = manifold_.ndx() + source.index;
        motions[source.input].push_back({column, graph_.constant(1)});
        first_operand = std::max(first_operand, column + 1);
      }
    for (const KnotInputSource& source : sources_)
      if (source.kind == KnotInputSource::Kind::kOperand)
        motions[source.input].push_back({first_operand + source.index, graph_.constant(1)});
    const int inputs = static_cast<int>(sources_.size());
    if (count_derivatives(graph_, outputs_, motions) > kMostDerivatives)
      return texts_.report(Part::kRow, 0, "the expressions of the residual are too large");
    DifferentiableExpressions functions(graph_, outputs_, inputs, motions);
    Operands operands(text_.operands);
    if (functions.with_derivatives().registers() + operands.numbers() > kMostStackNumbers)
      return texts_.report(
          Part::kRow, 0,
          fmt::format("the expressions need more than {} intermediate results", kMostStackNumbers),
          "rows can be residuals of their own");
    drop_unused();
    const int rows = static_cast<int>(outputs_.size());
    out_.reads_time = std::ranges::any_of(sources_, [&](const KnotInputSource& s) {
      return s.kind == KnotInputSource::Kind::kParameter && s.index >= rows;
    });
    const int times = kTimes + 2 * static_cast<int>(text_.durations.size());
    std::vector<std::string> tables;
    for (const auto& [name, table] : text_.tables) tables.push_back(name);
    std::vector<bool> chooses;
    for (const NodeId& row : outputs_) chooses.push_back(has_choice(graph_, {&row, 1}));
    out_.residual = std::make_shared<ExpressionResidual>(
        std::move(functions), chooses, sources_, rows + (out_.reads_time ? times : 0),
        std::move(operands), first_operand, TableArguments(graph_, outputs_, inputs, tables));
  }

  /// Drops inputs that neither values nor derivatives read. A quaternion is read as a whole,
  /// because its numbers change together.
  void drop_unused() {
    const std::vector<NodeId> below = nodes_below(graph_, outputs_);
    std::vector<bool> used(sources_.size(), false);
    for (const NodeId id : below)
      if (graph_[id].operation == Operation::kInput) used[graph_[id].payload] = true;
    for (const StateManifold::Segment& segment : manifold_.curved()) {
      const auto begin = used.begin() + segment.x, end = begin + segment.n + 1;
      if (std::find(begin, end, true) != end) std::fill(begin, end, true);
    }
    std::erase_if(sources_, [&](const KnotInputSource& source) { return !used[source.input]; });
  }

  const StateManifold& manifold_;
  const ExpressionResidualText& text_;
  ParsedExpressionResidual& out_;
  ExpressionGraph graph_;
  ModelTextReader texts_;
  std::vector<KnotInputSource> sources_;
  std::vector<NodeId> outputs_;
  static constexpr int kTimes = 3;       ///< t, phase_time and final_time
  static constexpr int kFirstTime = -1;  ///< index of the first time until references are counted
};

/// Adds columns of a system to the names: alone, or as an element of a group.
void add_columns(const System& system, bool of_control, std::vector<KnotName>& names) {
  const std::vector<Column>& columns =
      of_control ? system.control_columns() : system.state_columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!of_control && !system.has_state(static_cast<int>(i))) continue;
    const std::string& column = columns[i].name;
    const KnotName::Number number{of_control, static_cast<int>(i)};
    const std::size_t slash = column.find('/');
    if (slash != std::string::npos && columns[i].by_name_only) continue;  // durations
    if (slash == std::string::npos) {
      names.push_back({column, columns[i].unit, {number}, {}});
      continue;
    }
    const std::string group = column.substr(0, slash);
    auto found = std::find_if(names.begin(), names.end(),
                              [&](const KnotName& name) { return name.name == group; });
    if (found == names.end()) {
      names.push_back({group, "", {}, {}});
      found = std::prev(names.end());
    }
    found->parts.push_back({column.substr(slash + 1), static_cast<int>(found->numbers.size())});
    found->numbers.push_back(number);
  }
}

/// A pose or a twist, recognized by some of its elements, and its vectors.
struct SpatialParts {
  struct Part {
    int at;
    std::string_view name;
    int size = 1;
  };
  Part told_by[3], vectors[2];
};
constexpr SpatialParts kSpatialParts[] = {
    {{{0, "x"}, {3, "qx"}, {6, "qw"}}, {{0, "position", 3}, {3, "rotation", 4}}},
    {{{0, "vx"}, {3, "wx"}, {5, "wz"}}, {{0, "linear", 3}, {3, "angular", 3}}}};

/// Adds vectors of three and four numbers as parts of poses and twists.
void add_vectors(KnotName& name) {
  const int elements = static_cast<int>(name.parts.size());
  for (int first = 0; first < elements; ++first)
    for (const SpatialParts& whole : kSpatialParts) {
      const bool here = std::ranges::all_of(whole.told_by, [&](const SpatialParts::Part& part) {
        return first + part.at < elements && name.parts[first + part.at].name == part.name;
      });
      if (!here) continue;
      for (const SpatialParts::Part& part : whole.vectors)
        name.parts.push_back({std::string(part.name), first + part.at, part.size});
    }
}

}  // namespace

std::vector<KnotName> knot_names(const System& system) {
  std::vector<KnotName> names;
  add_columns(system, false, names);
  add_columns(system, true, names);
  for (KnotName& name : names) add_vectors(name);
  return names;
}

ParsedExpressionResidual make_expression_residual(const StateManifold& manifold,
                                                  const ExpressionResidualText& text) {
  ParsedExpressionResidual parsed;
  ResidualReader(manifold, text, parsed).read();
  return parsed;
}

}  // namespace conddp
